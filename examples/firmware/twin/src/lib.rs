//! Messages between the twin and the program that runs it, a length of four bytes, then so many bytes; and linked programs as
//! both look at them.

mod frame;
pub mod graph;

use serde::{Deserialize, Serialize};
use spindle_monitor::Marks;
use spindle_monitor::loads::FrameCounts;
use spindle_monitor::telemetry::HealthReport;
use std::io::{self, Read, Write};

/// Counters at the end: the twin's last message.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Ending {
    /// Ticks with each mark, in the order of their bits.
    pub marks: [u64; Marks::variant_count() as usize],
    /// Counts of the records that came over the port.
    pub counts: FrameCounts,
    /// The monitor's counters.
    pub health: HealthReport,
}

/// Sends a message.
///
/// # Errors
///
/// Nobody reads.
pub fn send(to: &mut impl Write, message: &[u8]) -> io::Result<()> {
    let length = u32::try_from(message.len()).map_err(io::Error::other)?;
    to.write_all(&length.to_le_bytes())?;
    to.write_all(message)?;
    to.flush()
}

/// The next message; none at the end of the input.
///
/// # Errors
///
/// The input ends within a message.
pub fn receive(from: &mut impl Read) -> io::Result<Option<Vec<u8>>> {
    let mut length = [0; 4];
    if from.read(&mut length[..1])? == 0 {
        return Ok(None);
    }
    from.read_exact(&mut length[1..])?;
    let mut message = vec![0; u32::from_le_bytes(length) as usize];
    from.read_exact(&mut message)?;
    Ok(Some(message))
}
