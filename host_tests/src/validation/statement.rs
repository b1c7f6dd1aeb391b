//! Statements of the page: what is said, what was measured, and what the measure must be.

use std::fmt;

/// What became of a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// It is so.
    Holds,
    /// Some of it is so; the remark says what.
    InPart,
    /// It is not so; the remark says what is.
    DoesNotHold,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Holds => "holds",
            Self::InPart => "holds in part",
            Self::DoesNotHold => "does not hold",
        })
    }
}

/// Where a number must lie for a statement to be as judged.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bounds {
    Above(f64),
    Below(f64),
    AtMost(f64),
    /// Strictly.
    Between(f64, f64),
    /// At most this in size; it is what rounding leaves, and its digits mean nothing.
    Rounding(f64),
    Count(usize),
}

/// A number that decides about a statement.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// What was measured, with its symbol.
    pub label: String,
    /// The number, in `unit`.
    pub value: f64,
    /// Its unit; empty for a ratio or a count.
    pub unit: &'static str,
    bounds: Bounds,
    digits: i32,
}

impl Measure {
    fn new(label: impl Into<String>, value: f64, unit: &'static str, bounds: Bounds) -> Self {
        Self {
            label: label.into(),
            value,
            unit,
            bounds,
            digits: 4,
        }
    }

    /// Must be larger than `bound`.
    pub fn above(label: impl Into<String>, value: f64, unit: &'static str, bound: f64) -> Self {
        Self::new(label, value, unit, Bounds::Above(bound))
    }

    /// Must be smaller than `bound`.
    pub fn below(label: impl Into<String>, value: f64, unit: &'static str, bound: f64) -> Self {
        Self::new(label, value, unit, Bounds::Below(bound))
    }

    /// Must be at most `bound`.
    pub fn at_most(label: impl Into<String>, value: f64, unit: &'static str, bound: f64) -> Self {
        Self::new(label, value, unit, Bounds::AtMost(bound))
    }

    /// Must be larger than `least` and smaller than `most`.
    pub fn within(
        label: impl Into<String>,
        value: f64,
        unit: &'static str,
        least: f64,
        most: f64,
    ) -> Self {
        Self::new(label, value, unit, Bounds::Between(least, most))
    }

    /// Vanishes but for rounding: its size must be at most `bound`, and only that is printed.
    pub fn rounding(label: impl Into<String>, value: f64, unit: &'static str, bound: f64) -> Self {
        Self::new(label, value, unit, Bounds::Rounding(bound))
    }

    /// Exactly this many.
    pub fn count(label: impl Into<String>, value: usize, wanted: usize) -> Self {
        Self::new(label, value as f64, "", Bounds::Count(wanted))
    }

    /// Printed with this many digits, for a number that has no more of any meaning.
    #[must_use]
    pub fn digits(self, digits: i32) -> Self {
        Self { digits, ..self }
    }

    /// The number is where it must be; what is not a number is nowhere.
    pub fn holds(&self) -> bool {
        let v = self.value;
        match self.bounds {
            Bounds::Above(bound) => v > bound,
            Bounds::Below(bound) => v < bound,
            Bounds::AtMost(bound) => v <= bound,
            Bounds::Between(least, most) => v > least && v < most,
            Bounds::Rounding(bound) => v.abs() <= bound,
            Bounds::Count(wanted) => v == wanted as f64,
        }
    }

    fn with_unit(&self, number: &str) -> String {
        match self.unit {
            "" => number.to_owned(),
            "\u{b0}" => format!("{number}\u{b0}"),
            unit => format!("{number}\u{a0}{unit}"),
        }
    }
}

impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let label = &self.label;
        if let Bounds::Rounding(bound) = self.bounds {
            return write!(f, "{label}: at most {}", self.with_unit(&shown(bound)));
        }
        let value = self.with_unit(&with_digits(self.value, self.digits));
        write!(f, "{label}: {value}")?;
        match self.bounds {
            Bounds::Above(bound) => write!(f, " (above {})", shown(bound)),
            Bounds::Below(bound) => write!(f, " (below {})", shown(bound)),
            Bounds::AtMost(bound) => write!(f, " (at most {})", shown(bound)),
            Bounds::Between(least, most) => write!(f, " ({} to {})", shown(least), shown(most)),
            Bounds::Count(wanted) => write!(f, " (exactly {wanted})"),
            Bounds::Rounding(_) => Ok(()),
        }
    }
}

/// A sentence about the bearing or the program, and what decides whether it is true.
#[derive(Debug, Clone, PartialEq)]
pub struct Statement {
    /// Whose claim it is, if it is not ours: the study's item.
    pub source: Option<&'static str>,
    /// What is claimed, a whole sentence.
    pub claim: String,
    /// What became of it.
    pub verdict: Verdict,
    /// What is true instead or besides, where the claim does not hold as it stands.
    pub remark: Option<String>,
    /// What was measured. The verdict is right if every measure is where it must be.
    pub measures: Vec<Measure>,
}

impl Statement {
    /// A statement of ours.
    pub fn ours(claim: impl Into<String>, measures: Vec<Measure>) -> Self {
        Self {
            source: None,
            claim: claim.into(),
            verdict: Verdict::Holds,
            remark: None,
            measures,
        }
    }

    /// A claim of somebody else's that holds.
    pub fn of(source: &'static str, claim: impl Into<String>, measures: Vec<Measure>) -> Self {
        Self {
            source: Some(source),
            ..Self::ours(claim, measures)
        }
    }

    /// The same with another verdict, and what is true instead.
    pub fn but(mut self, verdict: Verdict, remark: impl Into<String>) -> Self {
        self.verdict = verdict;
        self.remark = Some(remark.into());
        self
    }

    /// The verdict is right. A statement that nothing was measured for is not.
    pub fn holds(&self) -> bool {
        !self.measures.is_empty() && self.measures.iter().all(Measure::holds)
    }

    /// What is wrong with it, for a failing test.
    pub fn complaint(&self) -> Option<String> {
        (!self.holds()).then(|| {
            let wrong = self.measures.iter().filter(|m| !m.holds());
            let wrong: Vec<String> = wrong
                .map(|m| format!("{m}, but it is {:e}", m.value))
                .collect();
            format!(
                "\"{}\" ({}) is not so any more: {}",
                self.claim,
                self.verdict,
                wrong.join("; ")
            )
        })
    }
}

/// A number with four significant digits, as short as it gets: neither platform nor rounding shows.
pub fn shown(value: f64) -> String {
    with_digits(value, 4)
}

/// A number with `digits` significant digits, trailing zeros of a fraction left out.
pub fn with_digits(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".into()
        } else {
            value.to_string()
        };
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.*e}", (digits - 1).max(0) as usize);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", trimmed(mantissa));
    }
    let decimals = digits - 1 - size.log10().floor() as i32;
    trimmed(&format!("{value:.*}", decimals.max(0) as usize)).to_owned()
}

/// A whole number with a comma between the thousands.
pub fn thousands(value: f64) -> String {
    let digits = format!("{value:.0}");
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i) % 3 == 0 {
            text.push(',');
        }
        text.push(c);
    }
    text
}

fn trimmed(text: &str) -> &str {
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        text
    }
}
