//! `host_tests/validation.toml` as types; the head of that file explains each key.

use crate::dispatch::Attitude;
use anyhow::Context;
use serde::Deserialize;
use std::collections::BTreeMap;

/// The file of claims.
pub const TEXT: &str = include_str!("../../validation.toml");

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Book {
    /// First paragraphs of the page.
    pub opening: String,
    /// Its chapters.
    pub chapter: Vec<Chapter>,
}

impl Book {
    /// Reads the text of the file.
    ///
    /// # Errors
    ///
    /// A key that is unknown or missing.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        toml::from_str(text).context("host_tests/validation.toml")
    }
}

/// A chapter of the page.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chapter {
    /// Heading.
    pub title: String,
    /// Paragraph below it.
    pub text: String,
    /// Keys that all runs have, unless they say otherwise.
    #[serde(default)]
    pub common: toml::Table,
    /// Cases to solve.
    pub run: Vec<toml::Table>,
    /// Pictures of them.
    #[serde(default)]
    pub picture: Vec<Picture>,
    /// Claims about them.
    pub claim: Vec<Claim>,
}

/// Cases of one bearing or of one table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Name, which claims and legends use.
    pub name: String,
    /// Bearing by its name in the catalogue, or a design file.
    #[serde(default)]
    pub bearing: String,
    /// Table of cases, or a formula that makes them, in the place of a bearing.
    pub table: Option<Table>,
    /// Part of column names to leave out.
    pub level: Option<String>,
    /// Attitude rule of the balls.
    #[serde(default)]
    pub attitude: Attitude,
    /// Program that solves.
    #[serde(default)]
    pub by: Program,
    /// `Fx, Fy, Fz, My, Mz`, N and N m.
    #[serde(default)]
    pub load: [f64; 5],
    /// Directions of the rows of a set, `+` or `-`.
    pub facings: Option<String>,
    /// Whether each ball makes a case.
    #[serde(default)]
    pub each_ball: bool,
    /// Values of columns, all combinations of which are solved.
    #[serde(default)]
    pub values: BTreeMap<String, Values>,
}

/// Cases that are no sweep of one bearing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Table {
    /// Pairs of GMN's.
    GmnS60,
    /// Pairs of NTN's.
    Ntn,
    /// Complete elliptic integrals, to 30 digits.
    EllipticIntegrals,
    /// Contacts, to 30 digits.
    HertzContacts,
    /// Contacts that are nearly round, and the closed form of spheres.
    Spheres,
    /// Fits of Brewe and Hamrock to contacts.
    Fits,
}

/// A program that solves a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Program {
    /// The solver, in double precision.
    #[default]
    Solver,
    /// The solver for balls at rest, in closed form.
    SolverAtRest,
    /// The reference build with the contact constants of Brewe and Hamrock.
    FittedContacts,
    /// The reference build with the gyroscopic moment reversed.
    WrongSign,
    /// The reference build without the friction moment on the ring.
    NoFrictionMoment,
}

/// Values of a column.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub enum Values {
    /// One.
    One(f64),
    /// Some.
    List(Vec<f64>),
    /// From one to another.
    Steps {
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// Number of steps.
        steps: u32,
        /// Each value is the one before times a factor.
        #[serde(default)]
        logarithmic: bool,
    },
}

impl Values {
    /// The values.
    pub fn list(&self) -> Vec<f64> {
        match self {
            Self::One(value) => vec![*value],
            Self::List(values) => values.clone(),
            &Self::Steps {
                from,
                to,
                steps,
                logarithmic,
            } => (0..=steps)
                .map(|i| f64::from(i) / f64::from(steps))
                .map(|part| match logarithmic {
                    true => from * (to / from).powf(part),
                    false => from + (to - from) * part,
                })
                .collect(),
        }
    }
}

/// A claim and what decides about it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Whose claim it is.
    pub by: String,
    /// A whole sentence.
    pub claim: String,
    /// The truth, if the claim holds in part.
    pub in_part: Option<String>,
    /// Values and their bounds.
    pub measure: Vec<Measure>,
}

/// A picture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Name of its file, without the ending.
    pub file: String,
    /// Title in the picture.
    pub title: String,
    /// Text below it.
    pub caption: String,
    /// Number of panels side by side.
    pub columns: usize,
    /// Column to the right.
    pub x: String,
    /// Unit of that column.
    pub x_unit: String,
    /// Label of that axis.
    pub x_label: String,
    /// The x axis is logarithmic.
    #[serde(default)]
    pub logarithmic: bool,
    /// The panels.
    pub panel: Vec<Panel>,
}

/// A panel of a picture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// Label of the upward axis.
    pub y_label: String,
    /// Curves.
    pub curve: Vec<Measure>,
}

/// Values along runs, with a bound in a claim, as curves in a picture.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Its name on the page.
    #[serde(default)]
    pub name: String,
    /// Columns.
    pub of: OneOrMore,
    /// Columns to subtract.
    #[serde(default)]
    pub less: OneOrMore,
    /// Columns to divide by.
    #[serde(default)]
    pub over: OneOrMore,
    /// Columns from which the relative difference is taken.
    #[serde(default)]
    pub off: OneOrMore,
    /// Runs; none are all.
    #[serde(default)]
    pub run: OneOrMore,
    /// Cases among them.
    #[serde(default)]
    pub at: BTreeMap<String, Place>,
    /// Runs of the columns to compare with; none are the runs above.
    #[serde(default)]
    pub against: OneOrMore,
    /// Cases among them, if they are others.
    pub against_at: Option<BTreeMap<String, Place>>,
    /// Numbers that the values make.
    #[serde(default)]
    pub take: Take,
    /// Numbers that these make from run to run.
    #[serde(default)]
    pub then: Take,
    /// Unit of the page.
    #[serde(default)]
    pub unit: String,
    /// Published values.
    #[serde(default)]
    pub published: OneOrMore<f64>,
    /// Largest difference from them.
    pub within: Option<f64>,
    /// Largest difference from them, %.
    pub within_percent: Option<f64>,
    /// All numbers are larger.
    pub above: Option<f64>,
    /// All numbers are smaller.
    pub below: Option<f64>,
    /// All numbers are at most this in size: rounding, and not printed.
    pub rounding: Option<f64>,
    /// Style of a curve.
    #[serde(default)]
    pub style: String,
}

/// A place along a column: a value, or a range that includes its ends.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum Place {
    /// The case next to this value.
    Value(f64),
    /// Cases between two values.
    Range([f64; 2]),
}

/// Numbers that values make.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Take {
    /// Each value.
    #[default]
    All,
    /// The least.
    Least,
    /// The largest.
    Largest,
    /// Each value less the one before.
    Step,
    /// Each value over the next.
    Ratio,
    /// The last value over the least, less 1.
    Rise,
    /// How many they are.
    Count,
    /// Cosine part of the first harmonic along the azimuth.
    Cosine,
    /// Sine part.
    Sine,
    /// Both together.
    Amplitude,
    /// Cosine part over sine part.
    #[serde(rename = "cosine over sine")]
    CosineOverSine,
    /// Sine part over cosine part.
    #[serde(rename = "sine over cosine")]
    SineOverCosine,
    /// Largest distance from the first harmonic, over its amplitude.
    Overtones,
    /// The median of all.
    Median,
    /// 10 % of all are smaller.
    #[serde(rename = "10 %")]
    Tenth,
    /// 90 % of all are smaller.
    #[serde(rename = "90 %")]
    NineTenths,
    /// The median of all sizes.
    #[serde(rename = "median size")]
    MedianSize,
    /// 90 % of all sizes are smaller.
    #[serde(rename = "90 % of sizes")]
    NineTenthsOfSizes,
    /// The largest size.
    #[serde(rename = "largest size")]
    LargestSize,
}

/// One value, or a list.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub enum OneOrMore<T = String> {
    /// One.
    One(T),
    /// A list.
    More(Vec<T>),
}

impl<T> Default for OneOrMore<T> {
    fn default() -> Self {
        Self::More(Vec::new())
    }
}

impl<T> std::ops::Deref for OneOrMore<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::More(more) => more,
        }
    }
}
