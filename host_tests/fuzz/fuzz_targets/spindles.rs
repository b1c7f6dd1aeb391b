#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|run: laws::spindles::Run| {
    laws::spindles::check(&run);
});
