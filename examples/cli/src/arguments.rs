//! Options whose values are chosen by name.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A value by its name: names, what is said of them, and values.
pub fn by_name<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = (&'static str, &'static str, T)>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<_> = all.into_iter().collect();
    let names = all.iter().map(|(name, help, _)| match *help {
        "" => PossibleValue::new(*name),
        help => PossibleValue::new(*name).help(help),
    });
    let parser = PossibleValuesParser::new(names.collect::<Vec<_>>());
    parser.try_map(move |given| {
        let found = all.iter().find(|one| one.0 == given);
        found.map(|one| one.2).ok_or("unknown")
    })
}
