//! Where the bytes come from. They are read by a thread of their own, so that a view goes on while
//! nothing comes.

use anyhow::{Context, Result, bail};
use host_tests::telemetry::decoder::Tally;
use host_tests::telemetry::operator::Operator;
use spindle_bearing::monitor::command::Key;
use spindle_bearing::monitor::telemetry::VERSION;
use std::fs::File;
use std::io::{self, Read, Write};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;
use std::time::Duration;

/// Chunks that wait before the reader is held back.
const WAITING: usize = 64;

/// Longest wait of the operating system for a byte of a port.
const PORT_TIMEOUT: Duration = Duration::from_millis(100);

/// Chunks of a stream as they come; disconnected at its end. An error is the last that comes.
pub type Chunks = Receiver<io::Result<Vec<u8>>>;

/// Says something to a port.
pub type PortOperator = Operator<Box<dyn Write + Send>>;

/// Opens a serial port, 8N1: what comes in, and who sends commands out, authenticated if there is a key.
///
/// # Errors
///
/// The port is not there, not free, or does not know the baud rate.
pub fn port(name: &str, baud: u32, key: Option<Key>) -> Result<(Chunks, PortOperator)> {
    let open = || {
        let port = serialport::new(name, baud).timeout(PORT_TIMEOUT).open()?;
        Ok::<_, serialport::Error>((port.try_clone()?, port))
    };
    let (writer, reader) =
        open().with_context(|| format!("cannot open the serial port {name} at {baud} baud"))?;
    Ok((stream(reader), Operator::new(Box::new(writer), key)))
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

/// Whether there was telemetry among the bytes of a stream, which came from a port with its rate or from elsewhere.
///
/// # Errors
///
/// There was none, and what to look at.
pub fn is_telemetry(tally: &Tally, port: Option<(&str, u32)>) -> Result<()> {
    let Tally {
        bytes,
        frames,
        foreign,
        ..
    } = *tally;
    if frames > 0 {
        return Ok(());
    }
    if foreign > 0 {
        bail!(
            "every frame is of another version than {VERSION}: use the tools of the firmware that sent it"
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

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use host_tests::telemetry::state::State;
    use serialport::{SerialPort, TTYPort};
    use spindle_bearing::monitor::command::{self, Command, Order, Request};

    /// A pseudo-terminal is a port to whoever opens it.
    #[test]
    fn the_bytes_of_a_port_arrive_as_they_were_sent_silence_is_no_end_and_unplugging_is() {
        let (mut sender, port_side) = TTYPort::pair().unwrap();
        let name = port_side.name().unwrap();
        let (chunks, mut operator) = port(&name, 460_800, None).unwrap();
        let receive = |count: usize| -> Vec<u8> {
            let mut bytes = Vec::new();
            while bytes.len() < count {
                let chunk = chunks.recv_timeout(Duration::from_secs(10)).unwrap();
                bytes.extend(chunk.unwrap());
            }
            bytes
        };
        // All of them: a terminal would change some.
        let sent: Vec<u8> = (0..=255).collect();
        for _ in 0..2 {
            sender.write_all(&sent).unwrap();
            assert_eq!(receive(sent.len()), sent);
            thread::sleep(2 * PORT_TIMEOUT);
        }
        operator.want(Order::Learn(true));
        let state = State {
            nonce: Some(9),
            ..State::default()
        };
        operator.follow(&state).unwrap();
        let wanted = Command::Ask(Request::new(1, 9, Order::Learn(true), None));
        let wanted = command::encode(wanted);
        let mut command = vec![0; wanted.len()];
        sender.read_exact(&mut command).unwrap();
        assert_eq!(command, *wanted);
        drop((sender, port_side));
        let last = chunks.recv_timeout(Duration::from_secs(10));
        assert!(!matches!(last, Ok(Ok(_))), "{last:?}");
        assert!(!matches!(last, Err(mpsc::RecvTimeoutError::Timeout)));
    }
}
