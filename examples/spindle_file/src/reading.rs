//! Text of files in TOML: its keys, their places, and messages about them.

use serde::de::DeserializeOwned;
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A design file that cannot be read or understood, or whose bearing cannot be built.
#[derive(Debug)]
pub struct DesignFileError {
    /// Name of the file.
    pub file: String,
    /// Line and column at fault, from 1; `None` if the file could not be read at all.
    pub place: Option<Place>,
    /// The fault, and how to mend it.
    pub message: String,
}

/// A place in a text file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Place {
    /// The start of the file, where a key without a table is added.
    pub const TOP: Self = Self { line: 1, column: 1 };

    fn of(text: &str, byte: usize) -> Self {
        let before = String::from_utf8_lossy(&text.as_bytes()[..byte.min(text.len())]);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl fmt::Display for DesignFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        if let Some(Place { line, column }) = self.place {
            write!(f, "line {line}, column {column}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for DesignFileError {}

/// A key that may be absent, and where its value stands.
pub type Key<T> = Option<Spanned<T>>;

/// Positions on a shaft that files may say, mm: those of its sections.
pub(crate) const POSITIONS: RangeInclusive<f64> = -1e5..=1e5;

/// A number in six digits.
pub fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// The first number that is none, or is infinite: its key and where it stands.
fn not_finite<'k>(
    key: &'k str,
    value: &'k Spanned<DeValue<'_>>,
) -> Option<(&'k str, Range<usize>)> {
    match value.get_ref() {
        DeValue::Float(x) => {
            let is_finite = x.as_str().parse().is_ok_and(f64::is_finite);
            (!is_finite).then(|| (key, value.span()))
        }
        DeValue::Array(values) => values.iter().find_map(|value| not_finite(key, value)),
        DeValue::Table(keys) => keys
            .iter()
            .find_map(|(key, value)| not_finite(key.get_ref(), value)),
        _ => None,
    }
}

/// The key that an unknown one may be meant to be, of those that the message names.
fn meant(message: &str) -> String {
    let mut names = message.split('`').skip(1).step_by(2);
    let unknown = names
        .next()
        .filter(|_| message.starts_with("unknown field"));
    let alike = unknown.and_then(|unknown| {
        let alike = |name: &&str| alike(unknown, name);
        names.max_by_key(alike).filter(|name| alike(name) > 0)
    });
    match alike {
        Some("row") => "; did you mean [[row]]?".to_owned(),
        Some(alike) => format!("; did you mean `{alike}`?"),
        None => String::new(),
    }
}

/// The text being read, for messages.
#[derive(Clone, Copy)]
pub struct Reading<'t> {
    /// Name of the file.
    pub file: &'t str,
    /// Its content.
    pub text: &'t str,
}

impl<'t> Reading<'t> {
    /// The text as a table, whose numbers are finite.
    pub fn table(&self) -> Result<Spanned<DeTable<'t>>, DesignFileError> {
        let table = DeTable::parse(self.text).map_err(|error| self.refused(&error))?;
        match table
            .get_ref()
            .iter()
            .find_map(|(key, value)| not_finite(key.get_ref(), value))
        {
            Some((key, span)) => {
                let said = &self.text[span.clone()];
                let message =
                    format!("`{key}` is {said}, and no number; give one, or leave it out");
                Err(self.error(self.place(span), message))
            }
            None => Ok(table),
        }
    }

    /// A table as keys.
    pub fn keys<K: DeserializeOwned>(
        &self,
        table: Spanned<DeTable<'t>>,
    ) -> Result<K, DesignFileError> {
        let read = K::deserialize(toml::Deserializer::from(table));
        read.map_err(|error| self.refused(&error))
    }

    /// A refusal by the parser, with its place.
    pub(crate) fn refused(&self, error: &toml::de::Error) -> DesignFileError {
        let place = error.span().map_or(Place::TOP, |span| self.place(span));
        // A machinist knows no type `f64`.
        let message = error.message().replace("expected f64", "expected a number");
        self.refusal(place, message.trim_end())
    }

    /// A refusal, with the key that an unknown one may be meant to be.
    pub(crate) fn refusal(&self, place: Place, message: &str) -> DesignFileError {
        self.error(place, format!("{message}{}", meant(message)))
    }

    /// An error at a place.
    pub fn error(&self, place: Place, message: impl Into<String>) -> DesignFileError {
        DesignFileError {
            file: self.file.to_owned(),
            place: Some(place),
            message: message.into(),
        }
    }

    /// Where a part of the text begins.
    pub fn place(&self, span: Range<usize>) -> Place {
        Place::of(self.text, span.start)
    }

    /// A number within its range.
    pub fn within(
        &self,
        key: &str,
        said: &Spanned<f64>,
        range: RangeInclusive<f64>,
    ) -> Result<f64, DesignFileError> {
        let value = *said.get_ref();
        if range.contains(&value) {
            return Ok(value);
        }
        let [least, most] = [range.start(), range.end()].map(|bound| short(*bound));
        let message = format!("`{key}` is {value}, but must lie between {least} and {most}");
        Err(self.error(self.place(said.span()), message))
    }

    /// A number that the table at this place must have.
    pub fn needed(
        &self,
        (table, place): (&str, Place),
        key: &str,
        example: &str,
        value: Key<f64>,
    ) -> Result<f64, DesignFileError> {
        let message = format!("[{table}] lacks `{key}`; add a line such as `{key} = {example}`");
        let value = value.ok_or_else(|| self.error(place, message))?;
        Ok(value.into_inner())
    }

    /// A key that must be there is not: in the table at this place, or above all tables.
    pub fn missing(&self, table: Option<Place>, key: &str, example: &str) -> DesignFileError {
        let line = format!("{key} = {example}");
        self.lacks(table, &format!("the key `{key}`"), &line)
    }

    /// Something that must be said is not.
    pub fn lacks(&self, table: Option<Place>, what: &str, line: &str) -> DesignFileError {
        let at = if table.is_some() {
            "to this table"
        } else {
            "above the first [table]"
        };
        let message = format!("{what} is missing; add a line such as `{line}` {at}");
        self.error(table.unwrap_or(Place::TOP), message)
    }
}

// Division by a power of ten rounds once; its reciprocal would be rounded, too.
pub(crate) fn millimetres(x: f64) -> f64 {
    x / 1e3
}

pub(crate) fn micrometres(x: f64) -> f64 {
    x / 1e6
}

/// A file's name, as messages give it, and its text.
pub fn read_text(path: &Path) -> Result<(String, String), DesignFileError> {
    let file = path.display().to_string();
    match std::fs::read(path).map(String::from_utf8) {
        Ok(Ok(text)) => Ok((file, text)),
        Ok(Err(error)) => {
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            Err(DesignFileError {
                file,
                place: Some(Place::of(&text, error.utf8_error().valid_up_to())),
                message: "this is not UTF-8 text; save the file in that encoding".to_owned(),
            })
        }
        Err(error) => Err(DesignFileError {
            file,
            place: None,
            message: format!("cannot be read: {error}"),
        }),
    }
}

/// Pairs of characters that two names share.
pub(crate) fn alike(one: &str, other: &str) -> usize {
    let pairs = |name: &str| {
        name.as_bytes()
            .windows(2)
            .map(<[u8]>::to_vec)
            .collect::<Vec<_>>()
    };
    let others = pairs(other);
    pairs(one)
        .iter()
        .filter(|pair| others.contains(pair))
        .count()
}
