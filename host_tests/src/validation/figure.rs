//! Figures as data: panels of curves over a common legend. `host_tests/tools/src/figure.rs` draws them.
//!
//! Curves differ in dash and marker as well as in colour, and are told apart in black and white.

/// Red, green and blue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

/// Text, axes, and the curve that others are compared with.
pub const INK: Colour = Colour(0x25, 0x2B, 0x33);
// Told apart by people with any colour vision (Okabe and Ito).
/// Blue.
pub const BLUE: Colour = Colour(0x00, 0x72, 0xB2);
/// Vermilion.
pub const VERMILION: Colour = Colour(0xD5, 0x5E, 0x00);
/// Green.
pub const GREEN: Colour = Colour(0x00, 0x80, 0x60);
/// Purple.
pub const PURPLE: Colour = Colour(0x9B, 0x3F, 0x83);

/// How a line is broken up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dash {
    /// Not at all.
    Solid,
    /// Long dashes.
    Long,
    /// Short dashes.
    Short,
    /// Dots.
    Dots,
    /// No line: markers alone.
    None,
}

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// No points.
    None,
    /// A filled circle.
    Disc,
    /// A filled square.
    Square,
    /// A filled triangle.
    Triangle,
    /// A diagonal cross.
    Cross,
    /// A circle's outline.
    Ring,
}

/// The look of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pen(pub Colour, pub Dash, pub Marker);

/// A curve; in a polar panel its points are (azimuth in rad, value).
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its look.
    pub pen: Pen,
    /// The line.
    pub line: Vec<(f64, f64)>,
    /// Where its markers are.
    pub marks: Vec<(f64, f64)>,
}

impl Curve {
    /// A line through `points` with about `marks` markers on it, the first of them `first` in.
    pub fn through(pen: Pen, points: Vec<(f64, f64)>, first: usize, marks: usize) -> Self {
        let step = (points.len() / marks.max(1)).max(1);
        let marks = points
            .iter()
            .skip(first % step)
            .step_by(step)
            .copied()
            .collect();
        Self {
            pen,
            line: points,
            marks,
        }
    }
}

/// A straight axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// The range includes zero.
    pub zero: bool,
    /// Where its ticks are.
    pub ticks: Ticks,
}

/// Where an axis has its ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ticks {
    /// Some five of them.
    Some,
    /// This far apart.
    Every(f64),
    /// The axis holds decimal logarithms, and its numbers are those of which they are.
    Logarithmic,
}

impl Axis {
    /// As long as the curves need it.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            zero: false,
            ticks: Ticks::Some,
        }
    }

    /// With zero in its range.
    pub fn from_zero(label: impl Into<String>) -> Self {
        Self {
            zero: true,
            ..Self::new(label)
        }
    }

    /// With a tick every `step`.
    #[must_use]
    pub fn every(self, step: f64) -> Self {
        Self {
            ticks: Ticks::Every(step),
            ..self
        }
    }

    /// Of points that are given by their decimal logarithms.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self {
            ticks: Ticks::Logarithmic,
            ..Self::from_zero(label)
        }
    }
}

/// What the points of a panel mean.
#[derive(Debug, Clone, PartialEq)]
pub enum Plane {
    /// Two straight axes.
    Straight {
        /// To the right.
        x: Axis,
        /// Upwards.
        y: Axis,
    },
    /// Around the bearing, seen along the shaft: +y to the right, +z upwards, the value outwards.
    Around {
        /// Value in the centre.
        centre: f64,
        /// Value at the rim.
        rim: f64,
        /// From one ring to the next.
        step: f64,
    },
}

/// One panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Its title.
    pub title: String,
    /// Its axes.
    pub plane: Plane,
    /// Its curves.
    pub curves: Vec<Curve>,
    /// Points that are ringed.
    pub nodes: Vec<(f64, f64)>,
}

/// A figure.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: &'static str,
    /// Title in the figure.
    pub title: String,
    /// What the text under the figure says.
    pub caption: String,
    /// What the pens stand for.
    pub legend: Vec<(Pen, String)>,
    /// Number of panels side by side.
    pub columns: usize,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}
