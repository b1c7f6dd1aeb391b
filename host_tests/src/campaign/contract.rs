//! What a campaign must hold: one table.

use super::families::Family;
use super::report::Summary;
use crate::dispatch::Precision;

/// What a family must hold in a precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Most sweeps that 99 % of the solves take.
    pub sweeps: u16,
    /// Largest share of solves without an answer though there is an equilibrium, in percent.
    pub missed: f64,
    /// Largest share of answers that cannot be judged, in percent of the solves.
    pub unjudged: f64,
    /// Errors of displacement, force and stiffness that 99 % of the answers are within.
    pub errors: [f64; 3],
}

const fn row(sweeps: u16, missed: f64, unjudged: f64, errors: [f64; 3]) -> Bounds {
    Bounds {
        sweeps,
        missed,
        unjudged,
        errors,
    }
}

/// The table, in the order of [`Family::ALL`]: single precision, double precision.
#[rustfmt::skip]
pub const CONTRACT: [[Bounds; 2]; 14] = [
    // random
    [row(100, 2.0, 2.0, [4e-6, 7e-6, 4e-3]), row(100, 2.0, 1.0, [4e-13, 8e-14, 6e-12])],
    // moderate
    [row(100, 1.0, 0.5, [3e-6, 3e-6, 1e-4]), row(100, 1.0, 0.5, [5e-14, 5e-14, 2e-13])],
    // radial
    [row(100, 2.0, 1.0, [2e-6, 4e-6, 5e-3]), row(100, 2.0, 0.5, [1e-13, 1e-13, 1e-11])],
    // few-balls
    [row(100, 20.0, 15.0, [2.0, 2e-3, 2.0]), row(100, 20.0, 6.0, [3e-11, 3e-13, 6e-9])],
    // opening
    [row( 40, 1.0, 1.5, [2e-2, 2e-4, 3e-1]), row( 40, 1.0, 0.5, [4e-11, 5e-14, 5e-11])],
    // extreme-angles
    [row( 20, 0.2, 0.2, [1e-6, 3e-6, 1e-5]), row( 20, 0.2, 0.2, [7e-13, 2e-13, 5e-13])],
    // reversed
    [row(100, 1.0, 0.5, [4e-7, 3e-6, 1e-4]), row(100, 1.0, 0.5, [2e-14, 5e-14, 2e-13])],
    // deep-groove
    [row(100, 1.5, 0.5, [4e-6, 1e-5, 1e-3]), row(100, 1.0, 0.5, [4e-12, 2e-12, 6e-12])],
    // moduli
    [row(100, 1.0, 0.5, [3e-6, 4e-6, 2e-4]), row(100, 1.0, 0.5, [5e-14, 6e-14, 4e-13])],
    // inner-control
    [row( 15, 0.2, 0.2, [3e-6, 2e-6, 3e-5]), row( 15, 0.2, 0.2, [3e-14, 1e-14, 1e-13])],
    // zero-loads
    [row(100, 2.0, 2.0, [5e-6, 4e-6, 3e-4]), row(100, 2.0, 0.5, [6e-14, 6e-14, 1e-12])],
    // warm-drift
    [row( 15, 1.0, 1.0, [3e-6, 3e-6, 6e-5]), row( 15, 1.0, 0.5, [4e-14, 3e-14, 2e-13])],
    // warm-jumps
    [row(100, 1.0, 0.5, [3e-6, 5e-6, 8e-4]), row(100, 1.0, 0.5, [4e-14, 5e-14, 2e-12])],
    // any-bits
    [row(100, 1.0, 1.5, [3e-6, 3e-6, 2e-4]), row(100, 1.0, 1.5, [6e-14, 4e-14, 2e-12])],
];

/// What a family must hold in a precision.
pub fn of(family: Family, precision: Precision) -> Bounds {
    CONTRACT[family as usize][precision as usize]
}

/// What a summary does not hold, in words; empty if it holds everything.
pub fn broken(summary: &Summary) -> Vec<String> {
    let bounds = of(summary.family, summary.precision);
    let mut broken = Vec::new();
    let mut need = |ok: bool, what: String| {
        if !ok {
            broken.push(format!(
                "{} in {:?}: {what}",
                summary.family.name(),
                summary.precision
            ));
        }
    };
    need(summary.failed == 0, format!("{} failed", summary.failed));
    for (what, count, bound) in [
        ("missed", summary.refused[1], bounds.missed),
        ("unjudged", summary.answers[2], bounds.unjudged),
    ] {
        need(
            100.0 * count as f64 <= bound * summary.solves as f64,
            format!("{count} of {} {what}, allowed {bound} %", summary.solves),
        );
    }
    // A family without an answer has no spreads, which are not numbers then, and is broken, too.
    need(
        summary.sweeps.most <= f64::from(bounds.sweeps),
        format!("{} sweeps, allowed {}", summary.sweeps.most, bounds.sweeps),
    );
    for (what, (errors, bound)) in ["u", "Q", "K"]
        .into_iter()
        .zip(summary.errors.iter().zip(bounds.errors))
    {
        need(
            errors.most <= bound,
            format!("error of {what} {:.1e}, allowed {bound:.0e}", errors.most),
        );
    }
    broken
}
