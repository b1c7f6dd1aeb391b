#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: judge::laws::spindles::Run| {
    judge::laws::spindles::check(&run);
});
