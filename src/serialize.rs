//! Results as `serde` data: arrays of any length, of which `serde` derives nothing, and numbers that are not finite.

use core::fmt::{self, Display};
use core::marker::PhantomData;
use core::str::FromStr;
use serde::de::value::{F64Deserializer, I64Deserializer, U64Deserializer};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A number to be written. Writing and reading have traits of their own: a user's generic `derive` asks for one of them alone.
pub trait Written: Copy + Display + Into<f64> + Serialize {}
impl<T: Copy + Display + Into<f64> + Serialize> Written for T {}

/// A number to be read.
pub trait Read<'de>: FromStr + Deserialize<'de> {}
impl<'de, T: FromStr + Deserialize<'de>> Read<'de> for T {}

/// A number that may be infinite, or none at all. A format that people read has it as `inf`, `-inf` or `NaN`: JSON has no such
/// numbers, and would write `null`.
pub mod number {
    use super::*;

    pub fn serialize<S: Serializer, T: Written>(x: &T, serializer: S) -> Result<S::Ok, S::Error> {
        let is_finite = f64::is_finite((*x).into());
        if is_finite || !serializer.is_human_readable() {
            return x.serialize(serializer);
        }
        serializer.collect_str(x)
    }

    pub fn deserialize<'de, D: Deserializer<'de>, T: Read<'de>>(
        deserializer: D,
    ) -> Result<T, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(Number(PhantomData))
        } else {
            T::deserialize(deserializer)
        }
    }

    struct Number<T>(PhantomData<T>);

    impl<'de, T: Read<'de>> Visitor<'de> for Number<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a number, `inf`, `-inf` or `NaN`")
        }

        fn visit_f64<E: Error>(self, x: f64) -> Result<T, E> {
            T::deserialize(F64Deserializer::new(x))
        }

        fn visit_i64<E: Error>(self, x: i64) -> Result<T, E> {
            T::deserialize(I64Deserializer::new(x))
        }

        fn visit_u64<E: Error>(self, x: u64) -> Result<T, E> {
            T::deserialize(U64Deserializer::new(x))
        }

        fn visit_str<E: Error>(self, x: &str) -> Result<T, E> {
            x.parse()
                .map_err(|_| E::invalid_value(serde::de::Unexpected::Str(x), &self))
        }
    }
}

/// A sequence of an array's elements, one at least.
pub mod array {
    use super::*;

    pub fn serialize<S: Serializer, T: Serialize, const N: usize>(
        array: &[T; N],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(array)
    }

    pub fn deserialize<'de, D: Deserializer<'de>, T: Copy + Deserialize<'de>, const N: usize>(
        deserializer: D,
    ) -> Result<[T; N], D::Error> {
        deserializer.deserialize_seq(Elements(PhantomData))
    }

    struct Elements<T, const N: usize>(PhantomData<T>);

    impl<'de, T: Copy + Deserialize<'de>, const N: usize> Visitor<'de> for Elements<T, N> {
        type Value = [T; N];

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "{N} elements")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<[T; N], A::Error> {
            if let Some(given) = elements.size_hint().filter(|given| *given != N) {
                return Err(A::Error::invalid_length(given, &self));
            }
            let Some(first) = elements.next_element()? else {
                return Err(A::Error::invalid_length(0, &self));
            };
            let mut array = [first; N];
            for (i, place) in array.iter_mut().enumerate().skip(1) {
                let next = elements.next_element()?;
                *place = next.ok_or_else(|| A::Error::invalid_length(i, &self))?;
            }
            Ok(array)
        }
    }
}

/// A sequence of a matrix's rows.
pub mod rows {
    use super::*;

    #[derive(Clone, Copy, Serialize, Deserialize)]
    #[serde(
        transparent,
        bound(serialize = "T: Serialize", deserialize = "T: Copy + Deserialize<'de>")
    )]
    struct Row<T, const C: usize>(#[serde(with = "array")] [T; C]);

    pub fn serialize<S: Serializer, T: Copy + Serialize, const R: usize, const C: usize>(
        rows: &[[T; C]; R],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(rows.map(Row))
    }

    pub fn deserialize<'de, D, T, const R: usize, const C: usize>(
        deserializer: D,
    ) -> Result<[[T; C]; R], D::Error>
    where
        D: Deserializer<'de>,
        T: Copy + Deserialize<'de>,
    {
        array::deserialize(deserializer).map(|rows: [Row<T, C>; R]| rows.map(|row| row.0))
    }
}
