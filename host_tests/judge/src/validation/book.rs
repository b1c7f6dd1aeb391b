//! `host_tests/judge/validation.toml` as types; the head of that file explains each key.

#![expect(missing_docs, reason = "the head of that file explains each key")]

use anyhow::Context;
use serde::Deserialize;
use solvers::dispatch::Attitude;
use std::collections::BTreeMap;

/// The file of claims.
pub const TEXT: &str = include_str!("../../validation.toml");

/// The whole file.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Book {
    pub opening: String,
    pub chapter: Vec<Chapter>,
}

impl Book {
    /// Reads the text of the file.
    ///
    /// # Errors
    ///
    /// A key that is unknown or missing.
    pub fn parse(text: &str) -> anyhow::Result<Self> {
        toml::from_str(text).context("host_tests/judge/validation.toml")
    }
}

/// A chapter of the page.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chapter {
    pub title: String,
    pub text: String,
    #[serde(default)]
    pub common: toml::Table,
    pub run: Vec<toml::Table>,
    #[serde(default)]
    pub picture: Vec<Picture>,
    pub claim: Vec<Claim>,
}

/// Cases of one bearing or of one table.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Run {
    pub name: String,
    #[serde(default)]
    pub bearing: String,
    pub table: Option<Table>,
    pub level: Option<String>,
    #[serde(default)]
    pub attitude: Attitude,
    #[serde(default)]
    pub by: Program,
    #[serde(default)]
    pub load: [f64; 5],
    pub facings: Option<String>,
    #[serde(default)]
    pub positions_mm: Vec<f64>,
    #[serde(default)]
    pub each_ball: bool,
    #[serde(default)]
    pub values: BTreeMap<String, Values>,
}

/// Cases that are no sweep of one bearing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Table {
    GmnS60,
    Ntn,
    EllipticIntegrals,
    HertzContacts,
    Spheres,
    Fits,
    SpindleCad,
    Fag,
    Snfa,
    Nsk,
}

/// A program that solves a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Program {
    #[default]
    Solver,
    SolverAtRest,
    FittedContacts,
    WrongSign,
    NoFrictionMoment,
}

/// Values of a column.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub enum Values {
    Given(OneOrMore<f64>),
    Steps {
        from: f64,
        to: f64,
        steps: u32,
        #[serde(default)]
        logarithmic: bool,
    },
}

impl Values {
    pub fn list(&self) -> Vec<f64> {
        match self {
            Self::Given(values) => values.to_vec(),
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
    pub by: String,
    pub claim: String,
    pub in_part: Option<String>,
    pub measure: Vec<Measure>,
}

/// A picture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    pub file: String,
    pub title: String,
    pub caption: String,
    pub columns: usize,
    pub x: String,
    pub x_unit: String,
    pub x_label: String,
    #[serde(default)]
    pub logarithmic: bool,
    pub panel: Vec<Panel>,
}

/// A panel of a picture.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    pub title: String,
    pub y_label: String,
    pub curve: Vec<Measure>,
}

/// Values along runs, with a bound in a claim, as curves in a picture.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Measure {
    pub name: String,
    pub of: OneOrMore,
    pub less: OneOrMore,
    pub over: OneOrMore,
    pub off: OneOrMore,
    pub run: OneOrMore,
    pub at: BTreeMap<String, Place>,
    pub against: OneOrMore,
    pub against_at: Option<BTreeMap<String, Place>>,
    pub take: String,
    pub then: String,
    pub unit: String,
    pub published: OneOrMore<f64>,
    pub within: Option<f64>,
    pub within_percent: Option<f64>,
    pub above: Option<f64>,
    pub below: Option<f64>,
    pub rounding: Option<f64>,
    pub style: String,
}

/// A place along a column: a value, or a range that includes its ends.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum Place {
    Value(f64),
    Range([f64; 2]),
}

/// One value, or a list.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub enum OneOrMore<T = String> {
    One(T),
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
