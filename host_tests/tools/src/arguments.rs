//! Options whose values are chosen by name, and the parsing of a command line.

use clap::Parser;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use host_tests::campaign::families::Family;
use host_tests::dispatch::{Attitude, Precision};
use std::ffi::OsString;
use std::io::Write;

/// A value by its name, with a line of help.
type Named<T> = (&'static str, &'static str, T);

fn one_of<T: Copy + Send + Sync + 'static>(
    all: impl IntoIterator<Item = Named<T>>,
) -> impl TypedValueParser<Value = T> {
    let all: Vec<Named<T>> = all.into_iter().collect();
    let names = all.iter().map(|(name, help, _)| {
        let name = PossibleValue::new(*name);
        if help.is_empty() {
            name
        } else {
            name.help(*help)
        }
    });
    PossibleValuesParser::new(names).try_map(move |given| {
        let found = all.iter().find(|(name, ..)| *name == given);
        found.map(|(.., value)| *value).ok_or("unknown")
    })
}

/// Arguments of a program, the first of which is its name; or its exit status, once it has said what is wrong with them, or
/// has given help.
///
/// # Errors
///
/// The exit status.
pub fn parsed<A: Parser>(
    args: impl IntoIterator<Item = OsString>,
    stdout: &mut dyn Write,
    stderr: &mut dyn Write,
) -> Result<A, u8> {
    A::try_parse_from(args).map_err(|message| {
        let text = message.render();
        // If the message cannot be written, nobody reads another one.
        let _ = if message.use_stderr() {
            write!(stderr, "{text}")
        } else {
            write!(stdout, "{text}")
        };
        u8::try_from(message.exit_code()).unwrap_or(2)
    })
}

/// The working precision.
pub fn precision() -> impl TypedValueParser<Value = Precision> {
    one_of([
        (
            "f32",
            "Single precision, as the firmware computes",
            Precision::F32,
        ),
        ("f64", "Double precision", Precision::F64),
    ])
}

/// The rule for the axis about which a ball turns.
pub fn attitude() -> impl TypedValueParser<Value = Attitude> {
    one_of([
        (
            "raceless",
            "Raceway-control-free: from d'Alembert's principle, no race presumed to be in control",
            Attitude::Raceless,
        ),
        (
            "outer",
            "Outer race control: no spin at the outer race",
            Attitude::Outer,
        ),
        (
            "inner",
            "Inner race control: no spin at the inner race; not for loads that lift balls off it",
            Attitude::Inner,
        ),
    ])
}

/// A family of the campaign's cases.
pub fn family() -> impl TypedValueParser<Value = Family> {
    one_of(Family::ALL.map(|family| (family.name(), "", family)))
}
