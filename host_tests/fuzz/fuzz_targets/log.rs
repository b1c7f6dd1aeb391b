#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: laws::log::Run| {
    laws::log::check(&run);
});
