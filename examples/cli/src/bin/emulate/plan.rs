//! A run: bytes over the port, tick by tick, and the answers of the firmware's twin, the host's own build of the same monitor.

use crate::twin::Running;
use anyhow::Result;
use cli::stream::{
    self,
    faults::{Episode, Spoiler},
    records::Recording,
};
use spindle_monitor::command::{self, Command};
use twin::Ending;

/// A run.
pub struct Plan {
    /// Bytes for the board.
    pub input: Vec<u8>,
    /// Bytes that the board must answer, to the bit.
    pub expected: Vec<u8>,
    /// Faults.
    pub episodes: Vec<Episode>,
    /// Counters at the end.
    pub ending: Ending,
}

/// Makes the run of a recording, spoilt.
pub fn plan(recording: &Recording, mut spoiler: Spoiler, mut twin: Running) -> Result<Plan> {
    let (mut input, mut expected) = (Vec::new(), Vec::new());
    stream::ticks(recording, &mut spoiler, |tick| {
        let from = input.len();
        input.extend(&tick.bytes);
        input.extend(command::encode(Command::Tick(tick.room)));
        let answer = twin.answer(&input[from..])?;
        expected.extend(&answer);
        Ok(answer)
    })?;
    Ok(Plan {
        input,
        expected,
        episodes: spoiler.episodes,
        ending: twin.end()?,
    })
}
