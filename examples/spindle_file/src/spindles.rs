//! Spindle files: several bearings on one shaft as a TOML file, in the units of a data sheet. A bearing alone is the only
//! row of a shaft.
//!
//! ```toml
//! name = "7014C back to back"
//! arrangement = "back-to-back"   # or face-to-face, tandem; checked if it is there
//! preload_n = 294                # as the rings are ground: what a pair of such bearings has on rigid seats
//! # mounted_preload_n = 294      # or between the rows of this spindle on its supports and shaft, at rest, cold, without loads
//!
//! [[row]]
//! bearing = "7014c.toml"         # a design file beside this one, or its keys under [row.design]
//! # ball = { youngs_modulus_gpa = 310, poissons_ratio = 0.26, density_kg_m3 = 3200 }  # with balls of another material
//! position_mm = 0
//! facing = "+x"                  # an axial load in +x on the shaft presses its balls
//! # preload_offset_um = 10.3     # or the closure of this row; closures of two rows that face each other add up
//! # spring = true                # this row slides under the spring
//! radial_growth_um = 2           # and axial_growth_um, ball_growth_um; may be left out
//! # What holds the outer ring; what is left out is rigid:
//! # support = { axial_n_per_um = 500, radial_n_per_um = 400, tilting_nm_per_rad = 1e6 }
//!
//! [[row]]
//! bearing = "7014c.toml"
//! position_mm = 27
//! facing = "-x"
//!
//! [spring]                       # if rows slide
//! force_n = 300
//!
//! [shaft]                        # rings grow with the speed, on a hollow shaft with a bore of this diameter
//! bore_mm = 40
//!
//! # Or a shaft that bends: hollow round sections, rigid outside of them and in gaps.
//! # sections = [ { from_mm = -30, to_mm = 60, outer_mm = 70, inner_mm = 40 }, { from_mm = 60, to_mm = 90, outer_mm = 65 } ]
//! # youngs_modulus_gpa = 206     # may be left out: bearing steel
//! # poissons_ratio = 0.3
//! # grow_with_speed = true       # rings grow with the speed on the bores of the sections, in the place of `bore_mm`
//!
//! [heat]                         # growth with the columns t_inner_c, t_outer_c of the loads: shaft and inner rings,
//! reference_c = 20               # housing and outer rings have these temperatures, balls their mean
//! shaft_per_k = 11.5e-6          # may be left out: bearing steel
//! housing_per_k = 11.5e-6
//! ring_per_k = 11.5e-6
//! ball_per_k = 11.5e-6
//! accuracy_k = 0.3               # of the difference of both since commissioning, for the preload that probes measure
//!
//! [load]                         # where recorded loads act; may be left out: x = 0
//! position_mm = -60
//!
//! [[constant_load]]              # besides recorded loads: belt, gear, weight
//! position_mm = 120
//! fy_n = -300                    # and fx_n, fz_n
//!
//! [nose]                         # stiffness there, too
//! position_mm = -60
//! radial_um_per_kn = 2           # what the shaft's end yields itself; may be left out
//! axial_um_per_kn = 0.5          # both are for a shaft without sections
//!
//! [nose.tool]                    # more of them, by name
//! position_mm = -120
//!
//! [[probe]]                      # up to 4 sensors that see the shaft against the housing
//! name = "nose"                  # readings are in the column probe_nose_um
//! position_mm = -10
//! angle_deg = 90                 # from +y towards +z; or direction = "x"
//! accuracy_um = 0.5              # may be left out
//!
//! [monitor.plausible]            # and more about the monitor: see `docs/monitor_keys.md`
//! fx_n = [-1700, 1700]
//! ```
//!
//! On a rigid shaft, loads are referred to `x = 0`. With `sections` or a `support`, they act where they stand.

use crate::catalogue;
use crate::designs::{BallKeys, ConstantLoadKeys, DesignFile, Keys, LoadKeys, Loading};
use crate::doubts::{Doubts, Extent};
use crate::loads::LoadRow;
use crate::loads::celsius;
use crate::monitors::{self, Sensors};
use crate::noses::{Nose, NoseKeys, PLAIN};
use crate::plan::{BuildError, ElasticShaft, MOST_ROWS, Part, Plan, Question, Row, ShaftEnd};
use crate::probes::{self, Probe, ProbeKeys};
use crate::reading::{
    DesignFileError, Key, Place, Reading, micrometres, millimetres, read_text, short,
};
use crate::shafts::{ShaftKeys, SupportKeys};
use serde::Deserialize;
use serde::de::IgnoredAny;
use spindle_bearing::{
    Arrangement, Design, Expansion, Facing, FreeContact, Growth, LifeRating, Material, Preload,
    ShaftLoad, Support,
};
use std::ops::RangeInclusive;
use std::path::Path;
use toml::Spanned;

/// Brings a design file by the name that a spindle's file has for it: how messages call it, and its text.
pub type ReadDesign<'r> = dyn FnMut(&str) -> Result<(String, String), DesignFileError> + 'r;

/// A spindle read from a file.
#[derive(Debug, Clone)]
pub struct SpindleFile {
    /// Its name.
    pub name: String,
    /// It is a bearing alone, from a design file.
    pub is_bearing: bool,
    /// Its rows.
    pub plan: Plan,
    /// Points where the stiffness is wanted besides `x = 0`, the plain `[nose]` first.
    pub noses: Vec<Nose>,
    /// Its probes.
    pub probes: Vec<Probe>,
    /// Growth of each row that is always there.
    pub(crate) growth: Vec<Growth<f64>>,
    /// Bore of the shaft at each row, on which inner rings grow with the speed, m; none if they do not.
    pub(crate) bores: Vec<f64>,
    /// Thermal expansion, if temperatures count.
    pub heat: Option<Heat>,
    /// Settings of its monitor, but for rows, shaft and core: [`SpindleFile::settings`].
    pub(crate) monitor: monitors::Settings,
    /// Settings of its board's sensors.
    pub sensors: Sensors,
    /// Figures that are solved as they are, and seem to be meant otherwise.
    pub doubts: Vec<String>,
    /// Where loads act.
    loading: Loading,
    file: String,
    designs: Vec<DesignFile>,
    /// Places of the parts in the file.
    places: Vec<(Part, Place)>,
}

/// Thermal expansion of shaft, housing and bearings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat {
    /// Temperature at which the bearings have their free contact angle, degrees Celsius.
    pub reference: f64,
    /// Coefficients of expansion.
    pub expansion: Expansion,
    /// Accuracy of the difference of both sides' temperatures since commissioning, K.
    pub accuracy: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpindleKeys {
    name: Key<String>,
    arrangement: Key<String>,
    preload_n: Key<f64>,
    mounted_preload_n: Key<f64>,
    #[serde(default)]
    row: Vec<Spanned<RowKeys>>,
    spring: Option<Spanned<SpringKeys>>,
    shaft: Option<Spanned<ShaftKeys>>,
    heat: Option<Spanned<HeatKeys>>,
    nose: Option<Spanned<NoseKeys>>,
    #[serde(default)]
    probe: Vec<Spanned<ProbeKeys>>,
    load: Option<LoadKeys>,
    #[serde(default)]
    constant_load: Vec<ConstantLoadKeys>,
    /// `monitors::read` takes it.
    #[serde(rename = "monitor")]
    _monitor: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RowKeys {
    bearing: Key<String>,
    ball: Option<Spanned<BallKeys>>,
    design: Option<Spanned<Keys>>,
    position_mm: Key<f64>,
    facing: Key<String>,
    preload_offset_um: Key<f64>,
    spring: Key<bool>,
    support: Option<SupportKeys>,
    axial_growth_um: Key<f64>,
    radial_growth_um: Key<f64>,
    ball_growth_um: Key<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SpringKeys {
    force_n: Key<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HeatKeys {
    reference_c: Key<f64>,
    shaft_per_k: Key<f64>,
    housing_per_k: Key<f64>,
    ring_per_k: Key<f64>,
    ball_per_k: Key<f64>,
    accuracy_k: Key<f64>,
}

/// Growth of a row over its pitch diameter, and of its balls over theirs: a stress of 200 MPa in steel, or 90 K.
const MOST_GROWTH: f64 = 1e-3;

/// Accuracy of the difference of both sides' temperatures that is not said, K: of sensors in one housing, and of a bearing's own heat.
const HEAT_ACCURACY: f64 = 0.3;

/// Thermal expansion of materials, 1/K: from carbon fibre to zinc.
const EXPANSIONS: RangeInclusive<f64> = -2e-6..=3.5e-5;

/// Preload, or force of a spring, over the load rating of a row, at least: makers' light preloads are 2 to 5 thousandths.
const LEAST_PRELOAD: f64 = 1e-3;

/// Closures as ground, um: rings are measured to some tenths.
const OFFSETS: RangeInclusive<f64> = 0.1..=200.0;

/// Distance of two rows over their balls' diameter, at least: bearings are 1.5 balls wide, and double rows of one bearing 1.1 balls.
const NEAREST: f64 = 0.95;

/// Constant load over the load rating of a row, at least: less is without effect on it.
const LEAST_LOAD: f64 = 5e-5;

const ARRANGEMENTS: [Arrangement; 4] = [
    Arrangement::BackToBack,
    Arrangement::FaceToFace,
    Arrangement::Tandem,
    Arrangement::ByRows,
];

/// The one of these that has this name.
fn named<T: Copy>(
    r: &Reading<'_>,
    text: Spanned<String>,
    all: &[T],
    name: impl Fn(T) -> &'static str,
) -> Result<T, DesignFileError> {
    let found = all.iter().find(|one| name(**one) == text.get_ref());
    found.copied().ok_or_else(|| {
        let names: Vec<String> = all.iter().map(|one| format!("{:?}", name(*one))).collect();
        let message = format!("{:?} is none of {}", text.get_ref(), names.join(", "));
        r.error(r.place(text.span()), message)
    })
}

/// Whether angular contact bearings face each other.
fn are_opposed(rows: &[Row]) -> bool {
    let has_angle = |row: &&Row| match row.design.free_contact {
        FreeContact::Angle(angle) => angle > 0.0,
        FreeContact::DiametralClearance(_) => false,
    };
    let mut rows = rows.iter().filter(has_angle);
    let first = rows.next().map(|row| row.facing);
    rows.any(|row| Some(row.facing) != first)
}

fn shaft_loads(forces: impl IntoIterator<Item = (f64, [f64; 3])>) -> Vec<ShaftLoad<f64>> {
    let forces = forces.into_iter();
    let loads = forces.map(|(position, [fx, fy, fz])| ShaftLoad {
        position,
        load: [fx, fy, fz, 0.0, 0.0],
    });
    loads.collect()
}

/// Whether a file describes a spindle: it has rows, or what a bearing has not.
fn is_spindle(text: &str) -> bool {
    const ITS_OWN: [&str; 10] = [
        "row",
        "rows",
        "arrangement",
        "preload_n",
        "mounted_preload_n",
        "spring",
        "shaft",
        "heat",
        "nose",
        "probe",
    ];
    match text.parse::<toml::Table>() {
        Ok(table) => {
            let has = |key: &&str| table.contains_key(*key);
            has(&"row") || !has(&"balls") && ITS_OWN.iter().any(has)
        }
        Err(_) => text.contains("[[row"),
    }
}

impl From<DesignFile> for SpindleFile {
    fn from(file: DesignFile) -> Self {
        Self {
            name: file.name.clone(),
            is_bearing: true,
            plan: Plan::alone(&file.design, file.balls),
            noses: Vec::new(),
            probes: Vec::new(),
            growth: vec![Growth::NONE],
            bores: Vec::new(),
            heat: None,
            monitor: monitors::usual(std::slice::from_ref(&file)),
            sensors: Sensors::USUAL,
            doubts: file.doubts.clone(),
            loading: file.loading.clone(),
            file: String::new(),
            designs: vec![file],
            places: Vec::new(),
        }
    }
}

impl SpindleFile {
    /// The point of the plain `[nose]`.
    pub fn nose(&self) -> Option<ShaftEnd> {
        let plain = self.noses.first().filter(|nose| nose.name == PLAIN);
        plain.map(|nose| nose.end)
    }

    /// Bearings of the rows.
    pub fn designs(&self) -> &[DesignFile] {
        &self.designs
    }

    /// Load ratings of the rows.
    pub fn ratings(&self) -> Vec<LifeRating<f64>> {
        self.designs.iter().map(DesignFile::rating).collect()
    }

    /// Reads a spindle file with the design files that it names, or a design file. If the path is a name
    /// in the [`catalogue`], takes the design from there.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is no spindle and no design; the place in it where it goes wrong.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DesignFileError> {
        let path = path.as_ref();
        // A file is what it is; a name of the catalogue needs no maker where it is unique.
        if !path.exists()
            && let Some(found) = path.to_str().and_then(catalogue::find)
        {
            return found.map(Self::from);
        }
        let (file, text) = read_text(path).map_err(|error| catalogue::hint(path, error))?;
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        Self::of(&file, &text, &mut |name| read_text(&folder.join(name)))
    }

    /// Reads a spindle or a bearing from the text of a file; messages call the file `file`. `read` brings design files that the text
    /// names: how messages call them, and their text.
    ///
    /// # Errors
    ///
    /// A text that is no spindle and no design; the place in it where it goes wrong.
    pub fn of(file: &str, text: &str, read: &mut ReadDesign<'_>) -> Result<Self, DesignFileError> {
        match is_spindle(text) {
            true => Self::of_rows(file, text, read),
            false => DesignFile::parse(file, text).map(Self::from),
        }
    }

    /// Reads a spindle from the text of a file; messages call the file `file`, design files are looked for in `folder`.
    ///
    /// # Errors
    ///
    /// A text that is not a spindle; the place in it where it goes wrong.
    pub fn parse(file: &str, text: &str, folder: &Path) -> Result<Self, DesignFileError> {
        Self::of_rows(file, text, &mut |name| read_text(&folder.join(name)))
    }

    fn of_rows(file: &str, text: &str, read: &mut ReadDesign<'_>) -> Result<Self, DesignFileError> {
        let r = Reading { file, text };
        let table = r.table()?;
        let monitor = table.get_ref().get("monitor").cloned();
        let keys: SpindleKeys = r.keys(table)?;
        let Some(name) = keys.name else {
            return Err(r.missing(None, "name", "\"7014C back to back\""));
        };
        Loading::check(r, keys.load.as_ref(), &keys.constant_load)?;
        let (together, mounted) = (keys.preload_n, keys.mounted_preload_n);
        if let (Some(_), Some(mounted)) = (&together, &mounted) {
            let message =
                "the preload is `preload_n`, as ground, or `mounted_preload_n`; remove one of them";
            return Err(r.error(r.place(mounted.span()), message));
        }
        let arrangement = match keys.arrangement {
            Some(text) => named(&r, text, &ARRANGEMENTS, Arrangement::name)?,
            None => Arrangement::ByRows,
        };
        let (mut rows, mut growth, mut designs) = (Vec::new(), Vec::new(), Vec::new());
        let (mut supports, mut row_places, mut places) = (Vec::new(), Vec::new(), Vec::new());
        let mut doubts = Doubts::of(r);
        let preload = together.as_ref().or(mounted.as_ref());
        places.extend(preload.map(|force| (Part::Preload, r.place(force.span()))));
        for (i, row) in keys.row.into_iter().enumerate() {
            let place = r.place(row.span());
            let row = row.into_inner();
            let missing = |key: &str, example: &str| {
                r.error(
                    place,
                    format!("this row lacks `{key}`; add a line such as `{key} = {example}`"),
                )
            };
            let is_own = row.bearing.is_none();
            let design = match (row.bearing, row.design) {
                (Some(bearing), None) => {
                    let name = bearing.get_ref();
                    let design = match read(name) {
                        Ok((file, text)) => DesignFile::parse(&file, &text),
                        // What is no file may be a name of the catalogue.
                        Err(error) if error.place.is_none() => catalogue::find(name)
                            .unwrap_or_else(|| Err(catalogue::hint(Path::new(name), error))),
                        Err(error) => Err(error),
                    };
                    design.map_err(|error| match error.place {
                        // It is this file's line that names it.
                        None => r.error(r.place(bearing.span()), error.to_string()),
                        Some(_) => error,
                    })?
                }
                (None, Some(keys)) => {
                    let table = r.place(keys.span());
                    DesignFile::of(r, keys.into_inner(), Some(table))?
                }
                (Some(bearing), Some(_)) => {
                    let message = "the row has `bearing` and [row.design]; remove one of them";
                    return Err(r.error(r.place(bearing.span()), message));
                }
                (None, None) => return Err(missing("bearing", "\"7014c.toml\"")),
            };
            let design = match row.ball {
                Some(ball) if is_own => {
                    let message = "`ball` is for a `bearing`; move it into [row.design]";
                    return Err(r.error(r.place(ball.span()), message));
                }
                Some(ball) => design.with_balls(r, ball.into_inner(), &mut doubts)?,
                None => design,
            };
            if design.loading != Loading::default() {
                let message = "a row has no loads: [load] and [[constant_load]] are the spindle's";
                return Err(r.error(place, message));
            }
            let mut note = |part, span| places.push((part, r.place(span)));
            if let Some(slides) = &row.spring {
                note(Part::Slides(i), slides.span());
            }
            let spring = row.spring.is_some_and(Spanned::into_inner);
            let offset = row.preload_offset_um;
            if let Some(offset) = &offset {
                note(Part::Closure(i), offset.span());
                let (place, said) = (r.place(offset.span()), *offset.get_ref());
                if said != 0.0 {
                    doubts.unusual(place, ("preload_offset_um", said), OFFSETS, "is it in um?");
                }
            }
            let closure = micrometres(offset.as_ref().map_or(0.0, |offset| *offset.get_ref()));
            let preload = match (spring, &together) {
                (true, _) => Preload::Spring,
                (false, Some(force)) => Preload::Force(*force.get_ref()),
                (false, None) => Preload::Closure(closure),
            };
            if let (Some(mounted), true) = (&mounted, spring || offset.is_some()) {
                let message = "`mounted_preload_n` finds the closure of all rows; remove it, or `preload_offset_um` and `spring`";
                return Err(r.error(r.place(mounted.span()), message));
            }
            if let (Some(offset), Preload::Spring | Preload::Force(_)) = (offset, preload) {
                let message = if spring {
                    "a row that slides under the spring has no closure; remove `preload_offset_um` or `spring`"
                } else {
                    "`preload_n` above preloads all clamped rows; remove that or this"
                };
                return Err(r.error(r.place(offset.span()), message));
            }
            let Some(position) = row.position_mm else {
                return Err(missing("position_mm", "0.0"));
            };
            let Some(facing) = row.facing else {
                return Err(missing("facing", "\"+x\""));
            };
            let support = row.support.map(|keys| keys.read(r, i, &mut doubts));
            supports.push(support.transpose()?);
            let mut grown = |key: &str, said: Key<f64>, of: f64| {
                let Some(said) = said else { return Ok(0.0) };
                let most = short(1e6 * MOST_GROWTH * of);
                let question = "is it in um?";
                doubts.unusual(
                    r.place(said.span()),
                    (key, *said.get_ref()),
                    -most..=most,
                    question,
                );
                r.within(key, &said, -1e3..=1e3).map(micrometres)
            };
            let Design {
                pitch_diameter,
                ball_diameter,
                ..
            } = design.design;
            growth.push(Growth {
                axial: grown("axial_growth_um", row.axial_growth_um, f64::INFINITY)?,
                radial: grown("radial_growth_um", row.radial_growth_um, pitch_diameter)?,
                ball: grown("ball_growth_um", row.ball_growth_um, ball_diameter)?,
            });
            note(Part::Position(i), position.span());
            note(Part::Facing(i), facing.span());
            let position = millimetres(position.into_inner());
            row_places.push(place);
            rows.push(Row {
                balls: design.balls,
                design: design.design,
                position,
                facing: named(&r, facing, &[Facing::PlusX, Facing::MinusX], Facing::name)?,
                preload,
            });
            designs.push(design);
        }
        if !(1..=MOST_ROWS).contains(&rows.len()) {
            return Err(r.error(r.place(0..0), BuildError::Rows(rows.len()).to_string()));
        }
        let ratings = designs.iter();
        let ratings = ratings.map(|of| of.design.dynamic_load_rating(of.balls));
        let (least, sum) = ratings.fold((f64::INFINITY, 0.0), |(least, sum), c| {
            (c.min(least), sum + c)
        });
        let spring = keys.spring.as_ref();
        for (key, said) in [
            ("preload_n", &together),
            ("mounted_preload_n", &mounted),
            (
                "force_n",
                spring.map_or(&None, |keys| &keys.get_ref().force_n),
            ),
        ] {
            if let Some(said) = said {
                let usual = LEAST_PRELOAD * least..=0.5 * least;
                doubts.unusual(
                    r.place(said.span()),
                    (key, *said.get_ref()),
                    usual,
                    "is it in N?",
                );
            }
        }
        let spring = keys.spring.map(|keys| {
            let table = ("spring", r.place(keys.span()));
            let keys = keys.into_inner();
            let place = keys.force_n.as_ref().map(|force| r.place(force.span()));
            places.extend(place.map(|place| (Part::Spring, place)));
            r.needed(table, "force_n", "300", keys.force_n)
        });
        for (i, load) in keys.constant_load.iter().enumerate() {
            places.extend(load.places(r, i));
        }
        let (sections, material) = match &keys.shaft {
            Some(keys) => keys.get_ref().sections(r, &mut doubts)?,
            None => (None, Material::STEEL),
        };
        let is_preloaded = together.is_some() || mounted.is_some() || spring.is_some();
        let is_closed = places
            .iter()
            .any(|(part, _)| matches!(part, Part::Closure(_)));
        if !is_preloaded && !is_closed && are_opposed(&rows) {
            let message = "no row has a preload, and usual is one: add `preload_n`, `mounted_preload_n`, `preload_offset_um` or [spring]";
            doubts.tell(Place::TOP, message.to_owned());
        }
        for (i, (row, place)) in rows.iter().zip(&row_places).enumerate() {
            let distances = rows[..i]
                .iter()
                .map(|other| (other.position - row.position).abs());
            let nearest = distances.fold(f64::INFINITY, f64::min);
            if nearest < NEAREST * row.design.ball_diameter {
                let [nearest, ball] = [nearest, row.design.ball_diameter].map(|x| short(1e3 * x));
                let message = format!(
                    "row {i}: `position_mm` is {}, {nearest} mm from another row, and balls are {ball} mm: are there two rows? rows count \
                     from 0",
                    short(1e3 * row.position)
                );
                doubts.tell(*place, message);
            }
        }
        let extent = Extent::of(&rows, sections.as_deref().unwrap_or_default());
        let noses = keys.nose.map(|keys| {
            let table = r.place(keys.span());
            keys.into_inner().read(r, table, &extent, &mut doubts)
        });
        let noses = noses.transpose()?.unwrap_or_default();
        Loading::check_on(
            (r, &mut doubts),
            (keys.load.as_ref(), &keys.constant_load),
            (&extent, &noses),
            LEAST_LOAD * least..=sum,
        )?;
        let mut loading = Loading::of(keys.load, keys.constant_load);
        let bends = sections.is_some();
        let placed: Vec<(&Row, Place)> = rows.iter().zip(row_places).collect();
        let mut bores = Vec::new();
        if let Some(keys) = &keys.shaft {
            let (place, keys) = (r.place(keys.span()), keys.get_ref());
            bores = keys.bores(r, place, sections.as_deref(), &placed)?;
            keys.doubt(r, sections.as_deref(), &placed, &designs, &mut doubts);
        }
        let is_elastic = bends || supports.iter().any(Option::is_some);
        let shaft = is_elastic.then(|| {
            let Loading { position, constant } = std::mem::take(&mut loading);
            let supports = supports.into_iter();
            ElasticShaft {
                sections: sections.unwrap_or_default(),
                material,
                supports: supports
                    .map(|support| support.unwrap_or(Support::RIGID))
                    .collect(),
                loads: shaft_loads(constant),
                loaded_at: position,
            }
        });
        let reference = keys.heat.as_ref();
        let reference = reference.and_then(|heat| heat.get_ref().reference_c.as_ref());
        let reference = reference.map(|said| (*said.get_ref(), r.place(said.span())));
        let heat = keys.heat.map(|keys| {
            let table = ("heat", r.place(keys.span()));
            let keys = keys.into_inner();
            let place = keys.reference_c.as_ref().map(|value| r.place(value.span()));
            let said = keys.reference_c.as_ref().map(|value| *value.get_ref());
            if let (Some(place), Some(said)) = (place, said) {
                doubts.unusual(
                    place,
                    ("reference_c", said),
                    0.0..=60.0,
                    "is it in degrees Celsius?",
                );
            }
            let reference = r.needed(table, "reference_c", "20", keys.reference_c)?;
            if let (Err(message), Some(place)) = (celsius(reference), place) {
                return Err(r.error(place, format!("reference_c: {message}")));
            }
            let mut per_kelvin = |key: &str, said: Key<f64>, steel: f64| {
                let Some(said) = said else { return Ok(steel) };
                let value = *said.get_ref();
                doubts.unusual(
                    r.place(said.span()),
                    (key, value),
                    EXPANSIONS,
                    "is it in 1/K?",
                );
                r.within(key, &said, -1e-4..=1e-4)
            };
            let steel = Expansion::STEEL;
            let accuracy = keys.accuracy_k.as_ref();
            let accuracy = accuracy.map(|said| r.within("accuracy_k", said, 0.0..=20.0));
            Ok(Heat {
                reference,
                accuracy: accuracy.transpose()?.unwrap_or(HEAT_ACCURACY),
                expansion: Expansion {
                    shaft: per_kelvin("shaft_per_k", keys.shaft_per_k, steel.shaft)?,
                    housing: per_kelvin("housing_per_k", keys.housing_per_k, steel.housing)?,
                    ring: per_kelvin("ring_per_k", keys.ring_per_k, steel.ring)?,
                    ball: per_kelvin("ball_per_k", keys.ball_per_k, steel.ball)?,
                },
            })
        });
        let spring = spring.transpose()?;
        let heat = heat.transpose()?;
        let (monitor, sensors) =
            monitors::read(r, monitor.as_ref(), &designs, reference, &mut doubts)?;
        // The spindle's nose may not be drawn; a tool is not what a probe sees.
        let nose = noses.iter().filter(|nose| nose.name == PLAIN);
        let extent = extent.with(nose.map(|nose| nose.end.position));
        let bridges = sensors.bridges.as_ref();
        let probes = probes::read(r, keys.probe, bridges, &extent, &mut doubts)?;
        let of_designs = designs.iter().flat_map(|design| design.doubts.clone());
        let doubts = doubts.finish(of_designs);
        Ok(Self {
            name: name.into_inner(),
            is_bearing: false,
            plan: Plan {
                rows,
                arrangement,
                spring,
                mounted_preload: mounted.map(|force| (force.into_inner(), growth.clone())),
                shaft,
            },
            noses,
            probes,
            growth,
            bores,
            heat,
            monitor,
            sensors,
            doubts,
            loading,
            file: file.to_owned(),
            designs,
            places,
        })
    }

    /// Growth of each row: cold and at rest, per K of the inner and of the outer side, and per square of the speed, (rad/s)^2.
    pub fn growths(&self) -> Vec<[Growth<f64>; 4]> {
        let middle = self.plan.middle();
        let rows = self.plan.rows.iter().zip(&self.growth).enumerate();
        let growths = rows.map(|(i, (row, fixed))| {
            let design: &Design = &row.design;
            let turning = self.bores.get(i);
            let turning = turning.map(|bore| Growth::by_rotation(design, *bore, 1.0));
            let reach = row.facing.sign::<f64>() * (row.position - middle);
            let per_kelvin = |sides| match &self.heat {
                Some(heat) => Growth::by_temperatures(design, &heat.expansion, reach, sides),
                None => Growth::NONE,
            };
            [
                *fixed,
                per_kelvin([1.0, 0.0]),
                per_kelvin([0.0, 1.0]),
                turning.unwrap_or(Growth::NONE),
            ]
        });
        growths.collect()
    }

    /// Where recorded loads act, m.
    pub fn loaded_at(&self) -> f64 {
        match &self.plan.shaft {
            Some(shaft) => shaft.loaded_at,
            None => self.loading.position,
        }
    }

    /// Loads besides the recorded ones on a rigid shaft.
    pub fn constant_loads(&self) -> Vec<ShaftLoad<f64>> {
        shaft_loads(self.loading.constant.iter().copied())
    }

    /// The load, speed and growth that a row of loads stands for, at the noses.
    pub fn question(&self, row: &LoadRow) -> Question {
        let omega = row.omega();
        let heat = self.heat.as_ref().zip(row.temperatures);
        let heat = heat.map(|(heat, t)| (&heat.expansion, t.map(|t| t - heat.reference)));
        let [inner, outer] = heat.map_or([0.0; 2], |(_, warmer)| warmer);
        let growth = self.growths().into_iter();
        let growth = growth.map(|[fixed, per_inner, per_outer, turning]| {
            fixed + turning * (omega * omega) + per_inner * inner + per_outer * outer
        });
        let middle = self.plan.middle();
        let middle_growth = |(expansion, warmer)| Growth::by_length(expansion, middle, warmer);
        Question {
            growth: growth.collect(),
            middle_growth: heat.map_or(0.0, |heat| middle_growth(heat).axial),
            ends: self.noses.iter().map(|nose| nose.end).collect(),
            ..Question::load(self.loading.about_origin(row.load), omega)
        }
    }

    /// The question of a row of loads at the probes, in the place of the noses.
    pub fn question_at_probes(&self, row: &LoadRow) -> Question {
        let ends = self
            .probes
            .iter()
            .map(|probe| ShaftEnd::rigid(probe.position));
        Question {
            ends: ends.collect(),
            ..self.question(row)
        }
    }

    /// The files that it was read from; names of the catalogue are among them.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let designs = self.designs.iter().map(|design| &design.file);
        [&self.file].into_iter().chain(designs).map(Path::new)
    }

    /// The message for a spindle that the solver refuses.
    pub fn explain(&self, error: &BuildError) -> DesignFileError {
        if let BuildError::Design(row, error) = error {
            return self.designs[*row].explain(error);
        }
        let place = match error {
            BuildError::Part(part, _) => {
                let said = self.places.iter().find(|(of, _)| of == part);
                Some(said.map_or(Place::TOP, |(_, place)| *place))
            }
            _ => None,
        };
        DesignFileError {
            file: self.file.clone(),
            place,
            message: error.to_string(),
        }
    }
}
