//! What goes over the port to the monitor in a run of a recording: a record a tick, spoilt by faults if
//! wanted, and now and then a command of the operator's.

pub mod faults;
pub mod records;

use faults::Spoiler;
use spindle_bearing::monitor::command::{self, Command};
use spindle_bearing::monitor::{Alarm, MonitorSettings};
use spindle_bearing::record::LoadRecord;

/// Bytes that the link takes in a tick: those of 460,800 baud in a millisecond.
pub const ROOM: u16 = 46;
/// Ticks between two looks of the operator, who then acknowledges what there is.
const LOOK: usize = 2000;
/// Ticks in which the baseline is learnt.
const LEARNING: usize = 2000;

/// What happens between two ticks, and in the second.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tick {
    /// Bytes that come in before it.
    pub bytes: Vec<u8>,
    /// Bytes of telemetry that the link takes after it.
    pub room: u16,
}

/// The run of these records, spoilt. The last tick is one with a health report, so that the board's own
/// counters are the last word, and all that waits is sent in it.
pub fn ticks(
    records: &[LoadRecord],
    spoiler: &mut Spoiler,
    settings: &MonitorSettings,
) -> Vec<Tick> {
    let period = settings.tick.period_us;
    let per_report = (settings.telemetry.health_us / period).max(1) as usize;
    let ticks = records.len().div_ceil(per_report) * per_report + 1;
    (0..ticks)
        .map(|tick| {
            let mut bytes = Vec::new();
            if tick == 0 || tick == LEARNING {
                bytes.extend(command::encode(Command::Learn(tick == 0)));
            }
            let mut shut = false;
            if let Some(record) = records.get(tick) {
                let spoilt = spoiler.spoil(tick, record);
                bytes.extend(spoilt.bytes);
                shut = spoilt.shut;
            }
            if tick % LOOK == LOOK - 1 || tick + 2 == ticks {
                for alarm in Alarm::ALL {
                    bytes.extend(command::encode(Command::Acknowledge(alarm)));
                }
            }
            let last = tick + 1 == ticks;
            let room = match (last, shut) {
                (true, _) => u16::MAX,
                (_, true) => 0,
                _ => ROOM,
            };
            Tick { bytes, room }
        })
        .collect()
}
