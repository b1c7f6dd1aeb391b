//! The contract of a campaign: what is promised of every family, and what the measured solver does not keep of it yet.
//!
//! The page lists what is not kept of the promise. The tests hold a bound for every figure: that of the promise; where
//! [`NOT_KEPT_YET`] names the figure, that of its row; where nothing is promised, that of `MEASURED`.

use super::families::Family;
use super::judge::{PRECISIONS, Record};
use super::report::{self, Summary};
use crate::dispatch::Precision;

/// What a campaign promises of a family. What it does not keep is on its page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Promise {
    /// Largest share of solves without an answer though there is an equilibrium where the contacts of every ball that
    /// carries oppose each other, in percent.
    pub missed: f64,
    /// Errors of displacement, force and stiffness that 99 % of the answers in single precision are within.
    pub errors: Option<[f64; 3]>,
    /// Least share of the errors of displacement, force and stiffness that are within the solver's own estimates, in
    /// percent; the estimates are [`RATIO`] times too large at most, in the median.
    pub covered: Option<f64>,
    /// Largest share of answers on another branch than that from rest, in percent.
    pub other_branch: Option<f64>,
}

/// Largest median of estimate over error.
pub const RATIO: f64 = 30.0;

/// What a campaign promises of a family, in both precisions. Of all: no panic, no figure that is not a number, no
/// answer past the iteration limit, none whose forces do not balance.
pub const fn promise(family: Family) -> Promise {
    let missed = match family {
        Family::FewBalls => 4.0,
        Family::Typed => 0.05,
        Family::Random | Family::Radial | Family::ZeroLoads | Family::Opening => 1.0,
        _ => 0.2,
    };
    let errors = match family {
        Family::Moderate
        | Family::Reversed
        | Family::Moduli
        | Family::InnerControl
        | Family::WarmDrift
        | Family::WarmJumps => Some([1e-6, 1e-6, 2e-5]),
        _ => None,
    };
    let covered = match family {
        Family::Moderate | Family::Reversed | Family::WarmDrift => Some(99.9),
        Family::Random | Family::Radial => Some(99.5),
        _ => None,
    };
    let other_branch = match family {
        Family::Moderate => Some(0.1),
        _ => None,
    };
    Promise {
        missed,
        errors,
        covered,
        other_branch,
    }
}

/// A figure of a family that the contract bounds. A number says of what: displacement, force, stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Figure {
    /// Answers whose forces do not balance, percent of the solves.
    Unbalanced,
    /// Answers on another branch than that from rest, percent of those compared.
    OtherBranch,
    /// No answer, though there is an equilibrium whose contacts oppose each other, percent of the solves.
    MissedOpposed,
    /// No answer, though there is any equilibrium, percent of the solves.
    Missed,
    /// No answer, and only a search of the reference build knows whether there is an equilibrium, percent of the solves.
    Open,
    /// Answers from which the reference build finds no equilibrium, percent of the solves.
    Unjudged,
    /// Error that 99 % of the answers are within.
    Error(usize),
    /// Errors that are within the solver's own estimates, percent of the answers.
    Covered(usize),
    /// Median of estimate over error.
    Ratio(usize),
}

use Figure::{
    Covered, Error, Missed, MissedOpposed, Open, OtherBranch, Ratio, Unbalanced, Unjudged,
};

/// Every figure of a family.
const FIGURES: [Figure; 15] = [
    Unbalanced,
    OtherBranch,
    MissedOpposed,
    Missed,
    Open,
    Unjudged,
    Error(0),
    Error(1),
    Error(2),
    Covered(0),
    Covered(1),
    Covered(2),
    Ratio(0),
    Ratio(1),
    Ratio(2),
];

/// The three errors.
const NAMES: [&str; 3] = ["u", "Q", "K"];

impl Figure {
    /// The figure in a campaign; NaN where the campaign has none.
    fn of(self, summary: &Summary) -> f64 {
        let percent = |count: usize, all: usize| 100.0 * count as f64 / all as f64;
        let coverage = |i: usize| summary.coverage.map(|of| of[i]);
        match self {
            Unbalanced => percent(summary.unbalanced, summary.solves),
            // A family of which no answer was compared is on no other branch.
            OtherBranch => percent(summary.branches[1], summary.branches[0].max(1)),
            MissedOpposed => percent(summary.missed_opposed, summary.solves),
            Missed => percent(summary.refused[1], summary.solves),
            Open => percent(summary.undecided, summary.solves),
            Unjudged => percent(summary.answers[2], summary.solves),
            Error(i) => summary.errors[i].most,
            Covered(i) => coverage(i).map_or(f64::NAN, |of| 100.0 * of.share),
            Ratio(i) => coverage(i).map_or(f64::NAN, |of| of.ratio),
        }
    }

    /// Whether a value is within a bound, which is the least share for what is covered. What is not a number is not.
    fn is_within(self, value: f64, bound: f64) -> bool {
        match self {
            Covered(_) => value >= bound,
            _ => value <= bound,
        }
    }

    /// The value and its bound, in words.
    fn complaint(self, value: f64, bound: f64) -> String {
        match self {
            Unbalanced => format!("{value:.2} % do not balance, allowed {bound} %"),
            OtherBranch => {
                format!("{value:.2} % on another branch than that from rest, allowed {bound} %")
            }
            MissedOpposed => {
                format!(
                    "{value:.2} % missed with contacts that oppose each other, allowed {bound} %"
                )
            }
            Missed => format!("{value:.2} % missed, allowed {bound} %"),
            Open => {
                format!("{value:.2} % without an answer and not looked into, allowed {bound} %")
            }
            Unjudged => format!("{value:.2} % unjudged, allowed {bound} %"),
            Error(i) => format!("error of {} {value:.1e}, allowed {bound:.0e}", NAMES[i]),
            Covered(i) => {
                let name = NAMES[i];
                format!(
                    "{value:.2} % of the errors of {name} are estimated, at least {bound} % must be"
                )
            }
            Ratio(i) => {
                let name = NAMES[i];
                format!(
                    "estimates of {name} are {value:.1} times too large in the median, allowed {bound}"
                )
            }
        }
    }
}

/// What is promised of a figure, if anything is.
fn promised(figure: Figure, family: Family, precision: Precision) -> Option<f64> {
    let promise = promise(family);
    match figure {
        Unbalanced => Some(0.0),
        OtherBranch => promise.other_branch,
        MissedOpposed => Some(promise.missed),
        Missed | Open | Unjudged => None,
        Error(i) => match precision {
            Precision::F32 => promise.errors.map(|errors| errors[i]),
            Precision::F64 => None,
        },
        Covered(_) => promise.covered,
        Ratio(_) => promise.covered.map(|_| RATIO),
    }
}

/// A promise that the measured solver does not keep, and the bound that holds until the solver does.
type Gap = (Family, Precision, Figure, f64);

/// What of the promise is not kept yet, in 20,000 solves of the default seed. A row's bound has a little room; a row goes
/// when the solver keeps the promise.
#[rustfmt::skip]
pub const NOT_KEPT_YET: &[Gap] = &[
    // not kept yet: 46.6 times, promised 30
    (Family::Random, Precision::F32, Ratio(0), 52.0),
    // not kept yet: 69.0 times, promised 30
    (Family::Random, Precision::F32, Ratio(1), 76.0),
    // not kept yet: 51.9 times, promised 30
    (Family::Random, Precision::F32, Ratio(2), 58.0),
    // not kept yet: 78.8 times, promised 30
    (Family::Random, Precision::F64, Ratio(0), 87.0),
    // not kept yet: 81.7 times, promised 30
    (Family::Random, Precision::F64, Ratio(1), 90.0),
    // not kept yet: 47.0 times, promised 30
    (Family::Random, Precision::F64, Ratio(2), 52.0),
    // not kept yet: 1.6e-6, promised 1e-6
    (Family::Moderate, Precision::F32, Error(0), 1.9e-6),
    // not kept yet: just above the promised 1e-6
    (Family::Moderate, Precision::F32, Error(1), 1.2e-6),
    // not kept yet: 31.6 times, promised 30
    (Family::Moderate, Precision::F32, Ratio(1), 35.0),
    // not kept yet: 33.4 times, promised 30
    (Family::Moderate, Precision::F32, Ratio(2), 37.0),
    // not kept yet: 99.79 %, promised 99.9 %
    (Family::Moderate, Precision::F64, Covered(1), 99.6),
    // not kept yet: 58.4 times, promised 30
    (Family::Moderate, Precision::F64, Ratio(1), 65.0),
    // not kept yet: 99.51 %, promised 99.9 %
    (Family::Moderate, Precision::F64, Covered(2), 99.4),
    // not kept yet: 32.0 times, promised 30
    (Family::Moderate, Precision::F64, Ratio(2), 36.0),
    // not kept yet: 51.8 times, promised 30
    (Family::Radial, Precision::F32, Ratio(0), 57.0),
    // not kept yet: 83.4 times, promised 30
    (Family::Radial, Precision::F32, Ratio(1), 92.0),
    // not kept yet: 36.8 times, promised 30
    (Family::Radial, Precision::F32, Ratio(2), 41.0),
    // not kept yet: 58.5 times, promised 30
    (Family::Radial, Precision::F64, Ratio(0), 65.0),
    // not kept yet: 100.1 times, promised 30
    (Family::Radial, Precision::F64, Ratio(1), 111.0),
    // not kept yet: 33.8 times, promised 30
    (Family::Radial, Precision::F64, Ratio(2), 38.0),
    // not kept yet: 1 of 1429, promised none
    (Family::FewBalls, Precision::F32, Unbalanced, 0.15),
    // not kept yet: just above the promised 1e-6
    (Family::Reversed, Precision::F32, Error(1), 1.2e-6),
    // not kept yet: 40.5 times, promised 30
    (Family::Reversed, Precision::F32, Ratio(0), 45.0),
    // not kept yet: 31.9 times, promised 30
    (Family::Reversed, Precision::F32, Ratio(1), 36.0),
    // not kept yet: 33.4 times, promised 30
    (Family::Reversed, Precision::F32, Ratio(2), 37.0),
    // not kept yet: 62.9 times, promised 30
    (Family::Reversed, Precision::F64, Ratio(0), 70.0),
    // not kept yet: 99.79 %, promised 99.9 %
    (Family::Reversed, Precision::F64, Covered(1), 99.6),
    // not kept yet: 58.2 times, promised 30
    (Family::Reversed, Precision::F64, Ratio(1), 65.0),
    // not kept yet: 99.72 %, promised 99.9 %
    (Family::Reversed, Precision::F64, Covered(2), 99.6),
    // not kept yet: 32.8 times, promised 30
    (Family::Reversed, Precision::F64, Ratio(2), 37.0),
    // not kept yet: 1.6e-6, promised 1e-6
    (Family::Moduli, Precision::F32, Error(0), 1.9e-6),
    // not kept yet: 1.3e-6, promised 1e-6
    (Family::Moduli, Precision::F32, Error(1), 1.5e-6),
    // not kept yet: 3.8e-5, promised 2e-5
    (Family::Moduli, Precision::F32, Error(2), 4.4e-5),
    // not kept yet: 2.5e-6, promised 1e-6
    (Family::InnerControl, Precision::F32, Error(0), 2.9e-6),
    // not kept yet: 1 of 1429, promised none
    (Family::ZeroLoads, Precision::F32, Unbalanced, 0.15),
    // not kept yet: 1.7e-6, promised 1e-6
    (Family::WarmDrift, Precision::F32, Error(0), 2.0e-6),
    // not kept yet: 57.6 times, promised 30
    (Family::WarmDrift, Precision::F64, Ratio(1), 64.0),
    // not kept yet: 30.8 times, promised 30
    (Family::WarmDrift, Precision::F64, Ratio(2), 34.0),
    // not kept yet: 1 of 1429, promised 0.05 %: a moment alone on an angular contact row, after 180 iterations
    (Family::Typed, Precision::F64, MissedOpposed, 0.1),
    // not kept yet: 1.7e-6, promised 1e-6
    (Family::WarmJumps, Precision::F32, Error(0), 2.0e-6),
    // not kept yet: 1.1e-6, promised 1e-6
    (Family::WarmJumps, Precision::F32, Error(1), 1.3e-6),
];

/// What a family reaches of figures that nothing is promised of.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Measured {
    /// Largest share without an answer though there is an equilibrium, in percent of the solves.
    missed: f64,
    /// Largest share without an answer that nobody looked into, in percent of the solves. Without this bound, a solver that
    /// refuses everything would miss nothing.
    open: f64,
    /// Largest share of answers that cannot be judged, in percent of the solves.
    unjudged: f64,
    /// Errors that 99 % of the answers are within.
    errors: [f64; 3],
    /// Least share of the errors within their estimates, in percent.
    covered: [f64; 3],
}

const fn row(
    missed: f64,
    open: f64,
    unjudged: f64,
    errors: [f64; 3],
    covered: [f64; 3],
) -> Measured {
    Measured {
        missed,
        open,
        unjudged,
        errors,
        covered,
    }
}

/// A figure that is bounded by the promise: no number, so that it would bound nothing.
const PROMISED: f64 = f64::NAN;

/// The table, in the order of [`Family::ALL`]: single precision, double precision.
///
/// Bounds have a little room beyond what 20,000 solves of the default seed show, which are always the same: errors half
/// as much again or more, counts a tenth or two cases. Where a change of the solver passes one by a case or two, look
/// whether other seeds say the same.
#[rustfmt::skip]
const MEASURED: [[Measured; 2]; 15] = [
    // random
    [row(1.2, 10.0, 0.4, [9e-6, 4e-6, 6e-5], [PROMISED, PROMISED, PROMISED]),
     row(0.8, 10.0, 0.5, [2e-14, 3e-14, 3e-13], [PROMISED, PROMISED, PROMISED])],
    // moderate
    [row(0.2, 0.9, 0.1, [PROMISED, PROMISED, PROMISED], [PROMISED, PROMISED, PROMISED]),
     row(0.2, 0.9, 0.1, [3e-14, 3e-14, 2e-13], [PROMISED, PROMISED, PROMISED])],
    // radial
    [row(0.3, 4.0, 0.1, [2e-6, 3e-6, 8e-5], [PROMISED, PROMISED, PROMISED]),
     row(0.5, 4.0, 0.1, [2e-14, 3e-14, 4e-13], [PROMISED, PROMISED, PROMISED])],
    // few-balls: some of these were refused before, and are the least well known
    [row(1.7, 17.2, 19.4, [2e0, 2e-4, 4e-1], [97.1, 99.2, 90.3]),
     row(0.9, 28.8, 12.0, [4e-11, 3e-13, 4e-9], [98.8, 99.5, 93.5])],
    // opening
    [row(0.7, 0.5, 0.5, [1e-2, 5e-6, 4e-3], [98.7, 99.5, 99.5]),
     row(0.1, 0.8, 0.1, [2e-11, 3e-14, 2e-11], [99.0, 99.5, 99.5])],
    // extreme-angles
    [row(0.1, 0.1, 0.1, [2e-6, 2e-6, 3e-5], [99.5, 99.5, 99.5]),
     row(0.1, 0.1, 0.1, [2e-14, 1e-14, 2e-13], [99.5, 99.5, 99.5])],
    // reversed
    [row(0.2, 1.1, 0.1, [PROMISED, PROMISED, PROMISED], [PROMISED, PROMISED, PROMISED]),
     row(0.2, 1.1, 0.1, [2e-14, 4e-14, 2e-13], [PROMISED, PROMISED, PROMISED])],
    // deep-groove: one in thirty is a radial load on two balls, about which the ring is free to tilt
    [row(0.2, 3.6, 0.3, [6e-6, 6e-6, 4e-5], [99.2, 99.5, 99.5]),
     row(0.1, 3.6, 0.1, [2e-14, 8e-15, 2e-13], [99.5, 99.5, 99.5])],
    // moduli
    [row(0.1, 0.7, 0.1, [PROMISED, PROMISED, PROMISED], [99.5, 99.5, 99.5]),
     row(0.1, 0.7, 0.1, [3e-14, 3e-14, 2e-13], [99.5, 99.5, 99.5])],
    // inner-control
    [row(0.1, 0.3, 0.1, [PROMISED, PROMISED, PROMISED], [99.5, 99.5, 99.5]),
     row(0.1, 0.3, 0.1, [2e-14, 4e-15, 8e-14], [99.5, 99.5, 99.5])],
    // zero-loads
    [row(0.3, 7.0, 0.3, [7e-6, 2e-6, 7e-5], [99.5, 99.5, 99.3]),
     row(0.3, 7.0, 0.3, [3e-14, 3e-14, 3e-13], [99.5, 99.5, 99.2])],
    // warm-drift
    [row(0.1, 1.6, 0.1, [PROMISED, PROMISED, PROMISED], [PROMISED, PROMISED, PROMISED]),
     row(0.1, 1.6, 0.1, [3e-14, 2e-14, 2e-13], [PROMISED, PROMISED, PROMISED])],
    // warm-jumps
    [row(0.1, 0.7, 0.1, [PROMISED, PROMISED, PROMISED], [99.5, 99.5, 99.5]),
     row(0.1, 0.7, 0.1, [2e-14, 4e-14, 2e-13], [99.5, 99.5, 99.5])],
    // any-bits
    [row(0.1, 1.1, 0.3, [4e-6, 2e-6, 4e-5], [99.5, 99.5, 99.5]),
     row(0.1, 1.2, 0.1, [2e-14, 9e-15, 2e-13], [99.5, 99.5, 99.5])],
    // typed
    [row(0.05, 9.0, 1.0, [1e-5, 2e-6, 4e-4], [99.5, 99.5, 97.0]),
     row(0.1, 9.0, 1.0, [2e-14, 4e-15, 2e-9], [99.5, 99.5, 98.3])],
];

/// What a figure must be within in the tests, if anything: the promise; the bound of a promise that is not kept yet; or
/// what is measured of a figure without a promise.
pub fn bound(figure: Figure, family: Family, precision: Precision) -> Option<f64> {
    let gap = NOT_KEPT_YET
        .iter()
        .find(|gap| (gap.0, gap.1, gap.2) == (family, precision, figure));
    if let Some(&(.., bound)) = gap {
        return Some(bound);
    }
    let measured = &MEASURED[family as usize][precision as usize];
    promised(figure, family, precision).or(match figure {
        Missed => Some(measured.missed),
        Open => Some(measured.open),
        Unjudged => Some(measured.unjudged),
        Error(i) => Some(measured.errors[i]),
        Covered(i) => Some(measured.covered[i]),
        _ => None,
    })
}

/// What of these figures is not within its bound, in words.
fn beyond(
    summary: &Summary,
    meant: fn(Figure) -> bool,
    bound: fn(Figure, Family, Precision) -> Option<f64>,
) -> Vec<String> {
    let (family, precision) = (summary.family, summary.precision);
    let complaints = FIGURES
        .into_iter()
        .filter(|figure| meant(*figure))
        .filter_map(|figure| {
            let (value, bound) = (figure.of(summary), bound(figure, family, precision)?);
            let place = format!("{} in {precision:?}", family.name());
            (!figure.is_within(value, bound))
                .then(|| format!("{place}: {}", figure.complaint(value, bound)))
        });
    complaints.collect()
}

/// What must never be, in words.
fn failed(summary: &Summary) -> Option<String> {
    let (family, precision, failed) = (summary.family.name(), summary.precision, summary.failed);
    (failed > 0).then(|| format!("{family} in {precision:?}: {failed} failed"))
}

/// What a family does not keep of its promise, in words.
pub fn unkept(summary: &Summary) -> Vec<String> {
    let mut unkept = Vec::from_iter(failed(summary));
    unkept.extend(beyond(summary, |_| true, promised));
    unkept
}

/// What a family has that must never be, or more than its bounds of answers that do not balance or are on another
/// branch, in words.
pub fn wrong(summary: &Summary) -> Vec<String> {
    let mut wrong = Vec::from_iter(failed(summary));
    let meant = |figure| matches!(figure, Unbalanced | OtherBranch);
    wrong.extend(beyond(summary, meant, bound));
    wrong
}

/// What a family misses or leaves unjudged beyond its bounds, in words.
pub fn missed(summary: &Summary) -> Vec<String> {
    let meant = |figure| matches!(figure, MissedOpposed | Missed | Open | Unjudged);
    beyond(summary, meant, bound)
}

/// Which errors of a family are beyond their bounds, in words.
pub fn inaccurate(summary: &Summary) -> Vec<String> {
    beyond(summary, |figure| matches!(figure, Error(_)), bound)
}

/// Which errors of a family are estimated too rarely or too largely, in words.
pub fn underestimated(summary: &Summary) -> Vec<String> {
    let meant = |figure| matches!(figure, Covered(_) | Ratio(_));
    beyond(summary, meant, bound)
}

/// Rows of [`NOT_KEPT_YET`] that are not what they say, in words: no promise, one that is stricter than the row's own
/// bound is, or a second row for a figure.
pub fn false_gaps() -> Vec<String> {
    let mut wrong = Vec::new();
    for (i, &(family, precision, figure, bound)) in NOT_KEPT_YET.iter().enumerate() {
        let place = format!("{} in {precision:?}, {figure:?}", family.name());
        match promised(figure, family, precision) {
            None => wrong.push(format!("{place}: nothing is promised")),
            Some(promise) if figure.is_within(bound, promise) => {
                wrong.push(format!("{place}: {bound} keeps the promise of {promise}"));
            }
            Some(_) => {}
        }
        let same = |other: &&Gap| (other.0, other.1, other.2) == (family, precision, figure);
        if NOT_KEPT_YET[..i].iter().any(|other| same(&other)) {
            wrong.push(format!("{place}: twice"));
        }
    }
    wrong
}

/// Bounds on the estimates of all families together, in a precision.
struct Estimates {
    /// Least share of the errors of displacement, force and stiffness that are estimated, in percent, and largest median
    /// of estimate over error.
    of: [(f64, f64); 3],
    /// Largest share of the answers that deceive, in percent.
    deceiving: f64,
}

/// In single and in double precision; measured, in 20,000 and in 80,000 solves, with a little room.
///
/// Not kept yet: 99.85 % of every error covered, estimates 30 times too large at most, 0.01 % deceiving. The last is kept
/// in double precision; in single precision, nine in ten of the answers that deceive are of few-balls.
const ESTIMATES: [Estimates; 2] = [
    Estimates {
        of: [(99.6, 35.0), (99.8, 51.0), (99.4, 44.0)],
        deceiving: 0.2,
    },
    Estimates {
        of: [(99.8, 50.0), (99.8, 80.0), (99.3, 44.0)],
        deceiving: 0.01,
    },
];

/// An answer deceives whose error is larger than the first of these and than so many times its own estimate.
const DECEIVES: (f64, f64) = (1e-3, RATIO);

/// Whether an answer deceives.
pub fn deceives(record: &Record) -> bool {
    let (least, times) = DECEIVES;
    record
        .errors
        .iter()
        .zip(&record.estimate)
        .any(|(errors, estimate)| {
            errors
                .iter()
                .zip(estimate)
                .any(|(error, of)| *error > least && *error > times * of)
        })
}

/// What the estimates of a campaign over all families do not hold, in words.
pub fn broken_estimates(records: &[Record]) -> Vec<String> {
    let mut broken = Vec::new();
    for (precision, bounds) in PRECISIONS.into_iter().zip(ESTIMATES) {
        let of = report::coverage(records.iter().filter(|r| r.precision == precision));
        let figures = NAMES
            .into_iter()
            .zip(of.into_iter().flatten())
            .zip(bounds.of);
        for ((what, coverage), (least, largest)) in figures {
            let share = 100.0 * coverage.share;
            if !(share >= least && coverage.ratio <= largest) {
                broken.push(format!(
                    "all families in {precision:?}: {share:.2} % of the errors of {what} are estimated, \
                     {:.1} times too large in the median; must be {least} %, {largest} times",
                    coverage.ratio
                ));
            }
        }
        if of.is_none() {
            broken.push(format!("no errors in {precision:?}"));
        }
        let answers = records
            .iter()
            .filter(|r| r.precision == precision && r.errors.is_some());
        let deceiving = answers.clone().filter(|r| deceives(r)).count();
        if 100.0 * deceiving as f64 > bounds.deceiving * answers.count() as f64 {
            broken.push(format!(
                "all families in {precision:?}: {deceiving} answers are off by far more than they say, allowed {} %",
                bounds.deceiving
            ));
        }
    }
    broken
}
