//! Warm ticks of the recorded milling cycle at 1 kHz: the full scene on a B7005C.

use crate::bench::Bench;
use crate::host::{self, Ground, Limit};
use crate::image::{Image, name};
use crate::plan::USUAL;
use crate::profile::{Profile, Profiler};
use crate::rows::{Row, Rows, Start};
use crate::workload::{self, EVERYDAY_BALLS, State, question};
use anyhow::{Result, bail};
use host_tests::campaign::report::Spread;
use host_tests::cases::B7005C;
use host_tests::dispatch::Precision;
use std::path::Path;
use tools::report::FULL;
use tools::timing::Core;

/// The core and the precision.
pub const CORE: Core = Core::M4f;
pub const PRECISION: Precision = Precision::F32;
/// Tolerances: the default, and one that is good enough for a display.
pub const LIMITS: [Limit; 2] = [Limit::Default, Limit::Tolerance(1e-3)];
/// Every so manyth tick is compared with the reference build.
const JUDGED: usize = 20;

/// What the warm ticks took, and how far they were off.
#[derive(Default)]
pub struct Ticks {
    /// Modelled cycles of every warm tick.
    pub cycles: Vec<f64>,
    /// Sum of their instructions, and of their iterations.
    pub instructions: u64,
    pub iterations: f64,
    /// Errors of the stiffness.
    pub errors: Vec<f64>,
    /// Ticks without an answer.
    pub failed: usize,
    /// Where the cycles went.
    pub profile: Profile,
}

impl Ticks {
    /// Of a bench with the full scene; fails if an answer is not the host's to the last bit.
    pub fn measure(
        bench: &mut Bench,
        mut profiler: Option<&mut Profiler>,
        states: &[State],
        limit: Limit,
    ) -> Result<Self> {
        let ground = Ground {
            design: &B7005C,
            balls: EVERYDAY_BALLS,
            motion: USUAL,
        };
        let expected = host::in_turn(ground, states, limit, JUDGED)?;
        bench.bearing(&B7005C)?;
        let mut ticks = Self::default();
        let mut solved = false;
        for (number, (state, expected)) in states.iter().zip(expected).enumerate() {
            let solve = bench.solve(&question(*state, PRECISION, limit))?;
            let is_same = match &expected {
                None => !solve.answer.solved,
                Some(expected) => solve.answer.displacement == expected.displacement,
            };
            if !is_same {
                bail!("tick {number} of the milling cycle: the core's answer is not the host's");
            }
            if solved && solve.answer.solved {
                ticks.cycles.push(solve.cycles as f64);
                ticks.instructions += solve.instructions;
                ticks.iterations += f64::from(solve.answer.iterations);
                if let Some(profiler) = &mut profiler {
                    let profile = profiler.profile(&bench.machine, &solve.counts)?;
                    ticks.profile.add(&profile);
                }
            }
            let errors = expected.and_then(|expected| expected.errors);
            ticks.errors.extend(errors.map(|errors| errors[2]));
            solved = solve.answer.solved;
            ticks.failed += usize::from(!solved);
        }
        Ok(ticks)
    }
}

fn row(metric: String, stat: &'static str, value: f64, unit: &'static str) -> Row {
    Row {
        core: CORE.name(),
        precision: name(PRECISION),
        scene: "milling cycle",
        attitude: Some(USUAL.name()),
        balls: EVERYDAY_BALLS,
        start: Some(Start::Warm.name()),
        metric,
        stat,
        value,
        unit,
    }
}

/// Measures the whole cycle.
pub fn run(root: &Path) -> Result<Rows> {
    let states = workload::milling(0, usize::MAX)?;
    let image = Image::of_scene(root, CORE, PRECISION, EVERYDAY_BALLS, FULL)?;
    let mut bench = Bench::new(image, CORE, PRECISION)?;
    let mut rows = Rows::default();
    for limit in LIMITS {
        eprintln!("the milling cycle, {} ticks", states.len());
        let ticks = Ticks::measure(&mut bench, None, &states, limit)?;
        for (what, values, unit) in [
            ("cycles", &ticks.cycles, "cycles"),
            ("stiffness error", &ticks.errors, "1"),
        ] {
            let spread = Spread::of(values.iter().copied());
            for (stat, value) in [
                ("median", spread.median),
                ("99 %", spread.most),
                ("worst", spread.worst),
            ] {
                rows.push(row(limit.metric(what), stat, value, unit));
            }
        }
        for (what, count) in [("no answer", ticks.failed), ("ticks", states.len())] {
            rows.push(row(limit.metric(what), "value", count as f64, "1"));
        }
    }
    Ok(rows)
}

/// A figure; NaN if there is none.
pub fn figure(rows: &Rows, limit: Limit, what: &str, stat: &str) -> f64 {
    let metric = limit.metric(what);
    let mut rows = rows.all().iter();
    rows.find(|r| r.scene == "milling cycle" && r.metric == metric && r.stat == stat)
        .map_or(f64::NAN, |r| r.value)
}
