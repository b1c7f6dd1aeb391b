//! Claims judged: values of a measure, the numbers they make, and whether these are within their bounds.

use super::book::{Chapter, Claim, Measure, Place};
use super::case::Case;
use super::cases::Solved;
use anyhow::{Context, bail, ensure};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Values of one column along one run.
#[derive(Debug, Clone)]
pub struct Line<'s> {
    /// Name of the run.
    pub run: &'s str,
    /// The cases.
    pub cases: Vec<&'s Case>,
    /// A value for each, in the unit of the page.
    pub values: Vec<f64>,
}

/// A measure and its numbers.
#[derive(Debug, Clone)]
pub struct Judged<'b> {
    /// The measure.
    pub measure: &'b Measure,
    /// The numbers, in the unit of the page.
    pub numbers: Vec<f64>,
}

/// A claim and its measures.
#[derive(Debug, Clone)]
pub struct JudgedClaim<'b> {
    /// The claim.
    pub claim: &'b Claim,
    /// Its measures.
    pub measures: Vec<Judged<'b>>,
}

/// Judges every claim of a chapter by its solved runs.
///
/// # Errors
///
/// A measure that names no run or column, or has no bound.
pub fn judge<'b>(chapter: &'b Chapter, runs: &[Solved]) -> anyhow::Result<Vec<JudgedClaim<'b>>> {
    let of_measure = |measure: &'b Measure| {
        let numbers = numbers(measure, runs).with_context(|| measure.name.clone())?;
        Ok(Judged { measure, numbers })
    };
    let of_claim = |claim: &'b Claim| {
        ensure!(!claim.measure.is_empty(), "nothing decides about it");
        let measures = claim.measure.iter().map(of_measure);
        let measures = measures.collect::<anyhow::Result<_>>()?;
        Ok(JudgedClaim { claim, measures })
    };
    let claims = chapter.claim.iter().map(|claim| {
        let judged: anyhow::Result<JudgedClaim<'b>> = of_claim(claim);
        judged.with_context(|| format!("{}: {}", chapter.title, claim.claim))
    });
    claims.collect()
}

impl JudgedClaim<'_> {
    /// Sentence about the measures that are out of their bounds, if any are.
    pub fn complaint(&self) -> Option<String> {
        let wrong = self.measures.iter().filter(|one| !one.holds());
        let wrong: Vec<String> = wrong
            .map(|one| format!("{}: {:?}", one.measure.name, one.numbers))
            .collect();
        (!wrong.is_empty()).then(|| format!("\"{}\": {}", self.claim.claim, wrong.join("; ")))
    }
}

impl Judged<'_> {
    /// Whether there are numbers, and all of them are within every bound; what is not a number is nowhere.
    pub fn holds(&self) -> bool {
        let m = self.measure;
        let near = |(ours, published): (&f64, &f64)| {
            let off = (ours - published).abs();
            m.within.is_none_or(|most| off <= most)
                && (m.within_percent).is_none_or(|most| off <= 0.01 * most * published.abs())
        };
        let bounded = m.above.is_some() || m.below.is_some() || m.rounding.is_some();
        let compared = m.within.is_some() || m.within_percent.is_some();
        (bounded || compared)
            && (!compared || m.published.len() == self.numbers.len())
            && !self.numbers.is_empty()
            && self.numbers.iter().zip(m.published.iter()).all(near)
            && self.numbers.iter().all(|&number| {
                number.is_finite()
                    && m.above.is_none_or(|bound| number > bound)
                    && m.below.is_none_or(|bound| number < bound)
                    && m.rounding.is_none_or(|bound| number.abs() <= bound)
            })
    }
}

/// Values of a measure, a line for each run and column.
///
/// # Errors
///
/// A run or a column that is not there, or lines that cannot be compared.
pub fn lines<'s>(measure: &Measure, runs: &'s [Solved]) -> anyhow::Result<Vec<Line<'s>>> {
    let named = |names: &[String]| -> anyhow::Result<Vec<&'s Solved>> {
        let find = |name: &String| {
            let found = runs.iter().find(|run| run.name == *name);
            found.with_context(|| format!("no run {name:?}"))
        };
        names.iter().map(find).collect()
    };
    let of = match &*measure.run {
        [] => runs.iter().collect(),
        names => named(names)?,
    };
    let against = match &*measure.against {
        [] => of.clone(),
        names => named(names)?,
    };
    type Compare = fn(f64, f64) -> f64;
    let (others, compared): (&[String], Compare) = if !measure.less.is_empty() {
        (&measure.less, |value, other| value - other)
    } else if !measure.over.is_empty() {
        (&measure.over, |value, other| value / other)
    } else {
        (&measure.off, |value, other| value / other - 1.0)
    };
    let scale = factor(&measure.unit)?;
    ensure!(!measure.of.is_empty(), "no column");

    let mut lines = Vec::new();
    for (i, run) in of.iter().enumerate() {
        let other_run = cycled(&against, i);
        let cases = at(run, &measure.at);
        let other_cases = at(
            other_run,
            measure.against_at.as_ref().unwrap_or(&measure.at),
        );
        ensure!(
            others.is_empty() || [1, cases.len()].contains(&other_cases.len()),
            "{} and {}: not as many cases",
            run.name,
            other_run.name
        );
        for j in 0..measure.of.len().max(others.len()) {
            let column = cycled(&measure.of, j);
            let one = |(k, case): (usize, &&Case)| {
                let value = get(case, column)?;
                if others.is_empty() {
                    return Ok(scale * value);
                }
                let other = get(other_cases[k % other_cases.len()], cycled(others, j))?;
                Ok(scale * compared(value, other))
            };
            let values: anyhow::Result<Vec<f64>> = cases.iter().enumerate().map(one).collect();
            lines.push(Line {
                run: &run.name,
                values: values?,
                cases: cases.clone(),
            });
        }
    }
    Ok(lines)
}

/// The value at `i`, or the only one.
fn cycled<T>(values: &[T], i: usize) -> &T {
    &values[i % values.len()]
}

fn get(case: &Case, column: &String) -> anyhow::Result<f64> {
    let value = case.get(column).copied();
    value.with_context(|| format!("no column {column}"))
}

/// Cases of a run at these places.
fn at<'s>(run: &'s Solved, places: &BTreeMap<String, Place>) -> Vec<&'s Case> {
    let mut cases: Vec<&Case> = run.cases.iter().collect();
    for (column, place) in places {
        let value = |case: &Case| case.get(column).copied().unwrap_or(f64::NAN);
        match *place {
            Place::Range([from, to]) => cases.retain(|case| (from..=to).contains(&value(case))),
            Place::Value(wanted) => {
                let off = |case: &Case| (value(case) - wanted).abs();
                let nearest = cases
                    .iter()
                    .map(|case| off(case))
                    .fold(f64::INFINITY, f64::min);
                cases.retain(|case| off(case) <= nearest);
            }
        }
    }
    cases
}

fn numbers(measure: &Measure, runs: &[Solved]) -> anyhow::Result<Vec<f64>> {
    let lines = lines(measure, runs)?;
    let all = lines.iter().flat_map(|line| line.values.clone());
    let taken = match statistic(&measure.take, &all.collect::<Vec<_>>()) {
        Some(number) => vec![number],
        None => {
            let each = lines.iter().map(|line| take(&measure.take, &line.values));
            each.collect::<anyhow::Result<Vec<_>>>()?.concat()
        }
    };
    take(&measure.then, &taken)
}

/// A number that all values of a measure make together, if it is one.
fn statistic(name: &str, values: &[f64]) -> Option<f64> {
    let sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    Some(match name {
        "count" => values.len() as f64,
        "median" => quantile(values, 0.5),
        "10 %" => quantile(values, 0.1),
        "90 %" => quantile(values, 0.9),
        "median size" => quantile(&sizes, 0.5),
        "90 % of sizes" => quantile(&sizes, 0.9),
        "largest size" => quantile(&sizes, 1.0),
        _ => return None,
    })
}

/// Numbers that the values of one line make. Sine and cosine are parts of the first harmonic along the azimuth.
fn take(name: &str, values: &[f64]) -> anyhow::Result<Vec<f64>> {
    let n = values.len() as f64;
    let azimuths = || (0..values.len()).map(|i| TAU * i as f64 / n);
    let part = |of: fn(f64) -> f64| {
        let products = values.iter().zip(azimuths()).map(|(v, a)| v * of(a));
        2.0 * products.sum::<f64>() / n
    };
    let [cosine, sine] = [f64::cos, f64::sin].map(part);
    let amplitude = cosine.hypot(sine);
    Ok(match name {
        "" => values.to_vec(),
        "step" => values.windows(2).map(|w| w[1] - w[0]).collect(),
        "ratio" => values.windows(2).map(|w| w[0] / w[1]).collect(),
        "least" => vec![quantile(values, 0.0)],
        "largest" => vec![quantile(values, 1.0)],
        "rise" => {
            let last = values.last().context("a rise of no values")?;
            vec![last / quantile(values, 0.0) - 1.0]
        }
        "cosine" => vec![cosine],
        "sine" => vec![sine],
        "amplitude" => vec![amplitude],
        "cosine over sine" => vec![cosine / sine],
        "sine over cosine" => vec![sine / cosine],
        "overtones" => {
            let mean = values.iter().sum::<f64>() / n;
            let off = |(v, a): (&f64, f64)| {
                (v - mean - cosine * a.cos() - sine * a.sin()).abs() / amplitude
            };
            let overtones: Vec<f64> = values.iter().zip(azimuths()).map(off).collect();
            vec![quantile(&overtones, 1.0)]
        }
        _ => bail!("no numbers {name:?}"),
    })
}

/// The value below which this part of them is; values that are no numbers are the largest.
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    let last = values.len().saturating_sub(1);
    let place = (part * last as f64).round() as usize;
    values.get(place).copied().unwrap_or(f64::NAN)
}

/// Factor from the unit of a column to a unit of the page.
pub fn factor(unit: &str) -> anyhow::Result<f64> {
    Ok(match unit {
        "" | "N" | "N m" | "rpm" | "mm pitch" | "million revolutions" => 1.0,
        "°" => 1f64.to_degrees(),
        "%" => 100.0,
        "µm" => 1e6,
        "mm" => 1e3,
        "kN" | "1000 rpm" | "N/mrad" | "N m/mrad" => 1e-3,
        "N/µm" => 1e-6,
        _ => bail!("no unit {unit:?}"),
    })
}
