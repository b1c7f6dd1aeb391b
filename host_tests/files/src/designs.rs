//! Design files: a bearing as a TOML file, in the units of a data sheet.
//!
//! ```toml
//! name = "B7005C"
//! balls = 16
//! ball_diameter_mm = 6.35
//! pitch_diameter_mm = 36
//! inner_groove_factor = 0.515    # groove radius over ball diameter
//! outer_groove_factor = 0.525
//! contact_angle_deg = 15         # of the unloaded bearing; or diametral_clearance_um
//! dynamic_load_rating_n = 14000  # the maker's C; may be left out: ISO 281's formula, which is 5 % to 8 % high
//! inner_shoulder_deg = 48        # contact angle at the shoulder's edge; may be left out
//! outer_shoulder_deg = 47.5
//! first_ball_deg = 0             # may be left out
//!
//! [ring]                         # what is left out is bearing steel's
//! youngs_modulus_gpa = 206
//! poissons_ratio = 0.3
//!
//! [ball]
//! youngs_modulus_gpa = 310
//! poissons_ratio = 0.26
//! density_kg_m3 = 3200
//! ```

use crate::plan::BALL_COUNTS;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use spindle_bearing::{Design, DesignError, FreeContact, LifeRating, Quantity};
use std::fmt;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;

/// The folder of the design files that come with the project.
pub const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../bearings");

/// A bearing read from a design file.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignFile {
    /// Its name.
    pub name: String,
    /// Ball count `N`.
    pub balls: usize,
    /// The rest, SI units.
    pub design: Design,
    /// Basic dynamic load rating `C`, N, if the file has it.
    pub dynamic_load_rating: Option<f64>,
    file: String,
    places: Vec<(Quantity, Place)>,
}

/// A design file that cannot be read or understood, or whose bearing cannot be built.
#[derive(Debug)]
pub struct DesignFileError {
    /// Name of the file.
    pub file: String,
    /// Line and column at fault, from 1; `None` if the file could not be read at all.
    pub place: Option<Place>,
    /// The fault, and how to mend it.
    pub message: String,
}

/// A place in a text file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Place {
    /// The start of the file, where a key without a table is added.
    const TOP: Self = Self { line: 1, column: 1 };

    fn of(text: &str, byte: usize) -> Self {
        let before = String::from_utf8_lossy(&text.as_bytes()[..byte.min(text.len())]);
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Self {
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
        }
    }
}

impl fmt::Display for DesignFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file)?;
        if let Some(Place { line, column }) = self.place {
            write!(f, "line {line}, column {column}: ")?;
        }
        f.write_str(&self.message)
    }
}

impl std::error::Error for DesignFileError {}

/// A key that may be absent, and where its value stands.
pub(crate) type Key<T> = Option<Spanned<T>>;

/// The keys of a design.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Keys {
    name: Key<String>,
    balls: Key<f64>,
    ball_diameter_mm: Key<f64>,
    pitch_diameter_mm: Key<f64>,
    inner_groove_factor: Key<f64>,
    outer_groove_factor: Key<f64>,
    contact_angle_deg: Key<f64>,
    diametral_clearance_um: Key<f64>,
    inner_shoulder_deg: Key<f64>,
    outer_shoulder_deg: Key<f64>,
    first_ball_deg: Key<f64>,
    dynamic_load_rating_n: Key<f64>,
    #[serde(default)]
    ring: RingKeys,
    #[serde(default)]
    ball: BallKeys,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RingKeys {
    youngs_modulus_gpa: Key<f64>,
    poissons_ratio: Key<f64>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct BallKeys {
    youngs_modulus_gpa: Key<f64>,
    poissons_ratio: Key<f64>,
    density_kg_m3: Key<f64>,
}

/// A number of a design: its key, an example if it must be there, where it is read from and what it sets.
type Number = (
    Quantity,
    &'static str,
    &'static str,
    fn(&Keys) -> &Key<f64>,
    fn(&mut Design, f64),
);

/// The numbers of a design. The number of balls is no part of [`Design`].
#[rustfmt::skip]
const NUMBERS: [Number; 15] = [
    (Quantity::BallCount, "balls", "16", |k| &k.balls, |_, _| {}),
    (Quantity::BallDiameter, "ball_diameter_mm", "6.35", |k| &k.ball_diameter_mm, |d, x| d.ball_diameter = millimetres(x)),
    (Quantity::PitchDiameter, "pitch_diameter_mm", "36", |k| &k.pitch_diameter_mm, |d, x| d.pitch_diameter = millimetres(x)),
    (Quantity::InnerGrooveFactor, "inner_groove_factor", "0.515", |k| &k.inner_groove_factor, |d, x| d.inner_groove_factor = x),
    (Quantity::OuterGrooveFactor, "outer_groove_factor", "0.525", |k| &k.outer_groove_factor, |d, x| d.outer_groove_factor = x),
    (Quantity::ContactAngle, "contact_angle_deg", "", |k| &k.contact_angle_deg,
        |d, x| d.free_contact = FreeContact::Angle(x.to_radians())),
    (Quantity::DiametralClearance, "diametral_clearance_um", "", |k| &k.diametral_clearance_um,
        |d, x| d.free_contact = FreeContact::DiametralClearance(micrometres(x))),
    (Quantity::InnerShoulderAngle, "inner_shoulder_deg", "", |k| &k.inner_shoulder_deg,
        |d, x| d.inner_shoulder_angle = x.to_radians()),
    (Quantity::OuterShoulderAngle, "outer_shoulder_deg", "", |k| &k.outer_shoulder_deg,
        |d, x| d.outer_shoulder_angle = x.to_radians()),
    (Quantity::FirstBall, "first_ball_deg", "", |k| &k.first_ball_deg, |d, x| d.first_ball = x.to_radians()),
    (Quantity::RingYoungsModulus, "ring.youngs_modulus_gpa", "", |k| &k.ring.youngs_modulus_gpa,
        |d, x| d.ring.youngs_modulus = x * 1e9),
    (Quantity::RingPoissonsRatio, "ring.poissons_ratio", "", |k| &k.ring.poissons_ratio, |d, x| d.ring.poissons_ratio = x),
    (Quantity::BallYoungsModulus, "ball.youngs_modulus_gpa", "", |k| &k.ball.youngs_modulus_gpa,
        |d, x| d.ball.youngs_modulus = x * 1e9),
    (Quantity::BallPoissonsRatio, "ball.poissons_ratio", "", |k| &k.ball.poissons_ratio, |d, x| d.ball.poissons_ratio = x),
    (Quantity::BallDensity, "ball.density_kg_m3", "", |k| &k.ball.density_kg_m3, |d, x| d.ball.density = x),
];

/// The text being read, for messages.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'t> {
    pub file: &'t str,
    pub text: &'t str,
}

impl Reading<'_> {
    /// The text as keys.
    pub fn keys<K: DeserializeOwned>(&self) -> Result<K, DesignFileError> {
        toml::from_str(self.text).map_err(|error| {
            let place = error.span().map_or(Place::TOP, |span| self.place(span));
            // A machinist knows no type `f64`.
            let message = error.message().replace("expected f64", "expected a number");
            self.error(place, message.trim_end())
        })
    }

    pub fn error(&self, place: Place, message: impl Into<String>) -> DesignFileError {
        DesignFileError {
            file: self.file.to_owned(),
            place: Some(place),
            message: message.into(),
        }
    }

    pub fn place(&self, span: Range<usize>) -> Place {
        Place::of(self.text, span.start)
    }

    /// A key that must be there is not.
    pub fn missing(&self, key: &str, example: &str) -> DesignFileError {
        let add = "add a line such as";
        let message = format!(
            "the key `{key}` is missing; {add} `{key} = {example}` above the first [table]"
        );
        self.error(Place::TOP, message)
    }
}

// Division by a power of ten rounds once; its reciprocal would be rounded, too.
pub(crate) fn millimetres(x: f64) -> f64 {
    x / 1e3
}

pub(crate) fn micrometres(x: f64) -> f64 {
    x / 1e6
}

/// A file's name, as messages give it, and its text.
pub(crate) fn read_text(path: &Path) -> Result<(String, String), DesignFileError> {
    let file = path.display().to_string();
    match std::fs::read(path).map(String::from_utf8) {
        Ok(Ok(text)) => Ok((file, text)),
        Ok(Err(error)) => {
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            Err(DesignFileError {
                file,
                place: Some(Place::of(&text, error.utf8_error().valid_up_to())),
                message: "this is not UTF-8 text; save the file in that encoding".to_owned(),
            })
        }
        Err(error) => Err(DesignFileError {
            file,
            place: None,
            message: format!("cannot be read: {error}"),
        }),
    }
}

impl DesignFile {
    /// Reads a design file.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is not a design; the place in it where it goes wrong.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DesignFileError> {
        let (file, text) = read_text(path.as_ref())?;
        Self::parse(&file, &text)
    }

    /// Reads a design from the text of a file; messages call the file `file`.
    ///
    /// # Errors
    ///
    /// A text that is not a design; the place in it where it goes wrong.
    pub fn parse(file: &str, text: &str) -> Result<Self, DesignFileError> {
        let r = Reading { file, text };
        Self::of(r, r.keys()?)
    }

    /// The design of these keys.
    pub(crate) fn of(r: Reading<'_>, keys: Keys) -> Result<Self, DesignFileError> {
        let mut design = Design::angular_contact(0.0, 0.0, 0.0);
        let mut places = Vec::new();
        for (quantity, key, example, number, set) in NUMBERS {
            match number(&keys) {
                Some(number) => {
                    places.push((quantity, r.place(number.span())));
                    set(&mut design, *number.get_ref());
                }
                None if example.is_empty() => {}
                None => return Err(r.missing(key, example)),
            }
        }
        match (keys.contact_angle_deg, keys.diametral_clearance_um) {
            (Some(angle), Some(clearance)) => {
                let mut said = [angle, clearance].map(|number| r.place(number.span()));
                said.sort_by_key(|place| place.line);
                let message = format!(
                    "`contact_angle_deg` and `diametral_clearance_um` say the same thing, and \
                     line {} already says it; remove one of them",
                    said[0].line
                );
                return Err(r.error(said[1], message));
            }
            (None, None) => {
                let message = "the contact angle is missing; add a line such as `contact_angle_deg = 15` or \
                     `diametral_clearance_um = 10` above the first [table]";
                return Err(r.error(Place::TOP, message));
            }
            _ => {}
        }
        let name = keys.name.ok_or_else(|| r.missing("name", "\"B7005C\""))?;
        let wanted = keys.balls.map_or(0.0, Spanned::into_inner);
        let (least, most) = (BALL_COUNTS.start(), BALL_COUNTS.end());
        let Some(balls) = BALL_COUNTS.into_iter().find(|&n| n as f64 == wanted) else {
            let message =
                format!("`balls` is {wanted}, but must be a whole number from {least} to {most}");
            return Err(r.error(places[0].1, message));
        };
        let rating = keys.dynamic_load_rating_n;
        if let Some(rating) = &rating
            && !(1.0..=1e9).contains(rating.get_ref())
        {
            let message = "`dynamic_load_rating_n` must be 1 to 1e9 (N); or leave it out";
            return Err(r.error(r.place(rating.span()), message));
        }
        Ok(Self {
            name: name.into_inner(),
            balls,
            design,
            dynamic_load_rating: rating.map(Spanned::into_inner),
            file: r.file.to_owned(),
            places,
        })
    }

    /// Load ratings of its contacts: from the maker's `C` if it is known, else from the formula.
    pub fn rating(&self) -> LifeRating<f64> {
        let formula = || self.design.dynamic_load_rating(self.balls);
        let rating = self.dynamic_load_rating.unwrap_or_else(formula);
        LifeRating::<f64>::new(&self.design, self.balls, rating)
    }

    /// The message for a design that the solver refuses: the key and the place it came from.
    pub fn explain(&self, error: &DesignError) -> DesignFileError {
        let key = NUMBERS.iter().find(|number| number.0 == error.quantity);
        let key = key.map_or("", |(_, key, ..)| key);
        let source = self.places.iter().find(|(one, _)| *one == error.quantity);
        DesignFileError {
            file: self.file.clone(),
            place: source.map(|(_, place)| *place),
            message: match source {
                Some(_) => format!("`{key}`: in SI units, {error}"),
                None => error.to_string(),
            },
        }
    }
}
