//! Programs for a microcontroller, in words for cargo and its compiler.

use cli::cross::TARGET;

/// The firmware of the STM32H743.
pub const H743: &[&str] = &[
    "-p",
    "spindle_firmware",
    "--features",
    "h743",
    "--config",
    "examples/firmware/h743/config.toml",
    "--target",
    TARGET,
];

/// The bench of the STM32H743, likewise.
pub const BENCH_H743: &[&str] = &[
    "-p",
    "lab",
    "--no-default-features",
    "--features",
    "h743",
    "--config",
    "examples/firmware/h743/config.toml",
    "--target",
    TARGET,
];

/// The images of this package, for the core of the STM32F405.
pub const IMAGES: &[&str] = &["-p", "lab", "--target", TARGET];

/// Images that need neither a chip nor a log: built without.
pub const BARE: &[&str] = &["-p", "lab", "--no-default-features", "--target", TARGET];

/// Flags for [`BARE`]: these take the place of the configuration's, so that the linker script is named again.
pub const BARE_FLAGS: &[&str] = &[
    "-Ctarget-cpu=cortex-m4",
    "-Clink-arg=-Tlink.x",
    "-Clink-arg=-Lexamples/firmware/f405",
];
