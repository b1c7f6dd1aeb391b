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

use crate::doubts::{Doubts, Extent};
use crate::noses::Nose;
use crate::plan::{BALL_COUNTS, Part};
pub use crate::reading::{DesignFileError, Place, short};
use crate::reading::{Key, POSITIONS, Reading, micrometres, millimetres, read_text};
use serde::Deserialize;
use serde::de::IgnoredAny;
use spindle_bearing::{Design, DesignError, FreeContact, LifeRating, Material, Quantity};
use std::f64::consts::PI;
use std::ops::RangeInclusive;
use std::path::Path;
use toml::Spanned;

/// The folder of the design files that come with the project.
pub const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/bearings");

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
    /// Figures that are read as they are, and seem to be meant otherwise.
    pub doubts: Vec<String>,
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

impl Said {
    fn new(r: Reading<'_>, quantity: Quantity, key: &'static str, said: &Spanned<f64>) -> Self {
        Self {
            quantity,
            key,
            value: *said.get_ref(),
            place: r.place(said.span()),
        }
    }
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

    /// Looks where loads act on a spindle: that is refused where it is far off. Doubts those that stand out without a nose or a
    /// recorded load there, and forces beyond the range from a belt's to `most`, N.
    pub(crate) fn check_on(
        (r, doubts): (Reading<'_>, &mut Doubts<'_>),
        (load, constant): (Option<&LoadKeys>, &[ConstantLoadKeys]),
        (extent, noses): (&Extent, &[Nose]),
        forces: RangeInclusive<f64>,
    ) -> Result<(), DesignFileError> {
        let positions = constant.iter().map(|keys| &keys.position_mm);
        for said in positions.chain(load.map(|load| &load.position_mm)) {
            let position = millimetres(*said.get_ref());
            if extent.is_far(position) {
                let (words, length) = (extent.words(position), extent.words_of_length());
                let message = format!(
                    "`position_mm` of the load is {}, {words}: a load must be within {length}",
                    said.get_ref()
                );
                return Err(r.error(r.place(said.span()), message));
            }
        }
        if load.is_none() && extent.is_far(0.0) {
            let words = extent.words(0.0);
            let message = format!(
                "recorded loads act at `position_mm` = 0 of [load], which is not there, {words}: do they act there?"
            );
            doubts.tell(Place::TOP, message);
        }
        let tools = noses.iter().map(|nose| nose.end.position);
        let tools = tools.chain(load.map(|load| millimetres(*load.position_mm.get_ref())));
        let tools = extent.clone().with(tools);
        for keys in constant {
            let said = &keys.position_mm;
            let (place, at) = (r.place(said.span()), *said.get_ref());
            if extent.is_drawn() && tools.is_beyond(millimetres(at)) {
                let words = extent.words(millimetres(at));
                let message =
                    format!("`position_mm` of a constant load is {at}, {words}: is it in mm?");
                doubts.tell(place, message);
            }
            for (key, force) in keys.forces().filter(|(_, force)| *force.get_ref() != 0.0) {
                let (place, force) = (r.place(force.span()), *force.get_ref());
                doubts.unusual(place, (key, force), forces.clone(), "is it in N?");
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

/// The keys of a design.
#[derive(Deserialize, Default)]
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

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RingKeys {
    youngs_modulus_gpa: Key<f64>,
    poissons_ratio: Key<f64>,
}

/// Keys of the balls' material.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct BallKeys {
    youngs_modulus_gpa: Key<f64>,
    poissons_ratio: Key<f64>,
    density_kg_m3: Key<f64>,
}

impl BallKeys {
    fn check(&self, r: Reading<'_>) -> Result<(), DesignFileError> {
        match &self.density_kg_m3 {
            Some(said) => r.within("ball.density_kg_m3", said, DENSITIES).map(drop),
            None => Ok(()),
        }
    }
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

/// Usual amounts of a design's numbers but 0, and what others may be.
#[rustfmt::skip]
const USUAL: [(&str, RangeInclusive<f64>, &str); 7] = [
    // A degree is 0.017 rad, and 57 degrees are 1 rad.
    ("contact_angle_deg", 1.0..=90.0, "is it in radians?"),
    // Classes of clearance are whole micrometres; a millimetre is beyond all bearings with bores up to a metre.
    ("diametral_clearance_um", 0.2..=1e3, "is it in mm?"),
    ("ring.youngs_modulus_gpa", MODULI, "is it in GPa?"),
    ("ring.poissons_ratio", RATIOS, "is it that ratio?"),
    ("ball.youngs_modulus_gpa", MODULI, "is it in GPa?"),
    ("ball.poissons_ratio", RATIOS, "is it that ratio?"),
    // From glass and silicon nitride to tungsten carbide.
    ("ball.density_kg_m3", 2e3..=17e3, "is it in kg/m^3?"),
];
/// Young's moduli of materials of rings, balls and shafts, GPa: from magnesium to tungsten carbide.
pub(crate) const MODULI: RangeInclusive<f64> = 40.0..=720.0;
/// Poisson's ratios: from beryllium and carbides to lead.
pub(crate) const RATIOS: RangeInclusive<f64> = 0.05..=0.45;
/// Densities below which balls are of a stiff ceramic and above which they are of steel, and of a hard metal, kg/m^3: zirconia,
/// which is as stiff as steel, has 6000. Young's modulus between steel's and those of such ceramics, Pa.
const CERAMIC_DENSITY: f64 = 4500.0;
const STEEL_DENSITY: f64 = 7000.0;
const HEAVY_DENSITY: f64 = 9000.0;
const CERAMIC_MODULUS: f64 = 260e9;
/// Place of the pitch circle between bore and outside diameter, as a part of their difference: 0.47 to 0.53 in makers' tables.
const MIDDLE: RangeInclusive<f64> = 0.35..=0.65;
/// Least part of the pitch circle that balls fill: a deep groove bearing, filled by the eccentric ring, has half.
const LEAST_FILL: f64 = 0.35;

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
        Self::of(r, r.keys(r.table()?)?, None)
    }

    /// The design of these keys, which stand in the `table` at this place of a spindle's file, if it is not a file of its own.
    pub(crate) fn of(
        r: Reading<'_>,
        keys: Keys,
        table: Option<Place>,
    ) -> Result<Self, DesignFileError> {
        let mut design = Design::angular_contact(0.0, 0.0, 0.0);
        let mut said: Vec<Said> = Vec::new();
        for (quantity, key, example, number, set) in NUMBERS {
            let Some(number) = number(&keys) else {
                let other = EITHER.iter().find(|(one, _)| *one == key);
                let is_said = other.is_some_and(|(_, other)| said_by(&keys, other));
                if !example.is_empty() && !is_said {
                    return Err(r.missing(table, key, example));
                }
                continue;
            };
            let one = Said::new(r, quantity, key, number);
            let pair = |other: &Said| {
                let is_pair = |(a, b): &(&str, &str)| (*a, *b) == (other.key, key);
                EITHER.iter().any(is_pair)
            };
            if let Some(other) = said.iter().find(|one| pair(one)) {
                let mut places = [one.place, other.place];
                places.sort_by_key(|place| place.line);
                let message = format!(
                    "`{}` and `{key}` say the same thing, and line {} already says it; remove one of them",
                    other.key, places[0].line
                );
                return Err(r.error(places[1], message));
            }
            set(&mut design, one.value);
            said.push(one);
        }
        if !said
            .iter()
            .any(|one| EITHER[2].0 == one.key || EITHER[2].1 == one.key)
        {
            let line = "contact_angle_deg = 15` or `diametral_clearance_um = 10";
            return Err(r.lacks(table, "the contact angle", line));
        }
        let missing = || r.missing(table, "name", "\"B7005C\"");
        let name = keys.name.ok_or_else(missing)?;
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
        ] {
            if let Some(said) = said {
                r.within(key, said, range)?;
            }
        }
        keys.ball.check(r)?;
        if let Some(monitor) = &keys.monitor {
            let message =
                "[monitor] is a spindle's: move it to a file with a [[row]] of this bearing";
            return Err(r.error(r.place(monitor.span()), message));
        }
        Loading::check(r, keys.load.as_ref(), &keys.constant_load)?;
        let mut file = Self {
            name: name.into_inner(),
            balls,
            design,
            dynamic_load_rating: keys.dynamic_load_rating_n.as_ref().map(|c| *c.get_ref()),
            size_mm: [&keys.bore_mm, &keys.outside_mm]
                .map(|size| size.as_ref().map(|size| *size.get_ref())),
            loading: Loading::of(keys.load, keys.constant_load),
            doubts: Vec::new(),
            file: r.file.to_owned(),
            said,
        };
        // All that follows from a design is worked out of one that can be built.
        let checked = design.check(balls);
        checked.map_err(|error| file.explain(&error))?;
        let mut doubts = Doubts::of(r);
        file.sizes(r, [&keys.bore_mm, &keys.outside_mm], &mut doubts)?;
        file.doubt(r, keys.dynamic_load_rating_n.as_ref(), &mut doubts);
        file.doubts = doubts.finish([]);
        Ok(file)
    }

    /// The bearing with balls of another material, which a row of a spindle's file has beside its bearing.
    pub(crate) fn with_balls(
        mut self,
        r: Reading<'_>,
        ball: BallKeys,
        doubts: &mut Doubts<'_>,
    ) -> Result<Self, DesignFileError> {
        ball.check(r)?;
        let keys = Keys {
            ball,
            ..Keys::default()
        };
        let mut said = Vec::new();
        for (quantity, key, _, number, set) in NUMBERS {
            if let Some(number) = number(&keys) {
                said.push(Said::new(r, quantity, key, number));
                set(&mut self.design, *number.get_ref());
            }
        }
        let own = Self {
            file: r.file.to_owned(),
            said,
            ..self.clone()
        };
        let checked = self.design.check(self.balls);
        checked.map_err(|error| own.explain(&error))?;
        own.doubt(r, None, doubts);
        Ok(self)
    }

    /// Looks whether bore, balls and outside diameter lie one beyond the other.
    fn sizes(
        &self,
        r: Reading<'_>,
        sizes: [&Key<f64>; 2],
        doubts: &mut Doubts<'_>,
    ) -> Result<(), DesignFileError> {
        let [bore, outside] = sizes;
        if let (Some(bore), Some(outside)) = (bore, outside)
            && bore.get_ref() >= outside.get_ref()
        {
            let message = format!(
                "`outside_mm` is {}, but must be above `bore_mm`, which is {}: exchange them",
                outside.get_ref(),
                bore.get_ref()
            );
            return Err(r.error(r.place(outside.span()), message));
        }
        let [pitch, ball] =
            [self.design.pitch_diameter, self.design.ball_diameter].map(|x| 1e3 * x);
        for (key, said, sign) in [("bore_mm", bore, 1.0), ("outside_mm", outside, -1.0)] {
            let Some(said) = said else { continue };
            let value = *said.get_ref();
            let side = if sign > 0.0 { "above" } else { "below" };
            if sign * (pitch - value) <= 0.0 {
                let place = self.said(Quantity::PitchDiameter).map(|said| said.place);
                let message = format!(
                    "`pitch_diameter_mm` is {}, but must be {side} `{key}`, which is {value}: balls run between bore and outside \
                     diameter",
                    short(pitch)
                );
                return Err(r.error(place.unwrap_or(Place::TOP), message));
            }
            // A groove's bottom is half a ball beyond the balls' centres, about.
            let groove = pitch - sign * ball;
            if sign * (groove - value) <= 0.0 {
                let message = format!(
                    "`{key}` is {value}, and the groove's bottom has a diameter of {}, which is {side} it in usual bearings: is it of \
                     this bearing?",
                    short(groove)
                );
                doubts.tell(r.place(said.span()), message);
            } else if let (Some(bore), Some(outside)) = (bore, outside) {
                let (bore, outside) = (*bore.get_ref(), *outside.get_ref());
                let part = (pitch - bore) / (outside - bore);
                if !MIDDLE.contains(&part) && sign * (part - 0.5) > 0.0 {
                    let message = format!(
                        "`{key}` is {value}, and `pitch_diameter_mm` = {} is usually about the mean of `bore_mm` = {bore} and \
                         `outside_mm` = {outside}: are all three of one bearing?",
                        short(pitch)
                    );
                    doubts.tell(r.place(said.span()), message);
                }
            }
        }
        Ok(())
    }

    /// Doubts what it says of itself, and its load rating.
    fn doubt(&self, r: Reading<'_>, rating: Option<&Spanned<f64>>, doubts: &mut Doubts<'_>) {
        for (key, usual, question) in USUAL {
            let said = self.said.iter().find(|said| said.key == key);
            // A deep groove bearing has no contact angle, and may have no clearance.
            if let Some(said) = said.filter(|said| said.value != 0.0) {
                doubts.unusual(said.place, (key, said.value), usual, question);
            }
        }
        let Material {
            youngs_modulus,
            density,
            ..
        } = self.design.ball;
        let of_ball = [Quantity::BallDensity, Quantity::BallYoungsModulus];
        let of_ball = of_ball.into_iter().find_map(|quantity| self.said(quantity));
        let is_half = match density {
            ..CERAMIC_DENSITY => youngs_modulus < CERAMIC_MODULUS,
            STEEL_DENSITY.. => youngs_modulus > CERAMIC_MODULUS && density < HEAVY_DENSITY,
            _ => false,
        };
        if let (Some(said), true) = (of_ball, is_half) {
            let modulus = short(1e-9 * youngs_modulus);
            let message = format!(
                "the balls have `youngs_modulus_gpa` = {modulus} and `density_kg_m3` = {density}, and usual are 206 and 7850 of steel, \
                 310 and 3200 of silicon nitride: are both of one material?"
            );
            doubts.tell(said.place, message);
        }
        if let Some(said) = self.said(Quantity::BallCount) {
            let (
                balls,
                Design {
                    ball_diameter,
                    pitch_diameter,
                    ..
                },
            ) = (self.balls as f64, self.design);
            let fill = balls * ball_diameter / (PI * pitch_diameter);
            if fill < LEAST_FILL {
                let message = format!(
                    "`balls` is {balls}, which fill {fill:.2} of the circle of `pitch_diameter_mm`, and usual are 0.5 to 0.95: is it \
                     another number, or another `ball_diameter_mm`?"
                );
                doubts.tell(said.place, message);
            }
        }
        let formula = self.design.dynamic_load_rating(self.balls);
        if let Some(rating) = rating {
            let [least, most] = [0.5, 2.0].map(|part| short((part * formula).round()));
            doubts.unusual(
                r.place(rating.span()),
                ("dynamic_load_rating_n", *rating.get_ref()),
                least..=most,
                "ISO 281 has a figure between for these balls; is it in N?",
            );
        }
    }

    /// A quantity of the file: its key, value and place.
    fn said(&self, quantity: Quantity) -> Option<&Said> {
        self.said.iter().find(|one| one.quantity == quantity)
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
