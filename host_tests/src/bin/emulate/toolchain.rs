//! The emulator on this machine: found, or installed where that is allowed.

use anyhow::{Context, Result, bail};
use host_tests::cross::{output, run};
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
    let by_hand = format!("apt-get update && apt-get install {QEMU}");
    if !is_debian() {
        bail!(
            "{QEMU} is missing. Install it, then try again. Debian and Ubuntu: {by_hand}; \
             Fedora: dnf install qemu-system-arm; Arch: pacman -S qemu-system-arm; \
             macOS: brew install qemu"
        );
    }
    let root = output(Command::new("id").arg("-u")).as_deref() == Some("0");
    if !root && output(Command::new("sudo").args(["-n", "true"])).is_none() {
        bail!(
            "{QEMU} is missing, and installing it needs a password. Run this, then try again: \
             sudo sh -c '{by_hand}'"
        );
    }
    let apt = |arguments: &[&str]| {
        let mut command = if root {
            Command::new("env")
        } else {
            let mut command = Command::new("sudo");
            command.args(["-n", "env"]);
            command
        };
        command
            .args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "-q"])
            .args(arguments)
            // Standard output is for the estimates.
            .stdout(std::io::stderr());
        run(&mut command)
    };
    eprintln!("installing Debian's package {QEMU}: {by_hand}");
    // One source that does not answer fails the update, though the package may well be there.
    if let Err(error) = apt(&["update"]) {
        eprintln!("warning: {error:#}");
    }
    apt(&["install", "-y", "--no-install-recommends", QEMU])
        .with_context(|| format!("{QEMU} could not be installed; try by hand: {by_hand}"))
}

/// Debian, Ubuntu, and what is made from them.
fn is_debian() -> bool {
    let release = std::fs::read_to_string("/etc/os-release").unwrap_or_default();
    release
        .lines()
        .filter_map(|line| line.split_once('='))
        .filter(|(key, _)| matches!(*key, "ID" | "ID_LIKE"))
        .flat_map(|(_, value)| value.trim_matches('"').split_whitespace())
        .any(|id| matches!(id, "debian" | "ubuntu"))
}
