//! The emulator on this machine: found, or installed where that is allowed.

use anyhow::{Context, Result, bail};
use std::process::Command;
use tools::cross::{self, Missing, output};

/// The emulator's command.
const QEMU: &str = "qemu-system-arm";
/// Machines with an STM32F405, the first choice first: the second came with QEMU 8.
const MACHINES: [&str; 2] = ["netduinoplus2", "olimex-stm32-h405"];

/// An emulator that knows the chip.
pub struct Emulator {
    /// Name of the machine.
    pub machine: &'static str,
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
            tied: cfg!(target_os = "linux") && output(&mut tied("true")).is_some(),
        }),
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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};
    use std::os::unix::process::ExitStatusExt;
    use std::process::Stdio;
    use std::thread;
    use std::time::{Duration, Instant};

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
