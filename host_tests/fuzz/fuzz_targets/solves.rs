#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: laws::solves::Run| {
    laws::solves::check(&run);
});
