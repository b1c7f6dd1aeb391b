//! Where the bytes come from. They are read by a thread of their own, so that a view goes on while
//! nothing comes.

use crate::telemetry::decoder::{Decoder, Event, Gap, Tally};
use crate::telemetry::json;
use crate::telemetry::operator::Operator;
use anyhow::{Context, Result, bail};
use spindle_monitor::telemetry::VERSION;
use std::fs::File;
use std::io::ErrorKind::{Interrupted, TimedOut};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::iter;
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

/// Chunks that wait before the reader is held back.
const WAITING: usize = 64;

/// Longest wait of the operating system for a byte of a port.
pub const PORT_TIMEOUT: Duration = Duration::from_millis(100);

/// Chunks of a stream as they come; disconnected at its end. An error is the last that comes.
pub type Chunks = Receiver<io::Result<Vec<u8>>>;

/// Says something to a port.
pub type PortOperator = Operator<Box<dyn Write + Send>>;

/// Opens a serial port, 8N1: bytes that come in, and the sender of commands.
///
/// # Errors
///
/// The port is not there, not free, or does not know the baud rate.
pub fn port(name: &str, baud: u32) -> Result<(Chunks, PortOperator)> {
    let open = || {
        let port = serialport::new(name, baud).timeout(PORT_TIMEOUT).open()?;
        Ok::<_, serialport::Error>((port.try_clone()?, port))
    };
    let (writer, reader) =
        open().with_context(|| format!("cannot open the serial port {name} at {baud} baud"))?;
    Ok((stream(reader), Operator::new(Box::new(writer))))
}

/// Opens a recorded stream: bytes as they came from a port, or the lines of JSON that were made of them. `-` is standard
/// input.
///
/// # Errors
///
/// The file cannot be opened or read.
pub fn recorded(path: &str) -> Result<Chunks> {
    let source: Box<dyn Read + Send> = match path {
        "-" => Box::new(io::stdin()),
        _ => Box::new(File::open(path).with_context(|| format!("cannot open {path}"))?),
    };
    let mut source = BufReader::new(source);
    let start = source
        .fill_buf()
        .with_context(|| format!("cannot read {path}"))?;
    if start.starts_with(b"{\"") {
        return Ok(spawn(source.lines().map(|line| Ok(json::bytes(&line?)))));
    }
    Ok(stream(source))
}

/// Reads any stream to its end.
pub fn stream(mut source: impl Read + Send + 'static) -> Chunks {
    let mut buffer = [0; 4096];
    spawn(iter::from_fn(move || {
        loop {
            match source.read(&mut buffer) {
                Ok(0) => return None,
                Ok(length) => return Some(Ok(buffer[..length].to_vec())),
                // A silent port.
                Err(error) if matches!(error.kind(), TimedOut | Interrupted) => {}
                Err(error) => return Some(Err(error)),
            }
        }
    }))
}

/// Chunks in a thread of their own, up to the first error.
fn spawn(chunks: impl Iterator<Item = io::Result<Vec<u8>>> + Send + 'static) -> Chunks {
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    thread::spawn(move || {
        for chunk in chunks {
            let is_last = chunk.is_err();
            if sender.send(chunk).is_err() || is_last {
                return;
            }
        }
    });
    receiver
}

/// The frames of a stream when they are due by the monitor's own time.
pub fn paced(chunks: Chunks) -> Chunks {
    let mut decoder = Decoder::new();
    let mut start = None;
    let frames = chunks.into_iter().flat_map(|chunk| match chunk {
        // Each frame with its end.
        Ok(bytes) => bytes
            .split_inclusive(|byte| *byte == 0)
            .map(|of| Ok(of.to_vec()))
            .collect(),
        Err(error) => vec![Err(error)],
    });
    spawn(frames.inspect(move |chunk| {
        for byte in chunk.iter().flatten() {
            if let Some(Event::Frame { frame, gap }) = decoder.push(*byte) {
                if gap == Gap::Restart {
                    start = None;
                }
                let (at, first) = *start.get_or_insert((Instant::now(), frame.time_us));
                let due = Duration::from_micros(frame.time_us.saturating_sub(first));
                thread::sleep(due.saturating_sub(at.elapsed()));
            }
        }
    }))
}

/// Whether there was telemetry among the bytes of a stream, which came from a port with its rate or from elsewhere.
///
/// # Errors
///
/// There was none, and what to look at.
pub fn is_telemetry(tally: &Tally, port: Option<(&str, u32)>) -> Result<()> {
    let bytes = tally.bytes;
    if tally.frames > 0 {
        return Ok(());
    }
    if tally.foreign > 0 {
        bail!(
            "every frame is of another version than {VERSION}: use the programs of the firmware that sent it"
        );
    }
    match port {
        Some((port, _)) if bytes == 0 => {
            bail!("{port} says nothing: is the board powered, and its TX on this port's RX?")
        }
        Some((port, baud)) => bail!(
            "none of the {bytes} bytes from {port} was telemetry at {baud} baud: is that the board's rate (--baud)?"
        ),
        None => bail!("none of the {bytes} bytes is telemetry"),
    }
}
