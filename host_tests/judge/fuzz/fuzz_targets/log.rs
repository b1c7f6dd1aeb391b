#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: judge::laws::log::Run| {
    judge::laws::log::check(&run);
});
