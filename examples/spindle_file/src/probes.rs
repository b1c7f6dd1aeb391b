//! Probes of a spindle file: sensors of displacement that see the shaft against the housing, `[[probe]]`.

use crate::doubts::{Doubts, Extent};
use crate::monitors::Bridges;
use crate::reading::{DesignFileError, Key, POSITIONS, Reading, millimetres};
use serde::Deserialize;
use std::ops::RangeInclusive;
use toml::Spanned;

/// Most probes of a spindle.
pub const MOST_PROBES: usize = 4;

/// Channels of the board's converter.
const CHANNELS: usize = 8;

/// Accuracy of a probe that does not say it, um: that of an eddy current probe.
const ACCURACY: f64 = 0.5;

/// Accuracies of displacement sensors, um: from capacitive ones in a laboratory to inductive ones in a machine.
const ACCURACIES: RangeInclusive<f64> = 0.005..=20.0;

/// A probe.
#[derive(Debug, Clone, PartialEq)]
pub struct Probe {
    /// Its name: its readings are `probe_NAME_um` in a recording.
    pub name: String,
    /// Position on the shaft, m.
    pub position: f64,
    /// Unit vector of the displacement that it sees, in the shaft's frame.
    pub direction: [f64; 3],
    /// Accuracy of a reading, um.
    pub accuracy: f64,
    /// The channel of the board's converter that it is at, and micrometres per count; none for readings over the port.
    pub channel: Option<(usize, f64)>,
}

impl Probe {
    /// Displacement (um) that it sees where the shaft moves by `u` (m, rad).
    pub fn sees(&self, u: &[f64; 5]) -> f64 {
        let along = self.direction.iter().zip(u).map(|(e, u)| e * u);
        1e6 * along.sum::<f64>()
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProbeKeys {
    name: Key<String>,
    position_mm: Key<f64>,
    direction: Key<Direction>,
    angle_deg: Key<f64>,
    accuracy_um: Key<f64>,
    channel: Key<usize>,
    um_per_count: Key<f64>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "`direction` is \"x\", or the angle in degrees from +y towards +z"
)]
enum Direction {
    Axial(Axis),
    Radial(f64),
}

#[derive(Deserialize)]
enum Axis {
    #[serde(rename = "x")]
    X,
}

/// The probes.
///
/// # Errors
///
/// A probe that lacks a key, has a name or a channel twice or has no direction; more probes than [`MOST_PROBES`]; the place.
pub(crate) fn read(
    r: Reading<'_>,
    tables: Vec<Spanned<ProbeKeys>>,
    bridges: Option<&Bridges>,
    extent: &Extent,
    doubts: &mut Doubts<'_>,
) -> Result<Vec<Probe>, DesignFileError> {
    let mut probes: Vec<Probe> = Vec::new();
    for table in tables {
        let place = r.place(table.span());
        if probes.len() == MOST_PROBES {
            let message = format!("there are {MOST_PROBES} probes at most; remove this one");
            return Err(r.error(place, message));
        }
        let keys = table.into_inner();
        let missing = |line: &str| {
            let message = format!("this probe lacks a key; add a line such as `{line}`");
            r.error(place, message)
        };
        let name = keys.name.ok_or_else(|| missing("name = \"nose\""))?;
        let (at, name) = (r.place(name.span()), name.into_inner());
        let is_plain = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
        if name.is_empty() || !name.chars().all(is_plain) {
            let message = "the name of a probe has letters, digits, `-` and `_`";
            return Err(r.error(at, message));
        }
        if probes.iter().any(|probe| probe.name == name) {
            let message = format!("another probe is called {name:?}; rename one of them");
            return Err(r.error(at, message));
        }
        let position = keys.position_mm;
        let position = position.ok_or_else(|| missing("position_mm = -10"))?;
        let (at, said) = (r.place(position.span()), *position.get_ref());
        r.within("position_mm", &position, POSITIONS)?;
        if extent.is_beyond(millimetres(said)) {
            let words = extent.words(millimetres(said));
            let message = format!(
                "`position_mm` of the probe {name} is {said}, {words}: can it see the shaft there?"
            );
            doubts.tell(at, message);
        }
        let angle = match (keys.direction.map(Spanned::into_inner), keys.angle_deg) {
            (Some(Direction::Axial(Axis::X)), None) => None,
            (Some(Direction::Radial(angle)), None) => Some(angle),
            (None, Some(angle)) => Some(angle.into_inner()),
            (Some(_), Some(angle)) => {
                let message = "the probe has `direction` and `angle_deg`; remove one of them";
                return Err(r.error(r.place(angle.span()), message));
            }
            (None, None) => return Err(missing("direction = \"x\"` or `angle_deg = 90")),
        };
        let direction = match angle.map(|angle| angle.to_radians().sin_cos()) {
            Some((sin, cos)) => [0.0, cos, sin],
            None => [1.0, 0.0, 0.0],
        };
        let accuracy = match keys.accuracy_um {
            Some(accuracy) if *accuracy.get_ref() <= 0.0 => {
                let message = format!(
                    "`accuracy_um` is {}, but must be above 0",
                    accuracy.get_ref()
                );
                return Err(r.error(r.place(accuracy.span()), message));
            }
            Some(accuracy) => {
                let (at, said) = (r.place(accuracy.span()), accuracy.into_inner());
                doubts.unusual(at, ("accuracy_um", said), ACCURACIES, "is it in um?");
                said
            }
            None => ACCURACY,
        };
        let channel = match (keys.channel, keys.um_per_count) {
            (None, None) => None,
            (Some(_), None) => return Err(missing("um_per_count = 1e-3")),
            (None, Some(_)) => return Err(missing("channel = 7")),
            (Some(channel), Some(per_count)) => {
                let (at, channel) = (r.place(channel.span()), channel.into_inner());
                let taken = bridges.map_or(CHANNELS, |bridges| bridges.counts.len());
                let is_taken = |probe: &Probe| probe.channel.is_some_and(|(of, _)| of == channel);
                if !(taken..CHANNELS).contains(&channel) || probes.iter().any(is_taken) {
                    let message = format!(
                        "channel {channel} of the converter is not free: it has {CHANNELS}, counted from 0, bridges are at the first \
                         ones of them (`loads = \"bridges\"` in [monitor]), and each probe has its own"
                    );
                    return Err(r.error(at, message));
                }
                let (at, per_count) = (r.place(per_count.span()), per_count.into_inner());
                if per_count == 0.0 {
                    return Err(r.error(at, "`um_per_count` must not be 0"));
                }
                Some((channel, per_count))
            }
        };
        if probes
            .iter()
            .any(|probe| probe.channel.is_some() != channel.is_some())
        {
            let message = "probes are all at the board's converter, with `channel`, or all over the port, without";
            return Err(r.error(place, message));
        }
        probes.push(Probe {
            name,
            position: millimetres(position.into_inner()),
            direction,
            accuracy,
            channel,
        });
    }
    Ok(probes)
}
