//! Doubts: figures that are read as they stand, and seem to be meant otherwise, such as a preload in kN.
//!
//! Each is one line with its place, the key, its value, and the usual ones. `cargo replay` and the firmware's build print the
//! same lines.

use crate::plan::Row;
use crate::reading::{Place, Reading, short};
use spindle_bearing::Section;
use std::ops::RangeInclusive;

/// Doubts about a file, in its order of reading.
pub(crate) struct Doubts<'t> {
    r: Reading<'t>,
    told: Vec<String>,
}

impl<'t> Doubts<'t> {
    pub fn of(r: Reading<'t>) -> Self {
        let told = Vec::new();
        Self { r, told }
    }

    /// Adds a doubt about the figure at this place.
    pub fn tell(&mut self, place: Place, message: String) {
        self.told.push(self.r.error(place, message).to_string());
    }

    /// Doubts a number out of its usual range, with a question about it. A range above 0 is one of amounts.
    pub fn unusual(
        &mut self,
        place: Place,
        (key, value): (&str, f64),
        usual: RangeInclusive<f64>,
        question: &str,
    ) {
        let amount = if *usual.start() > 0.0 {
            value.abs()
        } else {
            value
        };
        if !usual.contains(&amount) {
            let [least, most] = [usual.start(), usual.end()].map(|bound| short(*bound));
            let message =
                format!("`{key}` is {value}, and usual are {least} to {most}: {question}");
            self.tell(place, message);
        }
    }

    /// The lines, those of other files first; of several alike, one.
    pub fn finish(self, before: impl IntoIterator<Item = String>) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for line in before.into_iter().chain(self.told) {
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }
}

/// Ends of a spindle's sections and rows, m.
#[derive(Clone)]
pub(crate) struct Extent {
    from: f64,
    to: f64,
    /// Largest pitch diameter, m.
    pitch: f64,
    /// It has sections: its ends are the shaft's.
    is_drawn: bool,
}

/// Length of a shaft without sections, at least: over the distance of its rows, and over the pitch diameter of a row alone. Rows do not
/// say how far the shaft stands out of them.
const OF_ROWS: f64 = 2.0;
const OF_PITCH: f64 = 5.0;

impl Extent {
    /// Of at least one row.
    pub fn of(rows: &[Row], sections: &[Section]) -> Self {
        let pitches = rows.iter().map(|row| row.design.pitch_diameter);
        let drawn = Self::drawn(sections, pitches.fold(0.0, f64::max));
        drawn.with(rows.iter().map(|row| row.position))
    }

    /// Of the sections alone, with bearings of this pitch diameter, m.
    pub fn drawn(sections: &[Section], pitch: f64) -> Self {
        let none = Self {
            from: f64::INFINITY,
            to: f64::NEG_INFINITY,
            pitch,
            is_drawn: !sections.is_empty(),
        };
        none.with(sections.iter().flat_map(|of| [of.from, of.to]))
    }

    /// With other points of the shaft.
    pub fn with(self, points: impl IntoIterator<Item = f64>) -> Self {
        points.into_iter().fold(self, |all, point| Self {
            from: all.from.min(point),
            to: all.to.max(point),
            ..all
        })
    }

    /// Whether it has sections.
    pub fn is_drawn(&self) -> bool {
        self.is_drawn
    }

    /// Distance of a position from it, m; 0 within.
    fn off(&self, position: f64) -> f64 {
        (self.from - position).max(position - self.to).max(0.0)
    }

    fn length(&self) -> f64 {
        let length = self.to - self.from;
        match self.is_drawn {
            true => length,
            false => (OF_ROWS * length).max(OF_PITCH * self.pitch),
        }
    }

    /// Whether a position is further off than the shaft is long. Tools stand out, but not so far.
    pub fn is_far(&self, position: f64) -> bool {
        self.off(position) > self.length()
    }

    /// Whether a position is beyond the shaft: by more than half a pitch diameter, since flanges and pulleys are seldom drawn.
    /// Where no section is, the shaft may be as long again as its rows are apart.
    pub fn is_beyond(&self, position: f64) -> bool {
        let undrawn = match self.is_drawn {
            true => 0.5 * self.pitch,
            false => self.pitch.max(self.to - self.from),
        };
        self.off(position) > undrawn
    }

    /// Where a position is, in words.
    pub fn words(&self, position: f64) -> String {
        let [off, from, to] = [self.off(position), self.from, self.to].map(|x| short(1e3 * x));
        let parts = if self.is_drawn {
            "sections and rows are"
        } else {
            "rows are"
        };
        format!("{off} mm off the spindle, whose {parts} from {from} to {to} mm")
    }

    /// How far off a load may be, in words.
    pub fn words_of_length(&self) -> String {
        let length = short(1e3 * self.length());
        match self.is_drawn {
            true => format!("{length} mm of it, the shaft's length"),
            false => format!("{length} mm of it: draw the shaft's `sections` if it is longer"),
        }
    }
}
