#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: judge::laws::solves::Run| {
    judge::laws::solves::check(&run);
});
