//! Where the bytes come from. They are read by a thread of their own, so that a view goes on while
//! nothing comes.

use anyhow::{Context, Result};
use std::fs::File;
use std::io::{self, Read};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;
use std::time::Duration;

/// Chunks that wait before the reader is held back.
const WAITING: usize = 64;

/// Longest wait of the operating system for a byte of a port.
const PORT_TIMEOUT: Duration = Duration::from_millis(100);

/// Chunks of a stream as they come; disconnected at its end. An error is the last that comes.
pub type Chunks = Receiver<io::Result<Vec<u8>>>;

/// Opens a serial port, 8N1.
///
/// # Errors
///
/// The port is not there, not free, or does not know the baud rate.
pub fn port(name: &str, baud: u32) -> Result<Chunks> {
    let port = serialport::new(name, baud)
        .timeout(PORT_TIMEOUT)
        .open()
        .with_context(|| format!("cannot open the serial port {name} at {baud} baud"))?;
    Ok(stream(port))
}

/// Opens a file; `-` is standard input, where an emulator's output can be led to.
///
/// # Errors
///
/// The file cannot be opened.
pub fn file(path: &str) -> Result<Chunks> {
    if path == "-" {
        return Ok(stream(io::stdin()));
    }
    let file = File::open(path).with_context(|| format!("cannot open {path}"))?;
    Ok(stream(file))
}

/// Reads any stream to its end.
pub fn stream(source: impl Read + Send + 'static) -> Chunks {
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    thread::spawn(move || pump(source, &sender));
    receiver
}

fn pump(mut source: impl Read, sender: &SyncSender<io::Result<Vec<u8>>>) {
    let mut buffer = [0; 4096];
    loop {
        let chunk = match source.read(&mut buffer) {
            Ok(0) => return,
            Ok(length) => Ok(buffer[..length].to_vec()),
            // A silent port.
            Err(error)
                if matches!(
                    error.kind(),
                    io::ErrorKind::TimedOut | io::ErrorKind::Interrupted
                ) =>
            {
                continue;
            }
            Err(error) => Err(error),
        };
        let last = chunk.is_err();
        if sender.send(chunk).is_err() || last {
            return;
        }
    }
}
