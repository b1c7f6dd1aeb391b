//! Faults of recordings.

use crate::quantities::OWN;
use std::fmt;
use std::io;
use std::path::Path;

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
    /// The operating system refused to open or to read the file.
    Unreadable {
        /// Name of the file.
        file: String,
        /// Its reason.
        source: io::Error,
    },
    /// The file is no recording of loads: the place, why not, and the remedy.
    Malformed(String),
    /// The file is not in the project's own columns, or not in those of its description: it needs one.
    Foreign {
        /// Name of the file.
        file: String,
        /// The difference.
        why: String,
    },
    /// One row is at fault; the rows after it can be read.
    Row(Box<BadRow>),
}

impl fmt::Display for LoadsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { file, source } => write!(f, "{file}: cannot be read: {source}"),
            Self::Malformed(fault) => f.write_str(fault),
            Self::Foreign { file, why } => {
                let (from, to) = match file.as_str() {
                    STDIN => ("-".to_owned(), "recording.toml".to_owned()),
                    file => {
                        let quoted = |name: &str| {
                            let is_plain = |c: char| c.is_alphanumeric() || "_-./".contains(c);
                            match name.chars().all(is_plain) {
                                true => name.to_owned(),
                                false => format!("'{}'", name.replace('\'', "'\\''")),
                            }
                        };
                        let name = Path::new(Path::new(file).file_name().unwrap_or_default());
                        // Not a file that is there, such as the spindle's.
                        let mut described = name.with_extension("toml");
                        if described.exists() {
                            described = name.with_extension("import.toml");
                        }
                        (quoted(file), quoted(&described.display().to_string()))
                    }
                };
                write!(
                    f,
                    "{file}: {why}. Describe it, look at the description, and solve by it:\n  \
                     cargo replay --propose {from} > {to}\n  \
                     cargo replay SPINDLE.toml {from} --import {to}"
                )
            }
            Self::Row(row) => f.write_str(&row.fault),
        }
    }
}

impl std::error::Error for LoadsError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable { source, .. } => Some(source),
            _ => None,
        }
    }
}
