//! The shipped spindle's monitor, and loads at its nose.

use super::spindle::{MONITOR, SPINDLE};
use mock::rig::Rig;

/// The spindle and its monitor.
pub(super) fn shipped() -> Rig<2, 2> {
    Rig::of(&SPINDLE, &MONITOR, [0.0; 5])
}

/// Loads at the shipped spindle's nose. A cutter 50 mm in front of it puts this force (N) onto the front bearing.
pub(super) fn at_nose(force: [f64; 3]) -> [f32; 5] {
    let [x, y, z] = force.map(|force| 0.55 * force);
    [x, y, z, 0.05 * z, -0.05 * y].map(|load| load as f32)
}
