//! Results as `serde` data, where a derived form is none: long arrays, and margins, which are kept as the balls' pass needs them.

use crate::real::Real;
use crate::results::margins::{Limit, LimitSet, Margin, Margins};
use serde::{Serialize, Serializer};

/// A sequence of the array's elements: arrays of any length are none of `serde`'s own.
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

/// Limits that are passed, worst contacts in the order of [`Limit::ALL`], and the number of unloaded balls.
impl<T: Real + Serialize> Serialize for Margins<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        #[serde(rename = "Margins")]
        struct Shown<T> {
            passed: LimitSet,
            worst: [Option<Margin<T>>; Limit::ALL.len()],
            unloaded: u16,
        }
        let shown = Shown {
            passed: self.passed(),
            worst: Limit::ALL.map(|limit| self.get(limit)),
            unloaded: self.unloaded,
        };
        shown.serialize(serializer)
    }
}
