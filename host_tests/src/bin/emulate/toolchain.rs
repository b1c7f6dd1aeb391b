//! What the run needs on this machine: found, or installed where that is allowed.

use crate::firmware::TARGET;
use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::{Command, Stdio};

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

/// What a command prints; `None` if it cannot be run, or fails.
fn output(command: &mut Command) -> Option<String> {
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Runs a command in the open, and fails if it does.
fn run(command: &mut Command) -> Result<()> {
    let name = format!("{command:?}").replace('"', "");
    let status = command
        .stdin(Stdio::null())
        .status()
        .with_context(|| format!("cannot run `{name}`"))?;
    if !status.success() {
        bail!("`{name}` ended with {status}");
    }
    Ok(())
}

/// Adds the Rust target of the firmware, unless it is there.
pub fn add_target(root: &Path) -> Result<()> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let libraries = output(
        Command::new(rustc)
            .args(["--print", "target-libdir", "--target", TARGET])
            .current_dir(root),
    );
    if libraries.is_some_and(|path| Path::new(&path).is_dir()) {
        return Ok(());
    }
    if output(Command::new("rustup").arg("--version")).is_none() {
        bail!(
            "Rust's target {TARGET} is missing, and there is no rustup to add it; install it the \
             way Rust was installed, then try again"
        );
    }
    eprintln!("installing Rust's target {TARGET}: rustup target add {TARGET}");
    run(Command::new("rustup")
        .args(["target", "add", TARGET])
        .current_dir(root))
    .context("the Rust target could not be added; is there a network?")
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
