//! Results as `serde` data: arrays of any length, of which `serde` derives nothing, and margins by the names of limits.

use crate::real::Real;
use crate::results::margins::{Limit, LimitSet, Margins};
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

/// A sequence of the array's elements.
pub fn array<S: Serializer, T: Serialize, const N: usize>(
    array: &[T; N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(array)
}

/// A sequence of the matrix's rows.
pub fn rows<S: Serializer, T: Serialize, const R: usize, const C: usize>(
    rows: &[[T; C]; R],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(rows.iter().map(<[T; C]>::as_slice))
}

/// The names of its limits.
impl Serialize for LimitSet {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

/// The limits that are passed, and a map from limits to their worst contacts.
impl<T: Real + Serialize> Serialize for Margins<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut shown = serializer.serialize_struct("Margins", 3)?;
        shown.serialize_field("passed", &self.passed())?;
        shown.serialize_field("worst", &Worst(self))?;
        shown.serialize_field("unloaded", &self.unloaded)?;
        shown.end()
    }
}

struct Worst<'a, T>(&'a Margins<T>);

impl<T: Real + Serialize> Serialize for Worst<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let worst = Limit::ALL.into_iter();
        serializer.collect_map(worst.filter_map(|limit| Some((limit, self.0.get(limit)?))))
    }
}
