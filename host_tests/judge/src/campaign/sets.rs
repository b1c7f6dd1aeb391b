//! Sets of bearings on one shaft, and how one is drawn.

use crate::reference::spindle::Solver;
use cli::random::Random;
use spindle_bearing::{Design, Facing, Growth, Preload, Section, ShaftLoad, Support};
use spindle_file::plan::{ElasticShaft, MOST_ROWS, Plan, Row};
use std::array::from_fn;
use std::f64::consts::TAU;

/// A set of bearings, all that is asked of it but load and speed.
#[derive(Debug, Clone)]
pub struct Set {
    /// Rows, spring and shaft.
    pub plan: Plan,
    /// Growth of each row.
    pub growth: Vec<Growth<f64>>,
    /// Displacements at `x = 0` that are given in the place of loads, m and rad.
    pub held: [Option<f64>; 5],
    /// The set, prepared by the reference build.
    pub reference: Solver,
}

/// A number that single precision holds, so that both precisions solve one set.
fn round(x: f64) -> f64 {
    f64::from(x as f32)
}

impl Set {
    /// One to eight rows of a bearing with this capacity, or of two; some sprung, half on an elastic shaft, half grown, a
    /// quarter with given displacements. Rows of the first side face `+x`.
    pub fn draw(r: &mut Random, design: &Design, balls: usize, capacity: f64) -> Self {
        let (l0, pitch) = (design.centre_distance(), design.pitch_diameter);
        let count = 1 + r.below(MOST_ROWS);
        // The first row of the other side, if there is one.
        let turn = 1 + r.below(count);
        let is_opposed = turn < count;
        let slides = is_opposed && r.chance(0.3);
        let smaller = match r.chance(0.3) {
            true => r.between(0.6, 1.0),
            false => 1.0,
        };
        let other = Design {
            ball_diameter: smaller * design.ball_diameter,
            ..*design
        };
        let width = 0.3 * pitch;
        let apart = r.log_between(1.0, 10.0);
        let place = |i: usize| match i < turn {
            true => width * i as f64,
            false => width * (i as f64 - 1.0 + apart),
        };
        let span = place(count - 1) + width;
        let first = -span * r.between(-0.3, 1.0);
        let mirror = if r.chance(0.5) { 1.0 } else { -1.0 };
        let row = |i: usize| Row {
            balls,
            design: if i < turn { *design } else { other },
            position: round(mirror * (first + place(i))),
            facing: match i < turn {
                true => Facing::PlusX,
                false => Facing::MinusX,
            },
            preload: match slides && i >= turn {
                true => Preload::Spring,
                false if is_opposed => Preload::Closure(round(l0 * r.log_between(1e-3, 3e-2))),
                false => Preload::Closure(0.0),
            },
        };
        let rows: Vec<Row> = (0..count).map(row).collect();
        let grown = if r.chance(0.5) { l0 } else { 0.0 };
        let growth = rows.iter().map(|_| Growth {
            axial: round(grown * r.between(-2e-3, 2e-3)),
            radial: round(grown * r.between(0.0, 1e-2)),
            ball: round(grown * r.between(0.0, 2e-3)),
        });
        let growth: Vec<_> = growth.collect();
        let spring = slides.then(|| round(capacity * r.log_between(2e-3, 5e-2)));
        let shaft = r.chance(0.5).then(|| shaft(r, &rows, is_opposed, capacity));
        let plan = Plan {
            spring,
            shaft,
            ..Plan::of(rows)
        };
        let is_held = r.chance(0.25);
        let depth = l0 * r.log_between(1e-3, 2e-2);
        let held = from_fn(|i| {
            let size = [1.0, 0.5, 0.5, 1.0 / pitch, 1.0 / pitch][i] * depth;
            let least = if i == 0 { 0.1 } else { -1.0 };
            (r.chance(0.5) && is_held).then(|| round(size * r.between(least, 1.0)))
        });
        Self {
            reference: Solver::new(&plan, &growth).unwrap_or_else(|e| panic!("{plan:?}: {e}")),
            plan,
            growth,
            held,
        }
    }

    /// Whether no row holds another one, and no displacement is given: it carries nothing without a load.
    pub fn is_loose(&self) -> bool {
        let rows = &self.plan.rows;
        rows.iter().all(|row| row.facing == rows[0].facing) && self.held == [None; 5]
    }
}

/// Up to four sections that reach beyond the rows, some with gaps between them; half of the supports rigid. A belt may pull.
fn shaft(r: &mut Random, rows: &[Row], may_pull: bool, capacity: f64) -> ElasticShaft {
    let size = rows[0].design.pitch_diameter;
    let positions = || rows.iter().map(|row| row.position).chain([0.0]);
    let low = positions().fold(f64::INFINITY, f64::min) - size * r.between(0.0, 1.0);
    let high = positions().fold(f64::NEG_INFINITY, f64::max) + size * r.between(0.0, 1.0);
    let count = 1 + r.below(4);
    let length = (high - low) / count as f64;
    let section = |i: usize| {
        // As thick as a shaft may be.
        let outer = (size * r.log_between(0.3, 0.9)).min(2.0);
        let gap = length * r.zero_or(0.7, 0.0, 0.5);
        Section {
            from: round(low + i as f64 * length),
            to: round(low + (i + 1) as f64 * length - gap),
            outer,
            inner: outer * r.zero_or(0.5, 0.0, 0.8),
        }
    };
    let sections = (0..count).map(section).collect();
    let stiff = 1e10 * size;
    let mut stiffness = |unit: f64| match r.chance(0.5) {
        true => f64::INFINITY,
        false => round(stiff * unit * r.log_between(0.05, 10.0)),
    };
    let supports = rows.iter().map(|_| Support {
        axial: stiffness(1.0),
        radial: stiffness(1.0),
        tilting: stiffness(size * size),
    });
    let supports = supports.collect();
    let pull = capacity * r.log_between(1e-4, 1e-2);
    let (sin, cos) = r.between(0.0, TAU).sin_cos();
    let belt = ShaftLoad {
        position: round(r.between(low, high)),
        load: [0.0, pull * cos, pull * sin, 0.0, 0.0].map(round),
    };
    let mut shaft = ElasticShaft::of(sections, supports);
    shaft
        .loads
        .extend((may_pull && r.chance(0.3)).then_some(belt));
    shaft
}
