//! The bearings, loads and speeds that are solved.

use host_tests::cases::{Case, Random};
use spindle_bearing::Design;

/// Balls of a row.
pub const BALLS: usize = 16;

/// Mixed cases, seeds from 0 on.
pub const CASES: u64 = 100;

/// Load (N, N m) and speed (rad/s), numbers of single precision.
pub type State = ([f64; 5], f64);

/// Starts of a solve: from nothing, and from the solution a tick before.
pub const STARTS: [&str; 2] = ["cold", "warm"];

/// A bearing under load, and a moment later.
#[derive(Debug, Clone)]
pub struct Work {
    /// The bearing.
    pub design: Design,
    /// At first; then one tick later, every load 1 % and the speed 0.5 % larger or smaller.
    pub states: [State; 2],
}

impl Work {
    /// A random bearing under a random load.
    fn mixed(seed: u64) -> Self {
        let case = Case::random_with(seed, Some(BALLS));
        let single = |x: f64| f64::from(x as f32);
        let mut random = Random::seeded(!seed);
        let mut by = |part: f64| {
            if random.chance(0.5) {
                1.0 + part
            } else {
                1.0 - part
            }
        };
        let cold = (case.load.map(single), single(case.omega));
        let warm = (
            cold.0.map(|f| single(f * by(0.01))),
            single(cold.1 * by(0.005)),
        );
        Self {
            design: case.design,
            states: [cold, warm],
        }
    }

    /// The state of a start, at rest if the shaft does not turn.
    pub fn state(&self, start: usize, at_speed: bool) -> State {
        let (load, omega) = self.states[start];
        (load, if at_speed { omega } else { 0.0 })
    }

    /// All of them.
    pub fn all() -> Vec<Self> {
        (0..CASES).map(Self::mixed).collect()
    }
}
