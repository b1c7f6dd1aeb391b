//! Every figure as a row: what the JSON file holds, and what page and charts are made of.

use crate::image::{Motion, name};
use host_tests::campaign::report::Spread;
use host_tests::dispatch::Precision;
use serde::Serialize;
use tools::timing::Core;

/// What a solve starts from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Start {
    /// Nothing.
    Cold,
    /// The solution a tick before.
    Warm,
}

impl Start {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Cold, Self::Warm];

    /// Its name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cold => "cold",
            Self::Warm => "warm",
        }
    }
}

/// What a figure is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct At {
    /// The modelled core; none for figures that are the same everywhere.
    pub core: Option<Core>,
    /// Working precision.
    pub precision: Precision,
    /// Scene and rule of attitude.
    pub motion: Motion,
    /// Ball count.
    pub balls: usize,
    /// The start; none for figures that do not depend on it.
    pub start: Option<Start>,
}

/// A figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The modelled core, `host`, or `any`.
    pub core: &'static str,
    /// `f32`, `f64`, or what else computes.
    pub precision: &'static str,
    /// `at speed` or `static`; the name of one that leaves out more.
    pub scene: &'static str,
    /// The rule of attitude; none at rest.
    pub attitude: Option<&'static str>,
    /// Ball count.
    pub balls: usize,
    /// `cold` or `warm`, if it matters.
    pub start: Option<&'static str>,
    /// What is told.
    pub metric: String,
    /// Which of many values: `median`, `99 %`, `worst`, `mean`; `value` of a single one.
    pub stat: &'static str,
    /// The figure.
    pub value: f64,
    /// Its unit; `1` of ratios and counts.
    pub unit: &'static str,
}

/// All figures.
#[derive(Debug, Clone, Default)]
pub struct Rows(Vec<Row>);

fn row(at: &At, metric: &str, stat: &'static str, value: f64, unit: &'static str) -> Row {
    let at_speed = at.motion != Motion::Static;
    Row {
        core: at.core.map_or("any", Core::name),
        precision: name(at.precision),
        scene: if at_speed { "at speed" } else { "static" },
        attitude: at_speed.then(|| at.motion.name()),
        balls: at.balls,
        start: at.start.map(Start::name),
        metric: metric.to_owned(),
        stat,
        value,
        unit,
    }
}

impl Rows {
    /// Adds a figure.
    pub fn add(
        &mut self,
        at: &At,
        metric: &str,
        stat: &'static str,
        value: f64,
        unit: &'static str,
    ) {
        self.0.push(row(at, metric, stat, value, unit));
    }

    /// Adds median, 99th percentile and largest of many values, if there are any.
    pub fn spread(&mut self, at: &At, metric: &str, values: &[f64], unit: &'static str) {
        if values.is_empty() {
            return;
        }
        let spread = Spread::of(values.iter().copied());
        self.add(at, metric, "median", spread.median, unit);
        self.add(at, metric, "99 %", spread.most, unit);
        self.add(at, metric, "worst", spread.worst, unit);
    }

    /// Adds a row that is not about a modelled solver.
    pub fn push(&mut self, row: Row) {
        self.0.push(row);
    }

    /// Adds all of another's.
    pub fn append(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// A figure; NaN if there is none.
    pub fn get(&self, at: &At, metric: &str, stat: &'static str) -> f64 {
        let wanted = row(at, metric, stat, 0.0, "");
        self.0
            .iter()
            .find(|r| {
                (r.core, r.precision, r.scene, r.attitude, r.balls, r.start)
                    == (
                        wanted.core,
                        wanted.precision,
                        wanted.scene,
                        wanted.attitude,
                        wanted.balls,
                        wanted.start,
                    )
                    && r.metric == metric
                    && r.stat == stat
            })
            .map_or(f64::NAN, |r| r.value)
    }

    /// All of them.
    pub fn all(&self) -> &[Row] {
        &self.0
    }
}
