//! Faults of recordings.

use crate::quantities::OWN;
use std::fmt;

/// Name of standard input in messages.
pub(crate) const STDIN: &str = "standard input";

/// A row that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRow {
    /// The place, why not, and the remedy.
    pub fault: String,
    /// Its readable numbers, in the order of [`OWN`]; none where the line has another number of fields.
    pub numbers: [Option<f64>; OWN.len()],
}

/// Error of a file of recorded loads.
#[derive(Debug)]
pub enum LoadsError {
    /// The file cannot be read, or is no recording of loads: the place, why not, and the remedy.
    Malformed(String),
    /// One row is at fault; the rows after it can be read.
    Row(Box<BadRow>),
}

impl fmt::Display for LoadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Malformed(fault) => f.write_str(fault),
            Self::Row(row) => f.write_str(&row.fault),
        }
    }
}

impl std::error::Error for LoadsError {}
