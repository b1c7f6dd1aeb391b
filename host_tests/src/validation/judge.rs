//! Claims judged: values of a measure, the numbers they make, and whether these are within their bounds.

use super::book::{Chapter, Claim, Measure, Place, Take};
use super::cases::{Case, Solved};
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
    let find = |name: &String| {
        let found = runs.iter().find(|run| run.name == *name);
        found.with_context(|| format!("no run {name:?}"))
    };
    let found: anyhow::Result<Vec<&Solved>> = measure.run.iter().map(find).collect();
    let mut of = found?;
    if of.is_empty() {
        of = runs.iter().collect();
    }
    let found: anyhow::Result<Vec<&Solved>> = measure.against.iter().map(find).collect();
    let mut against = found?;
    if against.is_empty() {
        against.clone_from(&of);
    }
    let compare = [&measure.less, &measure.over, &measure.off];
    let others = compare.iter().find(|columns| !columns.is_empty());
    let scale = factor(&measure.unit)?;

    let mut lines = Vec::new();
    for (i, run) in of.iter().enumerate() {
        let other_run = cycled(&against, i);
        let cases = at(run, &measure.at);
        let other_at = measure.against_at.as_ref().unwrap_or(&measure.at);
        let other_cases = at(other_run, other_at);
        for j in 0..measure.of.len().max(others.map_or(0, |o| o.len())) {
            let column = cycled(&measure.of, j);
            let other = others.map(|columns| cycled(columns, j));
            let one = |(k, case): (usize, &&Case)| {
                let value = get(case, column)?;
                let Some(other) = other else {
                    return Ok(scale * value);
                };
                let same = other_cases.len() == cases.len() || other_cases.len() == 1;
                ensure!(
                    same,
                    "{} and {}: not as many cases",
                    run.name,
                    other_run.name
                );
                let other = get(other_cases[k % other_cases.len()], other)?;
                Ok(scale
                    * if !measure.less.is_empty() {
                        value - other
                    } else if !measure.over.is_empty() {
                        value / other
                    } else {
                        value / other - 1.0
                    })
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

fn get(case: &Case, column: &str) -> anyhow::Result<f64> {
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
    let together = matches!(
        measure.take,
        Take::Median
            | Take::Tenth
            | Take::NineTenths
            | Take::MedianSize
            | Take::NineTenthsOfSizes
            | Take::LargestSize
            | Take::Count
    );
    let taken = if together {
        let values: Vec<f64> = lines.into_iter().flat_map(|line| line.values).collect();
        take(measure.take, &values)
    } else {
        let each = lines
            .iter()
            .flat_map(|line| take(measure.take, &line.values));
        each.collect()
    };
    Ok(take(measure.then, &taken))
}

fn take(what: Take, values: &[f64]) -> Vec<f64> {
    let sizes: Vec<f64> = values.iter().map(|value| value.abs()).collect();
    let n = values.len() as f64;
    let azimuths = || (0..values.len()).map(|i| TAU * i as f64 / n);
    let part = |of: fn(f64) -> f64| {
        let products = values.iter().zip(azimuths()).map(|(v, a)| v * of(a));
        2.0 * products.sum::<f64>() / n
    };
    let [cosine, sine] = [f64::cos, f64::sin].map(part);
    let amplitude = cosine.hypot(sine);
    match what {
        Take::All => values.to_vec(),
        Take::Least => vec![quantile(values, 0.0)],
        Take::Largest => vec![quantile(values, 1.0)],
        Take::Step => values.windows(2).map(|w| w[1] - w[0]).collect(),
        Take::Ratio => values.windows(2).map(|w| w[0] / w[1]).collect(),
        Take::Rise => values
            .last()
            .map(|v| v / quantile(values, 0.0) - 1.0)
            .into_iter()
            .collect(),
        Take::Count => vec![n],
        Take::Cosine => vec![cosine],
        Take::Sine => vec![sine],
        Take::Amplitude => vec![amplitude],
        Take::CosineOverSine => vec![cosine / sine],
        Take::SineOverCosine => vec![sine / cosine],
        Take::Overtones => {
            let mean = values.iter().sum::<f64>() / n;
            let rest = values
                .iter()
                .zip(azimuths())
                .map(|(v, a)| (v - mean - cosine * a.cos() - sine * a.sin()).abs() / amplitude);
            vec![quantile(&rest.collect::<Vec<_>>(), 1.0)]
        }
        Take::Median => vec![quantile(values, 0.5)],
        Take::Tenth => vec![quantile(values, 0.1)],
        Take::NineTenths => vec![quantile(values, 0.9)],
        Take::MedianSize => vec![quantile(&sizes, 0.5)],
        Take::NineTenthsOfSizes => vec![quantile(&sizes, 0.9)],
        Take::LargestSize => vec![quantile(&sizes, 1.0)],
    }
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
