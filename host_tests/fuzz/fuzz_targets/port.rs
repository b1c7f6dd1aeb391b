#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: laws::port::Run| {
    laws::port::check(&run);
});
