//! Counts and figures of many solves, and tables of them.

use super::families::Family;
use super::judge::{Branch, Record, Verdict};
use crate::dispatch::Precision;

/// Median, 99th percentile and worst; NaN of nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Half of the values are no larger.
    pub median: f64,
    /// 99 % of the values are no larger.
    pub most: f64,
    /// The largest.
    pub worst: f64,
}

impl Spread {
    /// Of these values, none of which is NaN.
    pub fn of(values: impl Iterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.collect();
        values.sort_unstable_by(f64::total_cmp);
        let nearest_rank = |share: f64| {
            let rank = (share * values.len() as f64).ceil() as usize;
            values
                .get(rank.saturating_sub(1))
                .copied()
                .unwrap_or(f64::NAN)
        };
        Self {
            median: nearest_rank(0.5),
            most: nearest_rank(0.99),
            worst: nearest_rank(1.0),
        }
    }

    /// All three, as tables show them.
    pub fn show(&self, number: fn(f64) -> String) -> String {
        [self.median, self.most, self.worst].map(number).join(" / ")
    }
}

/// Counts and figures of some solves in one precision.
#[derive(Debug)]
pub struct Summary {
    /// All of the solves.
    pub solves: usize,
    /// Solves with an answer; answers that the reference build could not judge.
    pub solved: [usize; 2],
    /// Solves without an answer: no equilibrium is known; one is; nobody looked for one.
    pub unsolved: [usize; 3],
    /// Solves that came to what must never be.
    pub failed: usize,
    /// Answers whose forces do not balance.
    pub unbalanced: usize,
    /// Answers compared with the equilibrium on the branch from rest; answers that are another one.
    pub branches: [usize; 2],
    /// Iterations of the answers.
    pub iterations: Spread,
    /// Errors of displacement, force and stiffness.
    pub errors: [Spread; 3],
    /// Errors within the solver's own estimate, in percent of the answers.
    pub covered: [f64; 3],
    /// Median of estimate over error, of errors that are not 0.
    pub ratio: [f64; 3],
    /// Answers that are off by far more than they say.
    pub deceiving: usize,
}

impl Summary {
    /// Of these records.
    pub fn of(records: &[&Record]) -> Self {
        let count = |of: &dyn Fn(&Record) -> bool| records.iter().filter(|r| of(r)).count();
        let verdict = |v: Verdict| count(&|r| r.verdict == v);
        let other = count(&|r| r.branch == Some(Branch::Other));
        let answers: Vec<_> = records
            .iter()
            .filter_map(|r| Some((r.errors?, r.estimate?)))
            .collect();
        let covered = |i: usize| answers.iter().filter(|(e, of)| e[i] <= of[i]).count();
        let ratios = |i: usize| {
            let errors = answers.iter().filter(move |(e, _)| e[i] > 0.0);
            errors
                .map(move |(e, of)| of[i] / e[i])
                .filter(|x| !x.is_nan())
        };
        let iterations = records
            .iter()
            .filter(|r| r.is_solved())
            .filter_map(|r| r.iterations);
        Self {
            solves: records.len(),
            solved: [count(&Record::is_solved), verdict(Verdict::Unjudged)],
            unsolved: [Verdict::RightlyRefused, Verdict::Missed, Verdict::Undecided].map(verdict),
            failed: count(&|r| matches!(r.verdict, Verdict::Failed(_))),
            unbalanced: count(&Record::is_unbalanced),
            branches: [
                other + count(&|r| r.branch == Some(Branch::FromRest)),
                other,
            ],
            iterations: Spread::of(iterations.map(f64::from)),
            errors: [0, 1, 2].map(|i| Spread::of(answers.iter().map(|(e, _)| e[i]))),
            covered: [0, 1, 2].map(|i| percent(covered(i), answers.len())),
            ratio: [0, 1, 2].map(|i| Spread::of(ratios(i)).median),
            deceiving: count(&Record::deceives),
        }
    }
}

/// The records of a family, or of all, in a precision.
pub fn part(records: &[Record], family: Option<Family>, precision: Precision) -> Vec<&Record> {
    let of = |r: &&Record| r.precision == precision && family.is_none_or(|f| f == r.family);
    records.iter().filter(of).collect()
}

/// A count in percent of another.
pub fn percent(count: usize, all: usize) -> f64 {
    100.0 * count as f64 / all as f64
}

/// A precision, as tables call it.
pub fn name(precision: Precision) -> &'static str {
    match precision {
        Precision::F32 => "f32",
        Precision::F64 => "f64",
    }
}

/// A Markdown table, its columns padded so that the source can be read, too.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let width = |i: usize| {
        let cells = rows.iter().map(|row| row[i].chars().count());
        cells.chain([head[i].chars().count(), 3]).max().unwrap_or(3)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    // Numbers line up on the right.
    let dashes = |(i, width): (usize, &usize)| match i {
        0 => "-".repeat(*width),
        _ => format!("{}:", "-".repeat(width - 1)),
    };
    let head = head.iter().map(|cell| (*cell).to_owned()).collect();
    let lines = [head, widths.iter().enumerate().map(dashes).collect()];
    let mut text = String::new();
    for row in lines.iter().chain(rows) {
        text.push('|');
        for (i, (cell, width)) in row.iter().zip(&widths).enumerate() {
            text += &match i {
                0 => format!(" {cell:<width$} |"),
                _ => format!(" {cell:>width$} |"),
            };
        }
        text.push('\n');
    }
    text + "\n"
}
