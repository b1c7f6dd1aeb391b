//! Programs for a microcontroller, in words for cargo and its compiler.

use cli::cross::TARGET;

/// The firmware of the STM32H743, outside the workspace.
pub const H743: &[&str] = &[
    "--manifest-path",
    "examples/firmware/h743/Cargo.toml",
    "--config",
    "examples/firmware/h743/.cargo/config.toml",
];

/// The images of this package, for the core of the STM32F405.
pub const IMAGES: &[&str] = &["-p", "lab", "--target", TARGET];

/// Images that need neither a chip nor a log: built without.
pub const BARE: &[&str] = &["-p", "lab", "--no-default-features", "--target", TARGET];

/// Flags for [`BARE`]: these take the place of the configuration's, so that the linker script is named again.
pub const BARE_FLAGS: &[&str] = &["-Ctarget-cpu=cortex-m4", "-Clink-arg=-Tlink.x"];
