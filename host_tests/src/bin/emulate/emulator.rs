//! The emulated board while it runs: bytes for its serial port in, lines of its log out.

use crate::firmware::Firmware;
use crate::toolchain;
use anyhow::{Context, Result, anyhow, bail};
use defmt_decoder::{DecodeError, StreamDecoder, Table};
use std::io::{Read, Write};
use std::process::{Child, ChildStdin, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// A running board. Ends with its owner.
pub struct Board<'t> {
    child: Child,
    port: ChildStdin,
    bytes: Receiver<Vec<u8>>,
    complaints: Receiver<String>,
    decoder: Box<dyn StreamDecoder + Send + Sync + 't>,
    patience: Duration,
}

/// The table that turns the firmware's log back into text.
pub fn table(firmware: &Firmware) -> Result<Table> {
    Table::parse(&firmware.elf)?
        .with_context(|| format!("{} has no table of defmt messages", firmware.path.display()))
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

impl<'t> Board<'t> {
    /// Switches the board on.
    pub fn start(
        emulator: &toolchain::Emulator,
        firmware: &Firmware,
        table: &'t Table,
        patience: Duration,
    ) -> Result<Self> {
        let mut child = emulator
            .command()
            .args(["-monitor", "none"])
            // The emulator takes a byte only when the receiver's register is free, so that its
            // standard input holds back what the firmware has not taken.
            .args(["-chardev", "stdio,id=port,signal=off"])
            .args(["-serial", "chardev:port"])
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
        Ok(Self {
            child,
            port,
            bytes: pump(output),
            complaints,
            decoder: table.new_stream_decoder(),
            patience,
        })
    }

    /// Sends bytes to the serial port.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        let sent = self.port.write_all(bytes).and_then(|()| self.port.flush());
        sent.map_err(|error| self.post_mortem(&format!("cannot be sent to ({error})")))
    }

    /// The next line of the board's log.
    pub fn line(&mut self) -> Result<String> {
        let deadline = Instant::now() + self.patience;
        loop {
            match self.decoder.decode() {
                Ok(frame) => return Ok(frame.display_message().to_string()),
                Err(DecodeError::Malformed) => bail!(
                    "the board's log cannot be decoded: the firmware writes it wrongly, or is not \
                     the one that was built"
                ),
                Err(DecodeError::UnexpectedEof) => {}
            }
            let left = deadline.saturating_duration_since(Instant::now());
            match self.bytes.recv_timeout(left) {
                Ok(bytes) => self.decoder.received(&bytes),
                Err(RecvTimeoutError::Timeout) => bail!(
                    "the board has been silent for {:.0} s: the firmware hangs, or this machine is \
                     very busy (then try a longer --patience)",
                    self.patience.as_secs_f64()
                ),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(self.post_mortem("stopped"));
                }
            }
        }
    }

    /// What is to be said of an emulator that has gone.
    fn post_mortem(&mut self, how: &str) -> anyhow::Error {
        let _ = self.child.kill();
        let status = self
            .child
            .wait()
            .map_or_else(|error| error.to_string(), |status| status.to_string());
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

impl Drop for Board<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
