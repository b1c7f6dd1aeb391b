//! What is solved: mixed cases, and one case that stands for everyday use.

use crate::bench::Question;
use crate::host::Limit;
use anyhow::Result;
use host_tests::cases::{B7005C, Case, Random, rad_per_s};
use host_tests::dispatch::Precision;
use host_tests::milling_cycle::RECORD;
use spindle_bearing::Design;
use tools::stream::records;

/// Balls of the everyday case.
pub const EVERYDAY_BALLS: usize = 16;

/// Load (N, N m) and speed (rad/s), numbers of single precision.
pub type State = ([f64; 5], f64);

/// A bearing under load, and the same a moment later.
#[derive(Debug, Clone)]
pub struct Work {
    /// The bearing.
    pub design: Design,
    /// At first.
    pub cold: State,
    /// One tick later: every load 1 % and the speed 0.5 % larger or smaller.
    pub warm: State,
}

impl Work {
    fn new(design: Design, load: [f64; 5], omega: f64, seed: u64) -> Self {
        let single = |x: f64| f64::from(x as f32);
        let mut r = Random::seeded(seed);
        let mut by = |part: f64| {
            if r.chance(0.5) {
                1.0 + part
            } else {
                1.0 - part
            }
        };
        Self {
            design,
            cold: (load.map(single), single(omega)),
            warm: (
                load.map(|f| single(f * by(0.01))),
                single(omega * by(0.005)),
            ),
        }
    }

    /// A random bearing of this ball count under a random load; at rest if it does not turn.
    pub fn mixed(seed: u64, balls: usize, turns: bool) -> Self {
        let case = Case::random_with(seed, Some(balls));
        let omega = if turns { case.omega } else { 0.0 };
        Self::new(case.design, case.load, omega, !seed)
    }

    /// A spindle bearing in a cut: the example of the README.
    pub fn everyday() -> Self {
        let load = [1000.0, 200.0, 0.0, 0.0, 3.0];
        Self::new(B7005C, load, rad_per_s(20_000.0), 0)
    }
}

/// The recorded milling cycle on a B7005C, a state every millisecond; from a second on, so many ticks.
pub fn milling(from_s: usize, ticks: usize) -> Result<Vec<State>> {
    let records = records::read(RECORD, None, 1000)?.records;
    let states = records.iter().skip(1000 * from_s).take(ticks);
    let single = |x: f64| f64::from(x as f32);
    Ok(states
        .map(|r| {
            let omega = single(rad_per_s(r.speed_rpm.into()));
            (r.load().map(f64::from), omega)
        })
        .collect())
}

/// As a question to a solver of this precision.
pub fn question((load, omega): State, precision: Precision, limit: Limit) -> Question {
    let (tolerance, iterations) = limit.settings(precision);
    Question {
        load,
        omega,
        tolerance,
        max_iterations: iterations.into(),
    }
}
