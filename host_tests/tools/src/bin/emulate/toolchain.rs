//! The emulator on this machine: found, or installed where that is allowed.

use anyhow::{Context, Result, bail};
use std::process::Command;
use tools::cross::{self, Missing, output};

/// The emulator's command.
const QEMU: &str = "qemu-system-arm";
/// Machines with an STM32F405, the first choice first: the second came with QEMU 8.
const MACHINES: [&str; 2] = ["netduinoplus2", "olimex-stm32-h405"];
/// First major version of QEMU whose serial port gives the byte that is read, and not the next one, where the
/// next one is there already (QEMU's commit ab08c3467605, "Fix STM32F2XX USART data register readout").
const KEEPS_READ_BYTES: u32 = 7;

/// An emulator that knows the chip.
pub struct Emulator {
    /// Name of the machine.
    pub machine: &'static str,
    /// Its serial port may have the next byte at hand when one is read.
    pub keeps_read_bytes: bool,
    /// There is a program that ties it to this one.
    tied: bool,
}

impl Emulator {
    /// The command that starts it, still without firmware.
    pub fn command(&self) -> Command {
        let mut command = if self.tied {
            tied(QEMU)
        } else {
            Command::new(QEMU)
        };
        command.args(["-machine", self.machine, "-display", "none"]);
        command
    }
}

/// A program that the system kills when the thread that has started it is gone, for whatever reason: Linux
/// can do that, and its util-linux has a command for it.
fn tied(program: &str) -> Command {
    let mut command = Command::new("setpriv");
    command.args(["--pdeathsig", "KILL", program]);
    command
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
        Some(machine) => Ok(Emulator {
            machine,
            keeps_read_bytes: output(Command::new(QEMU).arg("--version"))
                .and_then(|text| major_version(&text))
                .is_some_and(|major| major >= KEEPS_READ_BYTES),
            tied: cfg!(target_os = "linux") && output(&mut tied("true")).is_some(),
        }),
        None => bail!(
            "this {QEMU} knows none of the machines {}; install QEMU 5 or later",
            MACHINES.join(", ")
        ),
    }
}

/// The first number of what QEMU says of its version: `QEMU emulator version 7.2.22 (Debian ...)`.
fn major_version(text: &str) -> Option<u32> {
    let (_, version) = text.split_once("version ")?;
    version.split('.').next()?.parse().ok()
}

fn install_emulator() -> Result<()> {
    cross::install(&Missing {
        what: QEMU,
        debian: &[QEMU],
        elsewhere: "Fedora: dnf install qemu-system-arm; Arch: pacman -S qemu-system-arm; \
                    macOS: brew install qemu",
    })
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::ExitStatusExt;
    use std::process::Stdio;
    use std::thread;
    use std::time::{Duration, Instant};

    #[test]
    fn the_major_version_is_found_in_what_each_distribution_says() {
        let debian =
            "QEMU emulator version 7.2.22 (Debian 1:7.2+dfsg-7+deb12u18+b3)\nCopyright (c) 2003";
        assert_eq!(major_version(debian), Some(7));
        assert_eq!(major_version("QEMU emulator version 10.0.2"), Some(10));
        assert_eq!(
            major_version("QEMU emulator version 6.2.0 (qemu-6.2.0-1)"),
            Some(6)
        );
        assert_eq!(major_version("another program"), None);
    }

    #[test]
    fn a_tied_program_does_not_outlive_who_has_started_it() {
        if output(&mut tied("true")).is_none() {
            eprintln!(
                "no setpriv on this machine: only signals that can be caught end the emulator"
            );
            return;
        }
        // The thread stays until the program has spoken: before, it may not be tied yet.
        let start = || {
            let mut child = tied("sh")
                .args(["-c", "echo tied; exec sleep 60"])
                .stdout(Stdio::piped())
                .spawn()
                .unwrap();
            let mut spoken = String::new();
            let mut said = BufReader::new(child.stdout.take().unwrap());
            said.read_line(&mut spoken).unwrap();
            assert_eq!(spoken, "tied\n");
            child
        };
        let mut child = thread::spawn(start).join().unwrap();
        let began = Instant::now();
        let status = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status;
            }
            assert!(began.elapsed() < Duration::from_secs(10), "it still runs");
            thread::sleep(Duration::from_millis(10));
        };
        assert_eq!(status.signal(), Some(9));
    }
}
