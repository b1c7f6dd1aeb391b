//! Results as `serde` data: arrays of any length, of which `serde` derives nothing, and margins by the names of limits.

use crate::real::Real;
use crate::results::margins::{Limit, LimitSet, Margins};
use serde::ser::{SerializeMap, SerializeSeq, SerializeStruct};
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
        let mut names = serializer.serialize_seq(Some(self.iter().count()))?;
        for limit in self.iter() {
            names.serialize_element(&limit)?;
        }
        names.end()
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
        let worst = || {
            Limit::ALL
                .into_iter()
                .filter_map(|limit| Some((limit, self.0.get(limit)?)))
        };
        // Formats without names need the number of entries first.
        let mut map = serializer.serialize_map(Some(worst().count()))?;
        for (limit, margin) in worst() {
            map.serialize_entry(&limit, &margin)?;
        }
        map.end()
    }
}
