//! The emulated board while it runs: bytes into its port and out of it, and lines of its log.

use crate::firmware::Firmware;
use crate::toolchain;
use anyhow::{Context, Result, anyhow, bail};
use defmt_decoder::{DecodeError, Table};
use std::io::{Read, Write};
use std::net::TcpListener;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Byte that the emulator's multiplexer takes for the start of a command of its own, unless it comes twice.
const ESCAPE: u8 = 0x01;

/// The emulator that runs, for whoever has to end it.
static RUNNING: Mutex<Option<Child>> = Mutex::new(None);

/// Ends the emulator, if one runs; returns how it ended.
fn end() -> Option<String> {
    let mut running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut child = running.take()?;
    let _ = child.kill();
    Some(
        child
            .wait()
            .map_or_else(|error| error.to_string(), |status| status.to_string()),
    )
}

/// Has signals that ask this program to end, end the emulator first, and leave the terminal as it was.
pub fn end_on_signals() -> Result<()> {
    ctrlc::set_handler(|| {
        end();
        if ratatui::crossterm::terminal::is_raw_mode_enabled().unwrap_or(false) {
            ratatui::restore();
        }
        // As shells have it of a program that was interrupted.
        std::process::exit(130)
    })
    .context("signals cannot be handled")
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
    port: Option<ChildStdin>,
    /// A multiplexer is between the port and the board.
    multiplexed: bool,
    bytes: Receiver<Vec<u8>>,
    log: Receiver<Vec<u8>>,
    complaints: Receiver<String>,
    patience: Duration,
}

/// Hands on what `source` gives until it ends, from a thread of its own.
fn pump(mut source: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
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
    pub fn start(
        emulator: &toolchain::Emulator,
        firmware: &Firmware,
        patience: Duration,
    ) -> Result<Self> {
        // The second port, which the emulator reaches by a socket of this machine.
        let listener =
            TcpListener::bind(("127.0.0.1", 0)).context("cannot listen to the emulator's log")?;
        let log = format!(
            "socket,id=log,host=127.0.0.1,port={},server=off,nodelay=on",
            listener.local_addr()?.port()
        );
        // The emulator's main loop reads standard input a byte per turn, and only while there is room for
        // that byte: what the firmware has not taken stays in the pipe. Without a multiplexer the room is
        // the receiver's register, so that the firmware waits a turn for every byte. A multiplexer has a
        // queue of 32 bytes, from which a read of that register fetches the next byte at once.
        let multiplexed = emulator.keeps_read_bytes;
        let port = if multiplexed {
            "stdio,id=port,signal=off,mux=on"
        } else {
            "stdio,id=port,signal=off"
        };
        let mut child = emulator
            .command()
            .args(["-monitor", "none"])
            .args(["-chardev", port])
            .args(["-echr", &ESCAPE.to_string()])
            .args(["-serial", "chardev:port"])
            .args(["-chardev", &log])
            .args(["-serial", "chardev:log"])
            .arg("-kernel")
            .arg(&firmware.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .context("cannot start the emulator")?;
        let (Some(port), Some(output), Some(errors)) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take())
        else {
            bail!("the emulator's serial port cannot be reached");
        };
        let (sender, complaints) = mpsc::channel();
        let errors = pump(errors);
        thread::spawn(move || {
            let all: Vec<u8> = errors.into_iter().flatten().collect();
            let _ = sender.send(String::from_utf8_lossy(&all).trim().to_owned());
        });
        let (sender, log) = mpsc::channel();
        thread::spawn(move || {
            let Ok((socket, _)) = listener.accept() else {
                return;
            };
            for bytes in pump(socket) {
                if sender.send(bytes).is_err() {
                    break;
                }
            }
        });
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = Some(child);
        Ok(Self {
            port: Some(port),
            multiplexed,
            bytes: pump(output),
            log,
            complaints,
            patience,
        })
    }

    /// Sends bytes to the port, once, as fast as the board takes them.
    pub fn send(&mut self, input: Vec<u8>) {
        let Some(mut port) = self.port.take() else {
            return;
        };
        let input = if self.multiplexed {
            escaped(&input)
        } else {
            input
        };
        thread::spawn(move || {
            // An emulator that has gone is told of by what it does not answer.
            let sent = port.write_all(&input).and_then(|()| port.flush());
            if sent.is_ok() {
                // The end of its input must not become one of its output.
                thread::sleep(Duration::MAX);
            }
        });
    }

    /// The next bytes of the telemetry.
    pub fn bytes(&mut self) -> Result<Vec<u8>> {
        match self.bytes.recv_timeout(self.patience) {
            Ok(bytes) => Ok(bytes),
            Err(RecvTimeoutError::Timeout) => bail!(
                "the board has been silent for {:.0} s: the firmware hangs, or this machine is very \
                 busy (then try a longer --patience)",
                self.patience.as_secs_f64()
            ),
            Err(RecvTimeoutError::Disconnected) => Err(self.post_mortem("stopped")),
        }
    }

    /// Waits for the first line of the log.
    pub fn wait_for_log(&mut self, log: &mut Log<'_>) -> Result<()> {
        let deadline = Instant::now() + self.patience;
        while log.lines.is_empty() {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.log.recv_timeout(left) {
                Ok(bytes) => log.take(&bytes)?,
                Err(RecvTimeoutError::Timeout) => bail!("the board has not said that it is ready"),
                Err(RecvTimeoutError::Disconnected) => return Err(self.post_mortem("stopped")),
            }
        }
        Ok(())
    }

    /// Takes what there is of the log.
    pub fn read_log(&mut self, log: &mut Log<'_>) -> Result<()> {
        while let Ok(bytes) = self.log.try_recv() {
            log.take(&bytes)?;
        }
        Ok(())
    }

    /// What is to be said of an emulator that has gone.
    fn post_mortem(&mut self, how: &str) -> anyhow::Error {
        let status = end().unwrap_or_else(|| "it was ended".to_owned());
        let complaint = self
            .complaints
            .recv_timeout(Duration::from_secs(1))
            .unwrap_or_default();
        if complaint.is_empty() {
            anyhow!("the emulator {how}; {status}")
        } else {
            anyhow!("the emulator {how}; {status}; it said: {complaint}")
        }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        end();
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

/// The table that turns the firmware's log back into text.
pub fn table(firmware: &Firmware) -> Result<Table> {
    Table::parse(&firmware.elf)?
        .with_context(|| format!("{} has no table of defmt messages", firmware.path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_escape_is_sent_twice_and_every_other_byte_once() {
        assert_eq!(
            escaped(&[0, 1, 1, 2, 255, 1]),
            [0, 1, 1, 1, 1, 2, 255, 1, 1]
        );
    }
}
