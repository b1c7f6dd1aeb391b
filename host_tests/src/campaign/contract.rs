//! What a campaign must hold: one table.

use super::families::Family;
use super::report::Summary;
use crate::dispatch::Precision;

/// What a family must hold in a precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Most sweeps that 99 % of the solves take.
    pub sweeps: u16,
    /// Largest share of solves without an answer though there is an equilibrium.
    pub missed: f64,
    /// Largest share of answers that cannot be judged.
    pub unjudged: f64,
    /// Errors of displacement, force and stiffness that 99 % of the answers are within.
    pub errors: [f64; 3],
}

/// What a family must hold in a precision.
pub const fn of(family: Family, precision: Precision) -> Bounds {
    let _ = family;
    match precision {
        Precision::F32 => Bounds {
            sweeps: 100,
            missed: 0.1,
            unjudged: 0.1,
            errors: [1e-2, 1e-2, 1e-2],
        },
        Precision::F64 => Bounds {
            sweeps: 100,
            missed: 0.1,
            unjudged: 0.1,
            errors: [1e-6, 1e-6, 1e-6],
        },
    }
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
    let share = |count: usize| count as f64 / summary.solves as f64;
    for (what, count, bound) in [
        ("missed", summary.refused[1], bounds.missed),
        ("unjudged", summary.answers[2], bounds.unjudged),
    ] {
        need(
            share(count) <= bound,
            format!("{count} of {} {what}, allowed {bound}", summary.solves),
        );
    }
    // Without figures there is nothing to hold, and the comparison is with NaN.
    need(
        !(summary.sweeps.most > f64::from(bounds.sweeps)),
        format!("{} sweeps, allowed {}", summary.sweeps.most, bounds.sweeps),
    );
    for (what, (errors, bound)) in ["u", "Q", "K"]
        .into_iter()
        .zip(summary.errors.iter().zip(bounds.errors))
    {
        need(
            !(errors.most > bound),
            format!("error of {what} {:.1e}, allowed {bound:.0e}", errors.most),
        );
    }
    broken
}
