//! A report of the firmware as text: its fields, whether two of them agree, and a row of the table.
//!
//! defmt prints a structure as Rust's `Debug` does, and a float in both with as many digits as tell
//! it from its neighbours. So the host's report, printed, must have the same fields with the same
//! values, and equal text means equal bits.

use std::fmt::Debug;

/// A structure with named fields, taken apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// Name of the structure.
    pub kind: String,
    fields: Vec<(String, String)>,
}

impl Report {
    /// Takes `Kind { name: value, ... }` apart; `None` if it is not of that form.
    pub fn parse(text: &str) -> Option<Self> {
        let (kind, rest) = text.split_once(" { ")?;
        let mut rest = rest.strip_suffix(" }")?;
        let mut fields = Vec::new();
        while !rest.is_empty() {
            let (field, next) = split_at_comma(rest);
            let (name, value) = field.split_once(": ")?;
            fields.push((name.to_owned(), value.to_owned()));
            rest = next;
        }
        Some(Self {
            kind: kind.to_owned(),
            fields,
        })
    }

    /// A report that this program has itself.
    pub fn of(value: &impl Debug) -> Option<Self> {
        Self::parse(&format!("{value:?}"))
    }

    /// Text of a field, empty if there is none of that name.
    pub fn get(&self, name: &str) -> &str {
        self.fields
            .iter()
            .find(|(n, _)| n == name)
            .map_or("", |(_, value)| value)
    }

    /// Where `self`, from the board, differs from `host`; `None` if nowhere.
    pub fn difference(&self, host: &Self) -> Option<String> {
        if self.kind != host.kind {
            return Some(format!(
                "the board has an {} ({}), the host an {} ({})",
                self.kind,
                self.get("status"),
                host.kind,
                host.get("status")
            ));
        }
        if self.fields.len() != host.fields.len() {
            return Some("the board's report has other fields than the host's".into());
        }
        self.fields
            .iter()
            .zip(&host.fields)
            .find(|((a, x), (b, y))| a != b || !same_value(x, y))
            .map(|((a, x), (b, y))| format!("the board has {a} = {x}, the host {b} = {y}"))
    }

    fn number(&self, name: &str) -> f64 {
        self.get(name).parse().unwrap_or(f64::NAN)
    }

    /// Names of the limits that were passed.
    pub fn limits(&self) -> impl Iterator<Item = &str> {
        self.get("limits")
            .split(['[', ']', ',', ' '])
            .filter(|name| !name.is_empty())
    }

    /// The report as a row under [`HEADER`].
    pub fn row(&self) -> String {
        let time = self.number("time_ms") * 1e-3;
        let speed = self.number("speed_rpm");
        let status = self.get("status");
        if self.kind != "Estimate" {
            return format!("{time:8.3} {speed:7.0}   {status}");
        }
        let k: Vec<f64> = self
            .get("stiffness")
            .trim_matches(['[', ']'])
            .split(", ")
            .map(|text| text.parse().unwrap_or(f64::NAN))
            .collect();
        let k = |i: usize| k.get(i).copied().unwrap_or(f64::NAN);
        let direction = |name: &str| {
            let index: Option<usize> = self.get(name).parse().ok();
            *index.and_then(|i| DIRECTIONS.get(i)).unwrap_or(&"?")
        };
        let pair = format!(
            "{},{}",
            direction("coupling_row"),
            direction("coupling_column")
        );
        let limits: String = self.limits().map(|name| format!(" {name}")).collect();
        format!(
            "{time:8.3} {speed:7.0} {:7.2} {:7.2} {:7.2} {:7.2} {:7.2} {:>10.3e} {pair:<6} {:7.2} {:9.2} {:>6} {status}{limits}",
            k(0) * 1e-6,
            k(1) * 1e-6,
            k(2) * 1e-6,
            k(3) * 1e-3,
            k(4) * 1e-3,
            self.number("coupling"),
            self.number("least_force"),
            self.number("largest_force"),
            self.get("sweeps"),
        )
    }
}

/// Names of the five freedoms, in the order of the stiffness matrix.
const DIRECTIONS: [&str; 5] = ["x", "y", "z", "ty", "tz"];

/// Heads of the columns of [`Report::row`], names over units.
pub const HEADER: &str = "    time   speed      Kx      Ky      Kz     Kty     Ktz   coupling of     Q least Q largest sweeps\n\
    \x20      s     rpm    N/um    N/um    N/um kNm/rad kNm/rad         SI              N         N        status, limits passed";

/// Splits at the first `, ` that is not within brackets.
fn split_at_comma(text: &str) -> (&str, &str) {
    let mut depth = 0;
    for (i, c) in text.char_indices() {
        match c {
            '{' | '[' | '(' => depth += 1,
            '}' | ']' | ')' => depth -= 1,
            ',' if depth == 0 => {
                return (&text[..i], text[i + 1..].trim_start());
            }
            _ => {}
        }
    }
    (text, "")
}

/// Whether two printed values are the same: word by word, floats by their bits, since the two
/// sides write the same float as `100000.0` or `1e5`.
fn same_value(a: &str, b: &str) -> bool {
    let words = |text: &str| -> Vec<String> {
        text.split([' ', ',', ':', '[', ']', '{', '}'])
            .filter(|word| !word.is_empty())
            .map(str::to_owned)
            .collect()
    };
    let (a, b) = (words(a), words(b));
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a == b || same_float(a, b))
}

fn same_float(a: &str, b: &str) -> bool {
    // A word of digits only is an integer, and must not be rounded.
    let float = |word: &str| -> Option<u32> {
        let integer = word.bytes().all(|b| b.is_ascii_digit());
        (!integer).then(|| word.parse().ok().map(f32::to_bits))?
    };
    matches!((float(a), float(b)), (Some(a), Some(b)) if a == b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "Estimate { sequence: 16777217, speed_rpm: 1e5, stiffness: [1.0, -0.0], \
                        status: NotFinite { quantity: Fx, value: NaN }, sweeps: 3 }";

    #[test]
    fn nested_fields_stay_whole() {
        let report = Report::parse(TEXT).unwrap();
        assert_eq!(report.kind, "Estimate");
        assert_eq!(report.get("stiffness"), "[1.0, -0.0]");
        assert_eq!(
            report.get("status"),
            "NotFinite { quantity: Fx, value: NaN }"
        );
        assert_eq!(report.get("sweeps"), "3");
    }

    #[test]
    fn limits_are_named_and_compared() {
        let text = "Estimate { limits: [Truncation, Friction], worst: Some(Exceedance { limit: \
                    Truncation, balls: 2, race: Inner, value: 0.5 }), sweeps: 3 }";
        let host = Report::parse(text).unwrap();
        assert!(host.limits().eq(["Truncation", "Friction"]));
        for (from, to) in [("[Truncation, ", "["), ("0.5", "0.50000006"), ("2", "3")] {
            let board = Report::parse(&text.replace(from, to)).unwrap();
            assert!(board.difference(&host).is_some(), "{from} and {to}");
        }
        assert_eq!(
            Report::parse("A { limits: [] }").unwrap().limits().count(),
            0
        );
    }

    #[test]
    fn one_bit_is_a_difference_and_another_spelling_is_none() {
        let host = Report::parse(TEXT).unwrap();
        let board = |from: &str, to: &str| Report::parse(&TEXT.replace(from, to)).unwrap();
        assert_eq!(board("1e5", "100000.0").difference(&host), None);
        for (from, to) in [
            ("1e5", "100000.01"),
            ("-0.0", "0.0"),
            ("16777217", "16777216"),
            ("sweeps", "passes"),
            ("Fx", "Fy"),
            ("NaN", "inf"),
            ("Estimate", "Refusal"),
        ] {
            assert!(
                board(from, to).difference(&host).is_some(),
                "{from} and {to}"
            );
        }
    }

    #[test]
    fn other_lines_are_no_reports() {
        for text in ["", "ready: core at 16 MHz", "A { b }", "A { b: 1"] {
            assert_eq!(Report::parse(text), None, "{text}");
        }
    }
}
