//! An emulated board while it runs a firmware: bytes into its port and out of it, and lines of its log.

use crate::cross::{self, Missing, output};
use anyhow::{Context, Result, anyhow, bail, ensure};
use defmt_decoder::{DecodeError, Table};
use object::{Object, ObjectSection, ObjectSymbol};
use std::fs;
use std::io::{self, Read, Write};
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The emulator's command.
const QEMU: &str = "qemu-system-arm";
/// The emulator's board with an STM32F405.
pub const MACHINE: &str = "netduinoplus2";
/// First major version of QEMU whose serial port keeps a byte until it is read (QEMU's commit ab08c3467605, "Fix STM32F2XX
/// USART data register readout"). Before, a byte that waits behind it is given in its place.
const KEEPS_READ_BYTES: u32 = 7;
/// Byte that the emulator's multiplexer takes for the start of a command of its own, unless it comes twice.
const ESCAPE: u8 = 0x01;

fn version() -> Option<String> {
    output(Command::new(QEMU).arg("--version"))
}

/// Sees to it that there is an emulator, and installs it where that is allowed.
///
/// # Errors
///
/// How to install it by hand.
pub fn find() -> Result<()> {
    if version().is_none() {
        cross::install(&Missing {
            what: QEMU,
            debian: &[QEMU],
            elsewhere: "Fedora: dnf install qemu-system-arm; Arch: pacman -S qemu-system-arm; \
                        macOS: brew install qemu",
        })?;
    }
    version().with_context(|| format!("{QEMU} does not run"))?;
    Ok(())
}

/// The first number of what QEMU says of its version: `QEMU emulator version 7.2.22 (Debian ...)`.
fn major(text: &str) -> Option<u32> {
    let (_, version) = text.split_once("version ")?;
    version.split('.').next()?.parse().ok()
}

/// A firmware ready to run.
pub struct Firmware {
    path: PathBuf,
    elf: Vec<u8>,
}

impl Firmware {
    /// Reads the ELF at this path.
    ///
    /// # Errors
    ///
    /// It cannot be read.
    pub fn read(path: PathBuf) -> Result<Self> {
        let elf = fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Self { path, elf })
    }

    /// The same, whose stack has so many bytes alone.
    ///
    /// # Errors
    ///
    /// It is no firmware, or cannot be written.
    pub fn with_stack(&self, bytes: u32) -> Result<Self> {
        let file = object::File::parse(&*self.elf)?;
        let end = file.symbols().find(|of| of.name() == Ok("_stack_end"));
        let end = end.context("the firmware does not say where its stack ends")?;
        let vectors = file.section_by_name(".vector_table");
        let (at, _) = vectors
            .and_then(|section| section.file_range())
            .context("the firmware has no vectors")?;
        // The first of them is where the stack begins.
        let mut elf = self.elf.clone();
        let start = (end.address() as u32 + bytes).to_le_bytes();
        elf.splice(at as usize..at as usize + start.len(), start);
        let path = self.path.with_extension("short");
        fs::write(&path, &elf).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { path, elf })
    }

    /// The table that turns its log back into text.
    ///
    /// # Errors
    ///
    /// It has none.
    pub fn messages(&self) -> Result<Table> {
        Table::parse(&self.elf)?
            .with_context(|| format!("{} has no table of defmt messages", self.path.display()))
    }
}

/// A program that the system kills when its starting thread is gone, for whatever reason. Linux can
/// do that, and its util-linux has a command for it.
fn tied(program: &str) -> Command {
    let mut command = Command::new("setpriv");
    command.args(["--pdeathsig", "KILL", program]);
    command
}

/// `input` with every [`ESCAPE`] twice, which the multiplexer turns back into one.
fn escaped(input: &[u8]) -> Vec<u8> {
    let sent = input.iter().map(|byte| match *byte {
        ESCAPE => &[ESCAPE; 2][..],
        _ => std::slice::from_ref(byte),
    });
    sent.flatten().copied().collect()
}

/// A running board. Ends with its owner.
pub struct Board {
    running: Child,
    port: Option<ChildStdin>,
    is_multiplexed: bool,
    bytes: Receiver<Vec<u8>>,
    log: Receiver<Vec<u8>>,
}

/// End of the line of a board that starts again, after a panic or a fault.
pub const AGAIN: &str = "starting again";

/// Lines of a log among which one is waited for: those of some starts.
const MOST_LINES: usize = 50;

/// Longest silence of a board that runs.
const PATIENCE: Duration = Duration::from_secs(60);

/// Bytes of `source`, which a thread of its own opens and reads to the end.
fn pumped<S: Read>(open: impl FnOnce() -> io::Result<S> + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let Ok(mut source) = open() else { return };
        let mut buffer = [0; 4096];
        while let Ok(length @ 1..) = source.read(&mut buffer) {
            if sender.send(buffer[..length].to_vec()).is_err() {
                break;
            }
        }
    });
    receiver
}

impl Board {
    /// Switches the board on.
    ///
    /// # Errors
    ///
    /// The emulator does not start.
    pub fn start(firmware: &Firmware) -> Result<Self> {
        // The second port, which the emulator reaches by a socket of this machine.
        let listener =
            TcpListener::bind(("127.0.0.1", 0)).context("cannot listen to the emulator's log")?;
        let log = format!(
            "socket,id=log,host=127.0.0.1,port={},server=off,nodelay=on",
            listener.local_addr()?.port()
        );
        let is_tied = cfg!(target_os = "linux") && output(&mut tied("true")).is_some();
        let mut command = match is_tied {
            true => tied(QEMU),
            false => Command::new(QEMU),
        };
        // The emulator's main loop reads standard input a byte per turn, and only while there is room for
        // it. Bytes that the firmware has not taken stay in the pipe. If the room is the receiver's register, the
        // firmware waits a turn for every byte. If it is a multiplexer's queue of 32 bytes, a read of that
        // register fetches the next byte at once.
        let version = version().unwrap_or_default();
        let is_multiplexed = major(&version).is_some_and(|major| major >= KEEPS_READ_BYTES);
        let mux = if is_multiplexed { "on" } else { "off" };
        let mut running = command
            .args(["-machine", MACHINE, "-display", "none", "-monitor", "none"])
            .args(["-chardev", &format!("stdio,id=port,signal=off,mux={mux}")])
            .args(["-echr", &ESCAPE.to_string()])
            .args(["-serial", "chardev:port"])
            .args(["-chardev", &log])
            .args(["-serial", "chardev:log"])
            // A program may end the run.
            .arg("-semihosting")
            .arg("-kernel")
            .arg(&firmware.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("cannot start the emulator")?;
        let port = running.stdin.take();
        let output = running.stdout.take();
        let output = output.context("the emulator's serial port cannot be reached")?;
        Ok(Self {
            running,
            port,
            is_multiplexed,
            bytes: pumped(|| Ok(output)),
            log: pumped(move || Ok(listener.accept()?.0)),
        })
    }

    /// Sends bytes to the port, once, as fast as the board takes them.
    pub fn send(&mut self, input: &[u8]) {
        let Some(mut port) = self.port.take() else {
            return;
        };
        let input = if self.is_multiplexed {
            escaped(input)
        } else {
            input.to_vec()
        };
        thread::spawn(move || {
            // An emulator that has gone is told of by what it does not answer.
            if port.write_all(&input).and_then(|()| port.flush()).is_ok() {
                // The end of its input must not become one of its output.
                thread::sleep(Duration::MAX);
            }
        });
    }

    /// The next bytes of the telemetry.
    ///
    /// # Errors
    ///
    /// The board is silent, or the emulator has stopped.
    pub fn bytes(&mut self) -> Result<Vec<u8>> {
        let bytes = self.bytes.recv_timeout(PATIENCE);
        bytes.map_err(|error| self.post_mortem(error))
    }

    /// Waits for a line of the log that begins so.
    ///
    /// # Errors
    ///
    /// The board is silent, says much else, or the emulator has stopped; the log is none of this firmware.
    pub fn wait_for_line(&mut self, log: &mut Log<'_>, line: &str) -> Result<()> {
        while !log.lines.iter().any(|said| said.starts_with(line)) {
            ensure!(log.lines.len() < MOST_LINES, "the board never says: {line}");
            let bytes = self.log.recv_timeout(PATIENCE);
            log.take(&bytes.map_err(|error| self.post_mortem(error))?)?;
        }
        Ok(())
    }

    /// Prints the log until the program ends the run; returns its status.
    ///
    /// # Errors
    ///
    /// The board is silent or starts again; the log is none of this firmware.
    pub fn print_log(mut self, mut log: Log<'_>) -> Result<ExitStatus> {
        loop {
            match self.log.recv_timeout(PATIENCE) {
                Ok(bytes) => log.take(&bytes)?,
                Err(RecvTimeoutError::Disconnected) => return Ok(self.running.wait()?),
                Err(error) => return Err(self.post_mortem(error)),
            }
            for line in log.lines.drain(..) {
                ensure!(!line.ends_with(AGAIN), "the board says: {line}");
                println!("{line}");
            }
        }
    }

    /// Takes the part of the log that is there.
    ///
    /// # Errors
    ///
    /// The log is none of this firmware.
    pub fn read_log(&mut self, log: &mut Log<'_>) -> Result<()> {
        self.log.try_iter().try_for_each(|bytes| log.take(&bytes))
    }

    /// The error for an emulator that has fallen silent.
    fn post_mortem(&mut self, error: RecvTimeoutError) -> anyhow::Error {
        if error == RecvTimeoutError::Timeout {
            return anyhow!(
                "the board has been silent for {} s: the firmware hangs, or this machine is very busy",
                PATIENCE.as_secs()
            );
        }
        let _ = self.running.kill();
        let status = self.running.wait();
        let status = status.map_or_else(|error| error.to_string(), |status| status.to_string());
        anyhow!("the emulator stopped, and what it said is above; {status}")
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        let _ = self.running.kill();
        let _ = self.running.wait();
    }
}

/// The board's log as text.
pub struct Log<'t> {
    decoder: Box<dyn defmt_decoder::StreamDecoder + Send + Sync + 't>,
    /// Its lines so far.
    pub lines: Vec<String>,
}

impl<'t> Log<'t> {
    /// With the firmware's table of messages.
    pub fn new(table: &'t Table) -> Self {
        Self {
            decoder: table.new_stream_decoder(),
            lines: Vec::new(),
        }
    }

    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        self.decoder.received(bytes);
        loop {
            match self.decoder.decode() {
                Ok(frame) => self.lines.push(frame.display_message().to_string()),
                Err(DecodeError::UnexpectedEof) => return Ok(()),
                Err(DecodeError::Malformed) => bail!(
                    "the board's log cannot be decoded: the firmware writes it wrongly, or is not \
                     the one that was built"
                ),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_major_version_is_found_in_what_each_distribution_says() {
        for (text, expected) in [
            (
                "QEMU emulator version 7.2.22 (Debian 1:7.2+dfsg-7)\n(c) 2003",
                Some(7),
            ),
            ("QEMU emulator version 10.0.2", Some(10)),
            ("another program", None),
        ] {
            assert_eq!(major(text), expected);
        }
    }

    #[test]
    fn an_escape_is_sent_twice_and_every_other_byte_once() {
        assert_eq!(
            escaped(&[0, 1, 1, 2, 255, 1]),
            [0, 1, 1, 1, 1, 2, 255, 1, 1]
        );
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_tied_program_does_not_outlive_its_parent() {
        use std::io::BufRead;
        use std::os::unix::process::ExitStatusExt;
        if output(&mut tied("true")).is_none() {
            eprintln!(
                "no setpriv on this machine: an emulator may outlive a program that is killed"
            );
            return;
        }
        // The thread stays until the program has spoken: before, it may not be tied yet.
        let start = || {
            let mut child = tied("sh")
                .args(["-c", "echo tied; exec sleep 10"])
                .stdout(Stdio::piped())
                .spawn()
                .unwrap();
            let mut said = std::io::BufReader::new(child.stdout.take().unwrap());
            said.read_line(&mut String::new()).unwrap();
            child
        };
        let mut child = thread::spawn(start).join().unwrap();
        assert_eq!(child.wait().unwrap().signal(), Some(9));
    }
}
