//! The validation book: what the solver reproduces, as a page with figures and tables.
//!
//! Every statement of the page is a [`Statement`]: a sentence, the numbers that
//! decide about it, and where they must lie. The page is printed from the same values that
//! `tests/all/validation.rs` asserts. Prose around them says how things were done and claims nothing.

pub mod around;
pub mod clearance;
pub mod figure;
pub mod gyroscope;
pub mod hertz;
pub mod load;
pub mod makers;
pub mod page;
pub mod rules;
pub mod scene;
pub mod scheme;
pub mod statement;
pub mod stiffness;
pub mod tangent;

pub use crate::progress::Progress;
use figure::Figure;
use scene::Solved;
use statement::{Measure, Statement};

/// The page, from the root of the project.
pub const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/validation.md");
/// The folder of its figures.
pub const FIGURES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/validation");
/// What makes both.
pub const COMMAND: &str = "cargo reports validation";

/// A part of a chapter.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph on how things were done.
    Text(String),
    /// A figure.
    Figure(Figure),
    /// A table.
    Table(Table),
    /// Statements.
    Statements(Vec<Statement>),
}

/// A table of the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What it shows.
    pub caption: String,
    /// Heads of its columns.
    pub head: Vec<String>,
    /// Its rows.
    pub rows: Vec<Vec<String>>,
}

/// A chapter of the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Chapter {
    /// Its heading.
    pub title: &'static str,
    /// What is in it.
    pub blocks: Vec<Block>,
}

impl Chapter {
    /// Its statements.
    pub fn statements(&self) -> impl Iterator<Item = &Statement> {
        self.blocks.iter().flat_map(|block| match block {
            Block::Statements(statements) => statements.as_slice(),
            _ => &[],
        })
    }

    /// Its figures.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Figure(figure) => Some(figure),
            _ => None,
        })
    }
}

/// Makes a chapter.
pub type Make = fn(&dyn Progress) -> anyhow::Result<Chapter>;

/// The chapters of the book.
pub const CHAPTERS: [Make; 10] = [
    around::chapter,
    stiffness::chapter,
    load::chapter,
    clearance::chapter,
    scheme::chapter,
    rules::chapter,
    gyroscope::chapter,
    tangent::chapter,
    hertz::chapter,
    makers::chapter,
];

/// Computes all of them.
///
/// # Errors
///
/// A point of the page that has no solution any more, or a file of values that cannot be read.
pub fn book(progress: &dyn Progress) -> anyhow::Result<Vec<Chapter>> {
    use rayon::prelude::*;
    CHAPTERS.par_iter().map(|make| make(progress)).collect()
}

/// The statement that every point of a chapter is what the reference build says.
fn judged<'a>(solved: impl IntoIterator<Item = &'a Solved>) -> Statement {
    let (mut points, mut worst) = (0, [0.0; 2]);
    for one in solved {
        points += 1;
        for (worst, share) in worst.iter_mut().zip(one.against_reference) {
            *worst = crate::compare::worse(*worst, share);
        }
    }
    let [double, single] = worst;
    Statement::ours(
        format!(
            "All {points} equilibria of this chapter are those of the reference build, in double and \
             in single precision, within the bounds of `host_tests/src/tolerances.rs`."
        ),
        vec![
            Measure::rounding("error over its bound, double precision", double, "", 1.0),
            Measure::rounding("error over its bound, single precision", single, "", 1.0),
        ],
    )
}
