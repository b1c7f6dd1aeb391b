//! Counts and figures of many solves, and tables of them.

use super::families::Family;
use super::judge::Record;
use solvers::dispatch::Precision;
use std::array::from_fn;

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
        let shown = |x: f64| match x {
            x if x.is_nan() => "-".to_owned(),
            x => number(x),
        };
        [self.median, self.most, self.worst].map(shown).join(" / ")
    }
}

/// Errors of displacement, force and stiffness.
pub fn errors(records: &[&Record]) -> [Spread; 3] {
    from_fn(|i| Spread::of(records.iter().filter_map(|r| Some(r.errors?[i]))))
}

/// Estimates over errors, of errors that are not 0.
pub fn ratios(records: &[&Record]) -> [Spread; 3] {
    from_fn(|i| {
        let ratios = records.iter().filter_map(|r| {
            let (error, estimate) = (r.errors?[i], r.estimate?[i]);
            (error > 0.0).then_some(estimate / error)
        });
        Spread::of(ratios.filter(|ratio| !ratio.is_nan()))
    })
}

/// Errors within the solver's own estimate, in percent of the answers.
pub fn covered(records: &[&Record]) -> [f64; 3] {
    from_fn(|i| {
        let covered = |r: &Record| Some(r.errors?[i] <= r.estimate?[i]);
        share(
            records,
            |r| covered(r) == Some(true),
            |r| covered(r).is_some(),
        )
    })
}

/// The records of a family, or of all, in a precision.
pub fn part(records: &[Record], family: Option<Family>, precision: Precision) -> Vec<&Record> {
    let of = |r: &&Record| r.precision == precision && family.is_none_or(|f| f == r.family);
    records.iter().filter(of).collect()
}

/// Records of one kind in percent of another kind's; 0 % of nothing.
pub fn share(
    records: &[&Record],
    is: impl Fn(&Record) -> bool,
    of: impl Fn(&Record) -> bool,
) -> f64 {
    let all = records.iter().filter(|r| of(r)).count();
    let count = records.iter().filter(|r| of(r) && is(r)).count();
    100.0 * count as f64 / all.max(1) as f64
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
    let head: Vec<String> = head.iter().map(|cell| (*cell).to_owned()).collect();
    let width = |i: usize| {
        let cells = rows.iter().chain([&head]).map(|row| row[i].chars().count());
        cells.max().unwrap_or(0).max(3)
    };
    let widths: Vec<usize> = (0..head.len()).map(width).collect();
    // Numbers line up on the right.
    let dashes = |(i, &width): (usize, &usize)| match i {
        0 => "-".repeat(width),
        _ => format!("{:->width$}", ":"),
    };
    let dashes = widths.iter().enumerate().map(dashes).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate();
        let cells = cells.map(|(i, (cell, width))| match i {
            0 => format!(" {cell:<width$} |"),
            _ => format!(" {cell:>width$} |"),
        });
        format!("|{}\n", cells.collect::<String>())
    };
    let lines = [&head, &dashes].into_iter().chain(rows);
    lines.map(line).collect::<String>() + "\n"
}
