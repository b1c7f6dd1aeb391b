//! Design files: a bearing as a TOML file, in the units of a data sheet.
//!
//! ```toml
//! name = "B7005C"
//! balls = 16
//! ball_diameter_mm = 6.35
//! pitch_diameter_mm = 36
//! inner_groove_factor = 0.515    # groove radius over ball diameter; or inner_groove_radius_mm
//! outer_groove_factor = 0.525
//! contact_angle_deg = 15         # of the unloaded bearing; or diametral_clearance_um
//! dynamic_load_rating_n = 14000  # the maker's C; may be left out: ISO 281's formula, which is 5 % to 8 % high
//! inner_shoulder_deg = 48        # contact angle at the shoulder's edge; may be left out
//! outer_shoulder_deg = 47.5
//! first_ball_deg = 0             # may be left out
//! bore_mm = 25                   # for the catalogue, and to see whether a shaft fits; may be left out
//! outside_mm = 47
//!
//! [ring]                         # what is left out is bearing steel's
//! youngs_modulus_gpa = 206
//! poissons_ratio = 0.3
//!
//! [ball]
//! youngs_modulus_gpa = 310
//! poissons_ratio = 0.26
//! density_kg_m3 = 3200
//!
//! [load]                         # where recorded loads act; may be left out: the bearing's centre
//! position_mm = -60
//!
//! [[constant_load]]              # besides recorded loads: belt, gear, weight
//! position_mm = 40
//! fy_n = -300                    # and fx_n, fz_n
//! ```

use crate::plan::{BALL_COUNTS, Part};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use spindle_bearing::{Design, DesignError, FreeContact, LifeRating, Quantity};
use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

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
    /// Bore and outside diameter, mm, as far as the file has them.
    pub size_mm: [Option<f64>; 2],
    /// Where loads act.
    pub loading: Loading,
    pub(crate) file: String,
    said: Vec<Said>,
}

/// A number of a design as the file says it.
#[derive(Debug, Clone, PartialEq)]
struct Said {
    quantity: Quantity,
    key: &'static str,
    value: f64,
    place: Place,
}

/// Where recorded loads act on the shaft, and constant forces besides.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Loading {
    /// Where recorded loads act, m.
    pub(crate) position: f64,
    /// Positions (m) and forces (N).
    pub(crate) constant: Vec<(f64, [f64; 3])>,
}

impl Loading {
    pub(crate) fn of(load: Option<LoadKeys>, constant: Vec<ConstantLoadKeys>) -> Self {
        let or = |key: Key<f64>| key.map_or(0.0, Spanned::into_inner);
        let constant = constant.into_iter().map(|keys| {
            let force = [keys.fx_n, keys.fy_n, keys.fz_n].map(or);
            (millimetres(*keys.position_mm.get_ref()), force)
        });
        Self {
            position: millimetres(load.map_or(0.0, |keys| *keys.position_mm.get_ref())),
            constant: constant.collect(),
        }
    }

    /// Looks at positions and forces one by one.
    pub(crate) fn check(
        r: Reading<'_>,
        load: Option<&LoadKeys>,
        constant: &[ConstantLoadKeys],
    ) -> Result<(), DesignFileError> {
        let positions = constant.iter().map(|keys| &keys.position_mm);
        for position in positions.chain(load.map(|load| &load.position_mm)) {
            r.within("position_mm", position, POSITIONS)?;
        }
        for keys in constant {
            for (key, force) in keys.forces() {
                r.within(key, force, -1e9..=1e9)?;
            }
        }
        Ok(())
    }

    /// All loads about `x = 0`, when `load` is recorded.
    pub fn about_origin(&self, load: [f64; 5]) -> [f64; 5] {
        let mut all = load;
        let mut lever = |position: f64, [fy, fz]: [f64; 2]| {
            if position != 0.0 {
                all[3] -= position * fz;
                all[4] += position * fy;
            }
        };
        lever(self.position, [load[1], load[2]]);
        for (position, [_, fy, fz]) in &self.constant {
            lever(*position, [*fy, *fz]);
        }
        for (_, force) in &self.constant {
            for (sum, force) in all.iter_mut().zip(force) {
                *sum += force;
            }
        }
        all
    }
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
    pub(crate) const TOP: Self = Self { line: 1, column: 1 };

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
    inner_groove_radius_mm: Key<f64>,
    outer_groove_radius_mm: Key<f64>,
    bore_mm: Key<f64>,
    outside_mm: Key<f64>,
    #[serde(default)]
    ring: RingKeys,
    #[serde(default)]
    ball: BallKeys,
    load: Option<LoadKeys>,
    #[serde(default)]
    constant_load: Vec<ConstantLoadKeys>,
    monitor: Key<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LoadKeys {
    pub position_mm: Spanned<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ConstantLoadKeys {
    position_mm: Spanned<f64>,
    fx_n: Key<f64>,
    fy_n: Key<f64>,
    fz_n: Key<f64>,
}

impl ConstantLoadKeys {
    /// Forces that are said.
    fn forces(&self) -> impl Iterator<Item = (&'static str, &Spanned<f64>)> {
        let forces = [
            ("fx_n", &self.fx_n),
            ("fy_n", &self.fy_n),
            ("fz_n", &self.fz_n),
        ];
        forces
            .into_iter()
            .filter_map(|(key, force)| Some((key, force.as_ref()?)))
    }

    /// Places of the position and of the forces of the load of this number.
    pub fn places(&self, r: Reading<'_>, load: usize) -> Vec<(Part, Place)> {
        let mut places = vec![(Part::LoadPosition(load), r.place(self.position_mm.span()))];
        for (axis, force) in [&self.fx_n, &self.fy_n, &self.fz_n].into_iter().enumerate() {
            let force = force.as_ref();
            places.extend(force.map(|force| (Part::LoadForce(load, axis), r.place(force.span()))));
        }
        places
    }
}

/// Positions on a shaft that files may say, mm: those of its sections.
pub(crate) const POSITIONS: RangeInclusive<f64> = -1e5..=1e5;

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
const NUMBERS: [Number; 17] = [
    (Quantity::BallCount, "balls", "16", |k| &k.balls, |_, _| {}),
    (Quantity::BallDiameter, "ball_diameter_mm", "6.35", |k| &k.ball_diameter_mm, |d, x| d.ball_diameter = millimetres(x)),
    (Quantity::PitchDiameter, "pitch_diameter_mm", "36", |k| &k.pitch_diameter_mm, |d, x| d.pitch_diameter = millimetres(x)),
    (Quantity::InnerGrooveFactor, "inner_groove_factor", "0.515", |k| &k.inner_groove_factor, |d, x| d.inner_groove_factor = x),
    (Quantity::OuterGrooveFactor, "outer_groove_factor", "0.525", |k| &k.outer_groove_factor, |d, x| d.outer_groove_factor = x),
    (Quantity::InnerGrooveFactor, "inner_groove_radius_mm", "", |k| &k.inner_groove_radius_mm,
        |d, x| d.inner_groove_factor = millimetres(x) / d.ball_diameter),
    (Quantity::OuterGrooveFactor, "outer_groove_radius_mm", "", |k| &k.outer_groove_radius_mm,
        |d, x| d.outer_groove_factor = millimetres(x) / d.ball_diameter),
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

/// Diameters of rings, mm, and densities of balls, kg/m^3: others are in another unit.
const SIZES: RangeInclusive<f64> = 0.1..=1e5;
const DENSITIES: RangeInclusive<f64> = 100.0..=1e5;

/// Keys that say the same thing.
const EITHER: [(&str, &str); 3] = [
    ("inner_groove_factor", "inner_groove_radius_mm"),
    ("outer_groove_factor", "outer_groove_radius_mm"),
    ("contact_angle_deg", "diametral_clearance_um"),
];

/// Whether there is a number of this key.
fn said_by(keys: &Keys, key: &str) -> bool {
    let number = NUMBERS.iter().find(|number| number.1 == key);
    number.is_some_and(|number| number.3(keys).is_some())
}

/// A number in six digits.
pub fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

/// The first number that is none, or is infinite: its key and where it stands.
fn not_finite<'k>(
    key: &'k str,
    value: &'k Spanned<DeValue<'_>>,
) -> Option<(&'k str, Range<usize>)> {
    match value.get_ref() {
        DeValue::Float(x) => {
            let is_finite = x.as_str().parse().is_ok_and(f64::is_finite);
            (!is_finite).then(|| (key, value.span()))
        }
        DeValue::Array(values) => values.iter().find_map(|value| not_finite(key, value)),
        DeValue::Table(keys) => keys
            .iter()
            .find_map(|(key, value)| not_finite(key.get_ref(), value)),
        _ => None,
    }
}

/// The text being read, for messages.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'t> {
    pub file: &'t str,
    pub text: &'t str,
}

impl Reading<'_> {
    /// The text as keys.
    pub fn keys<K: DeserializeOwned>(&self) -> Result<K, DesignFileError> {
        let refused = |error: toml::de::Error| {
            let place = error.span().map_or(Place::TOP, |span| self.place(span));
            // A machinist knows no type `f64`.
            let message = error.message().replace("expected f64", "expected a number");
            self.error(place, message.trim_end())
        };
        let table = DeTable::parse(self.text).map_err(refused)?;
        match table
            .get_ref()
            .iter()
            .find_map(|(key, value)| not_finite(key.get_ref(), value))
        {
            Some((key, span)) => {
                let said = &self.text[span.clone()];
                let message =
                    format!("`{key}` is {said}, and no number; give one, or leave it out");
                Err(self.error(self.place(span), message))
            }
            None => toml::from_str(self.text).map_err(refused),
        }
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

    /// A number within its range.
    pub fn within(
        &self,
        key: &str,
        said: &Spanned<f64>,
        range: RangeInclusive<f64>,
    ) -> Result<f64, DesignFileError> {
        let value = *said.get_ref();
        if range.contains(&value) {
            return Ok(value);
        }
        let [least, most] = [range.start(), range.end()].map(|bound| short(*bound));
        let message = format!("`{key}` is {value}, but must lie between {least} and {most}");
        Err(self.error(self.place(said.span()), message))
    }

    /// A number that a table must have.
    pub fn needed(
        &self,
        table: &str,
        key: &str,
        example: &str,
        value: Key<f64>,
    ) -> Result<f64, DesignFileError> {
        let message = format!("[{table}] lacks `{key}`; add a line such as `{key} = {example}`");
        let value = value.ok_or_else(|| self.error(Place::TOP, message))?;
        Ok(value.into_inner())
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
        let mut said: Vec<Said> = Vec::new();
        for (quantity, key, example, number, set) in NUMBERS {
            let Some(number) = number(&keys) else {
                let other = EITHER.iter().find(|(one, _)| *one == key);
                let is_said = other.is_some_and(|(_, other)| said_by(&keys, other));
                if !example.is_empty() && !is_said {
                    return Err(r.missing(key, example));
                }
                continue;
            };
            let (value, place) = (*number.get_ref(), r.place(number.span()));
            let pair = |one: &Said| {
                let is_pair = |(a, b): &(&str, &str)| (*a, *b) == (one.key, key);
                EITHER.iter().any(is_pair)
            };
            if let Some(other) = said.iter().find(|one| pair(one)) {
                let mut places = [place, other.place];
                places.sort_by_key(|place| place.line);
                let message = format!(
                    "`{}` and `{key}` say the same thing, and line {} already says it; remove one of them",
                    other.key, places[0].line
                );
                return Err(r.error(places[1], message));
            }
            said.push(Said {
                quantity,
                key,
                value,
                place,
            });
            set(&mut design, value);
        }
        if !said
            .iter()
            .any(|one| EITHER[2].0 == one.key || EITHER[2].1 == one.key)
        {
            let message = "the contact angle is missing; add a line such as `contact_angle_deg = 15` or \
                 `diametral_clearance_um = 10` above the first [table]";
            return Err(r.error(Place::TOP, message));
        }
        let name = keys.name.ok_or_else(|| r.missing("name", "\"B7005C\""))?;
        let wanted = keys.balls.map_or(0.0, Spanned::into_inner);
        let (least, most) = (BALL_COUNTS.start(), BALL_COUNTS.end());
        let Some(balls) = BALL_COUNTS.into_iter().find(|&n| n as f64 == wanted) else {
            let message =
                format!("`balls` is {wanted}, but must be a whole number from {least} to {most}");
            return Err(r.error(said[0].place, message));
        };
        for (key, said, range) in [
            (
                "dynamic_load_rating_n",
                &keys.dynamic_load_rating_n,
                1.0..=1e9,
            ),
            ("bore_mm", &keys.bore_mm, SIZES),
            ("outside_mm", &keys.outside_mm, SIZES),
            ("ball.density_kg_m3", &keys.ball.density_kg_m3, DENSITIES),
        ] {
            if let Some(said) = said {
                r.within(key, said, range)?;
            }
        }
        if let Some(monitor) = &keys.monitor {
            let message =
                "[monitor] is a spindle's: move it to a file with a [[row]] of this bearing";
            return Err(r.error(r.place(monitor.span()), message));
        }
        Loading::check(r, keys.load.as_ref(), &keys.constant_load)?;
        let file = Self {
            name: name.into_inner(),
            balls,
            design,
            dynamic_load_rating: keys.dynamic_load_rating_n.map(Spanned::into_inner),
            size_mm: [keys.bore_mm, keys.outside_mm].map(|size| size.map(Spanned::into_inner)),
            loading: Loading::of(keys.load, keys.constant_load),
            file: r.file.to_owned(),
            said,
        };
        // All that follows from a design is worked out of one that can be built.
        let checked = file.design.check(balls);
        checked.map_err(|error| file.explain(&error))?;
        Ok(file)
    }

    /// Basic dynamic load rating `C`, N: the maker's if it is known, else by the formula.
    pub fn dynamic_rating(&self) -> f64 {
        let formula = || self.design.dynamic_load_rating(self.balls);
        self.dynamic_load_rating.unwrap_or_else(formula)
    }

    /// Load ratings of its contacts.
    pub fn rating(&self) -> LifeRating<f64> {
        LifeRating::<f64>::new(&self.design, self.balls, self.dynamic_rating())
    }

    /// The message for a design that the solver refuses: the key and the place it came from, in the file's unit.
    pub fn explain(&self, error: &DesignError) -> DesignFileError {
        let said = self.said.iter().find(|one| one.quantity == error.quantity);
        DesignFileError {
            file: self.file.clone(),
            place: said.map(|one| one.place),
            message: match said {
                Some(Said { key, value, .. }) if (value / error.value).is_finite() => {
                    let unit = value / error.value;
                    let [least, most] = [error.least, error.most].map(|limit| short(unit * limit));
                    format!("`{key}` is {value}, but must lie between {least} and {most}")
                }
                Some(Said { key, .. }) => format!("`{key}`: in SI units, {error}"),
                None => error.to_string(),
            },
        }
    }
}
