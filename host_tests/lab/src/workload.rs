//! The bearings, loads and speeds that are solved.

use crate::solves::{BALLS, CASES, Work};
use cli::random::Random;
use judge::cases::Case;

/// A random bearing under a random load.
fn mixed(seed: u64) -> Work {
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
    Work {
        design: case.design,
        states: [cold, warm],
    }
}

/// Mixed cases, seeds from 0 on.
pub fn all() -> [Work; CASES] {
    std::array::from_fn(|seed| mixed(seed as u64))
}
