#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: judge::laws::port::Run| {
    judge::laws::port::check(&run);
});
