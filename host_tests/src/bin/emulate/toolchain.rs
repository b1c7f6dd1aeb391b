//! The emulator on this machine: found, or installed where that is allowed.

use anyhow::{Context, Result, bail};
use host_tests::cross::{self, Missing, output};
use std::process::Command;

/// The emulator's command.
const QEMU: &str = "qemu-system-arm";
/// Machines with an STM32F405, the first choice first: the second came with QEMU 8.
const MACHINES: [&str; 2] = ["netduinoplus2", "olimex-stm32-h405"];

/// An emulator that knows the chip.
pub struct Emulator {
    /// Name of the machine.
    pub machine: &'static str,
}

impl Emulator {
    /// The command that starts it, still without firmware.
    pub fn command(&self) -> Command {
        let mut command = Command::new(QEMU);
        command.args(["-machine", self.machine, "-display", "none"]);
        command
    }
}

/// Finds the emulator, installing it first where it is missing and that is allowed.
pub fn find_emulator() -> Result<Emulator> {
    let machines = || output(Command::new(QEMU).args(["-machine", "help"]));
    let known = match machines() {
        Some(known) => known,
        None => {
            install_emulator()?;
            machines().with_context(|| format!("{QEMU} was installed, but does not run"))?
        }
    };
    let machine = MACHINES.into_iter().find(|name| {
        known
            .lines()
            .any(|line| line.split_whitespace().next() == Some(name))
    });
    match machine {
        Some(machine) => Ok(Emulator { machine }),
        None => bail!(
            "this {QEMU} knows none of the machines {}; install QEMU 5 or later",
            MACHINES.join(", ")
        ),
    }
}

fn install_emulator() -> Result<()> {
    cross::install(&Missing {
        what: QEMU,
        debian: &[QEMU],
        elsewhere: "Fedora: dnf install qemu-system-arm; Arch: pacman -S qemu-system-arm; \
                    macOS: brew install qemu",
    })
}
