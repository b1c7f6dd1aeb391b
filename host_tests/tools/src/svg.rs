//! A picture as SVG text, drawn in fractions of a pixel.

use host_tests::validation::figure::{Colour, INK};
use std::fmt::Write;

/// A picture brings its own light background, so that it reads the same on a light and on a dark page.
pub const BACKGROUND: Colour = Colour(0xF7, 0xF8, 0xFA);
/// Lines at the ticks.
pub const GRID: Colour = Colour(0xD5, 0xDA, 0xE1);

/// Where a text stands, seen from its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// To the right of it.
    Right,
    /// Around it.
    Centre,
    /// To the left of it.
    Left,
}

/// A picture that is being drawn.
#[derive(Debug)]
pub struct Picture {
    text: String,
}

fn hex(Colour(red, green, blue): Colour) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

impl Picture {
    /// An empty one, of this width and height.
    pub fn new(width: f64, height: f64) -> Self {
        let text = format!(
            "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             xmlns=\"http://www.w3.org/2000/svg\" font-family=\"sans-serif\" stroke-linejoin=\"round\" \
             stroke-linecap=\"round\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            hex(BACKGROUND)
        );
        Self { text }
    }

    /// The picture as it is written to a file.
    pub fn finish(self) -> String {
        self.text + "</svg>\n"
    }

    fn points(points: &[(f64, f64)]) -> String {
        let mut text = String::with_capacity(14 * points.len());
        for (x, y) in points {
            // A string takes everything.
            let _ = write!(text, "{x:.1},{y:.1} ");
        }
        text.truncate(text.trim_end().len());
        text
    }

    /// A line; with dashes of this length, if that is not 0.
    pub fn line(&mut self, points: &[(f64, f64)], colour: Colour, width: f64, dash: f64) {
        let dash = if dash > 0.0 {
            format!(" stroke-dasharray=\"{dash} {dash}\"")
        } else {
            String::new()
        };
        self.text.push_str(&format!(
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{dash} points=\"{}\"/>\n",
            hex(colour),
            Self::points(points)
        ));
    }

    /// A filled area.
    pub fn area(&mut self, points: &[(f64, f64)], colour: Colour, opacity: f64) {
        self.text.push_str(&format!(
            "<polygon fill=\"{}\" fill-opacity=\"{opacity}\" points=\"{}\"/>\n",
            hex(colour),
            Self::points(points)
        ));
    }

    /// A disc.
    pub fn disc(&mut self, (x, y): (f64, f64), radius: f64, colour: Colour, opacity: f64) {
        self.text.push_str(&format!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius}\" fill=\"{}\" fill-opacity=\"{opacity}\"/>\n",
            hex(colour)
        ));
    }

    /// A circle's outline.
    pub fn circle(&mut self, (x, y): (f64, f64), radius: f64, colour: Colour, width: f64) {
        self.text.push_str(&format!(
            "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{radius:.2}\" fill=\"none\" stroke=\"{}\" \
             stroke-width=\"{width}\"/>\n",
            hex(colour)
        ));
    }

    /// A text, half its height above and half below the point.
    pub fn text(&mut self, (x, y): (f64, f64), side: Side, size: f64, text: &str) {
        self.styled((x, y), side, size, INK, "", text);
    }

    /// A text in bold letters of a colour.
    pub fn bold(&mut self, at: (f64, f64), side: Side, size: f64, colour: Colour, text: &str) {
        self.styled(at, side, size, colour, " font-weight=\"bold\"", text);
    }

    /// A text that is read from below to above.
    pub fn upright(&mut self, (x, y): (f64, f64), size: f64, text: &str) {
        let turn = format!(" transform=\"rotate(-90 {x:.2} {y:.2})\"");
        self.styled((x, y), Side::Centre, size, INK, &turn, text);
    }

    fn styled(
        &mut self,
        (x, y): (f64, f64),
        side: Side,
        size: f64,
        colour: Colour,
        style: &str,
        text: &str,
    ) {
        let anchor = match side {
            Side::Right => "start",
            Side::Centre => "middle",
            Side::Left => "end",
        };
        let mut escaped = String::with_capacity(text.len());
        for c in text.chars() {
            match c {
                '&' => escaped.push_str("&amp;"),
                '<' => escaped.push_str("&lt;"),
                '>' => escaped.push_str("&gt;"),
                c if c.is_control() => escaped.push('\u{fffd}'),
                c => escaped.push(c),
            }
        }
        self.text.push_str(&format!(
            "<text x=\"{x:.2}\" y=\"{y:.2}\" dy=\"0.35em\" text-anchor=\"{anchor}\" font-size=\"{size}\" \
             fill=\"{}\"{style}>{escaped}</text>\n",
            hex(colour)
        ));
    }
}
