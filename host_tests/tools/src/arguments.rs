//! Options whose values are chosen by name.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use host_tests::campaign::families::Family;

/// A family of the campaign's cases.
pub fn family() -> impl TypedValueParser<Value = Family> {
    PossibleValuesParser::new(Family::ALL.map(Family::name)).try_map(|given| {
        let mut all = Family::ALL.into_iter();
        all.find(|family| family.name() == given).ok_or("unknown")
    })
}
