//! Bearings under load to judge solvers by: solved ones from a file, and random ones.

use crate::compare::{self, Equilibrium};
use crate::reference::{Reference, Task};
use cli::random::Random;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use solvers::dispatch::Attitude;
use spindle_bearing::{
    Arrangement, BallState, Design, Facing, FreeContact, Growth, Material, Preload, Section,
    Support,
};
use spindle_file::plan::{self, ElasticShaft, Plan, Question, ShaftEnd};
use std::f64::consts::{PI, TAU};

/// Large, and turned fast for its size: gyroscopic moments matter.
pub const B218: Design = Design {
    inner_groove_factor: 0.5232,
    outer_groove_factor: 0.5232,
    ..Design::angular_contact(22.23e-3, 125.26e-3, 40.0 * PI / 180.0)
};

/// A spindle bearing, of steel throughout.
pub const B7005C: Design = Design {
    inner_shoulder_angle: 48.0 * PI / 180.0,
    outer_shoulder_angle: 47.5 * PI / 180.0,
    ..Design::angular_contact(6.35e-3, 36e-3, 15.0 * PI / 180.0)
};

/// A deep groove bearing with a small clearance.
pub const SKF6205: Design = Design {
    inner_groove_factor: 0.52,
    outer_groove_factor: 0.52,
    free_contact: FreeContact::DiametralClearance(10e-6),
    inner_shoulder_angle: 52.0 * PI / 180.0,
    outer_shoulder_angle: 52.0 * PI / 180.0,
    ..Design::angular_contact(7.938e-3, 39.04e-3, 0.0)
};

/// The file of solved cases; `README.md` beside it says what is in it.
pub const PUBLIC: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/public.json");

/// A bearing, its load and its speed.
#[derive(Debug, Clone)]
pub struct Case {
    /// Its name in failure messages.
    pub name: String,
    /// Ball count.
    pub balls: usize,
    /// The bearing.
    pub design: Design,
    /// Rule for the balls' attitude.
    pub attitude: Attitude,
    /// `Fx, Fy, Fz, My, Mz`, N and N m.
    pub load: [f64; 5],
    /// Shaft speed, rad/s.
    pub omega: f64,
}

/// A case and its solution.
#[derive(Debug, Clone)]
pub struct SolvedCase {
    /// The case.
    pub case: Case,
    /// Its solution.
    pub truth: Equilibrium,
    /// Load-deformation constants, inner and outer, N/m^1.5.
    pub hertz: [f64; 2],
}

#[derive(Deserialize)]
struct Row {
    name: String,
    attitude: Attitude,
    bearing: BearingRow,
    load: [f64; 5],
    speed_rpm: f64,
    expect: Expect,
}

#[derive(Deserialize)]
struct BearingRow {
    balls: usize,
    ball_diameter: f64,
    pitch_diameter: f64,
    inner_groove_factor: f64,
    outer_groove_factor: f64,
    contact_angle_deg: f64,
    #[serde(with = "MaterialRow")]
    ring: Material,
    #[serde(with = "MaterialRow")]
    ball: Material,
}

#[derive(Deserialize)]
#[serde(remote = "Material")]
struct MaterialRow {
    #[serde(rename = "E")]
    youngs_modulus: f64,
    #[serde(rename = "nu")]
    poissons_ratio: f64,
    /// The rings' does not matter and is left out.
    #[serde(rename = "rho", default = "of_steel")]
    density: f64,
}

fn of_steel() -> f64 {
    Material::STEEL.density
}

#[derive(Deserialize)]
struct Expect {
    #[serde(flatten)]
    truth: Equilibrium,
    #[serde(rename = "Ki")]
    inner: f64,
    #[serde(rename = "Ko")]
    outer: f64,
}

impl BearingRow {
    fn design(&self) -> Design {
        let angle = self.contact_angle_deg.to_radians();
        Design {
            inner_groove_factor: self.inner_groove_factor,
            outer_groove_factor: self.outer_groove_factor,
            ring: self.ring,
            ball: self.ball,
            ..Design::angular_contact(self.ball_diameter, self.pitch_diameter, angle)
        }
    }
}

/// Speed in rad/s.
pub fn rad_per_s(rpm: f64) -> f64 {
    rpm * PI / 30.0
}

/// The solved cases, numbered in their names.
///
/// # Panics
///
/// If the file is not there or is not what it should be.
pub fn public() -> Vec<SolvedCase> {
    let solved = |(number, row): (usize, Row)| SolvedCase {
        case: Case {
            name: format!("{number} ({})", row.name),
            balls: row.bearing.balls,
            design: row.bearing.design(),
            attitude: row.attitude,
            load: row.load,
            omega: rad_per_s(row.speed_rpm),
        },
        truth: row.expect.truth,
        hertz: [row.expect.inner, row.expect.outer],
    };
    read(PUBLIC).into_iter().enumerate().map(solved).collect()
}

fn read<T: DeserializeOwned>(path: &str) -> Vec<T> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}"));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The files of solved sets, on rigid and on elastic shafts; `README.md` beside them says what is in them.
const SETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/sets.json");
const ELASTIC: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/cases/elastic.json");

/// A solved set of bearings on one shaft.
#[derive(Debug, Clone)]
pub struct SolvedSet {
    /// Its name in failure messages.
    pub name: String,
    /// Rows, arrangement and spring.
    pub plan: Plan,
    /// Rule for the balls' attitude.
    pub attitude: Attitude,
    /// Load on the shaft, speed and growth.
    pub question: Question,
    /// The solution at `x = 0`, as far as it is compared: the balls are those of all rows.
    pub truth: Equilibrium,
    /// Closure that a spring makes, m.
    pub spring_closure: Option<f64>,
    /// The rows.
    pub rows: Vec<SolvedRow>,
    /// The shaft's answer at its nose, if it is elastic: at the end of the question.
    pub nose: Option<SolvedNose>,
}

/// Load, motion and balls of a row of a solved set.
#[derive(Debug, Clone, Deserialize)]
pub struct SolvedRow {
    /// Load on its inner ring, in the row's own frame.
    #[serde(rename = "F")]
    pub load: [f64; 5],
    /// Displacement of an elastic shaft at the row, in the shaft's frame, m and rad.
    #[serde(rename = "w")]
    pub displacement: Option<[f64; 5]>,
    /// The balls; on an elastic shaft without inertia loads.
    #[serde(deserialize_with = "compare::balls")]
    pub balls: Vec<BallState<f64>>,
}

#[derive(Deserialize)]
struct SetRow {
    layout: String,
    attitude: Attitude,
    rows: Vec<MountedRow>,
    load: [f64; 5],
    speed_rpm: f64,
    spring_force: Option<f64>,
    shaft: Option<ElasticRow>,
    nose: Option<f64>,
    expect: SetExpect,
}

#[derive(Deserialize)]
struct MountedRow {
    bearing: BearingRow,
    position: f64,
    facing: f64,
    growth: [f64; 3],
    preload_offset: Option<f64>,
    #[serde(default)]
    support: SupportRow,
}

#[derive(Deserialize)]
struct SetExpect {
    u: [f64; 5],
    #[serde(rename = "K")]
    stiffness: [[f64; 5]; 5],
    rows: Vec<SolvedRow>,
    spring_offset: Option<f64>,
    nose: Option<SolvedNose>,
}

/// Arrangement of a layout of the file.
fn arrangement(layout: &str) -> Arrangement {
    match layout {
        "DB" | "TBT" | "QBC" | "spindle" => Arrangement::BackToBack,
        "DF" | "TFT" | "QFC" | "spindle, face to face" => Arrangement::FaceToFace,
        _ => Arrangement::ByRows,
    }
}

impl MountedRow {
    fn row(&self) -> plan::Row {
        plan::Row {
            balls: self.bearing.balls,
            design: self.bearing.design(),
            position: self.position,
            facing: if self.facing > 0.0 {
                Facing::PlusX
            } else {
                Facing::MinusX
            },
            preload: match self.preload_offset {
                Some(closure) => Preload::Closure(closure),
                None => Preload::Spring,
            },
        }
    }

    fn growth(&self) -> Growth<f64> {
        let [axial, radial, ball] = self.growth;
        Growth {
            axial,
            radial,
            ball,
        }
    }
}

impl SetRow {
    fn solved(self, name: String) -> SolvedSet {
        let (expect, rows) = (self.expect, self.rows);
        let supports = rows.iter().map(|row| row.support);
        let shaft = self.shaft.map(|shaft| shaft.shaft(supports));
        let balls = expect.rows.iter().flat_map(|row| &row.balls);
        SolvedSet {
            name,
            plan: Plan {
                arrangement: arrangement(&self.layout),
                spring: self.spring_force,
                shaft,
                ..Plan::of(rows.iter().map(MountedRow::row).collect())
            },
            attitude: self.attitude,
            question: Question {
                growth: rows.iter().map(MountedRow::growth).collect(),
                ends: self.nose.map(ShaftEnd::rigid).into_iter().collect(),
                ..Question::load(self.load, rad_per_s(self.speed_rpm))
            },
            truth: Equilibrium {
                displacement: expect.u,
                stiffness: expect.stiffness,
                balls: balls.copied().collect(),
            },
            spring_closure: expect.spring_offset,
            rows: expect.rows,
            nose: expect.nose,
        }
    }
}

/// The solved sets on rigid shafts.
///
/// # Panics
///
/// If the file is not there or is not what it should be.
pub fn sets() -> Vec<SolvedSet> {
    solved_sets(SETS, "set")
}

/// The solved sets on elastic shafts.
///
/// # Panics
///
/// If the file is not there or is not what it should be.
pub fn elastic() -> Vec<SolvedSet> {
    solved_sets(ELASTIC, "elastic")
}

fn solved_sets(path: &str, kind: &str) -> Vec<SolvedSet> {
    let numbered = read::<SetRow>(path).into_iter().enumerate();
    let solved = numbered.map(|(number, set)| {
        let name = format!("{kind} {number} ({})", set.layout);
        set.solved(name)
    });
    solved.collect()
}

/// Axial, radial (N/m) and tilting (N m/rad) stiffness that holds an outer ring; none is rigid.
type SupportRow = [Option<f64>; 3];

/// An elastic shaft, rigid outside its sections, each from, to, outer and inner diameter.
#[derive(Deserialize)]
struct ElasticRow {
    youngs_modulus: f64,
    poissons_ratio: f64,
    sections: Vec<[f64; 4]>,
}

impl ElasticRow {
    fn shaft(self, supports: impl Iterator<Item = SupportRow>) -> ElasticShaft {
        let section = |[from, to, outer, inner]: [f64; 4]| Section {
            from,
            to,
            outer,
            inner,
        };
        let supports = supports.map(|row| {
            let [axial, radial, tilting] = row.map(|k| k.unwrap_or(f64::INFINITY));
            Support {
                axial,
                radial,
                tilting,
            }
        });
        let sections = self.sections.into_iter().map(section);
        ElasticShaft {
            material: Material {
                youngs_modulus: self.youngs_modulus,
                poissons_ratio: self.poissons_ratio,
                ..Material::STEEL
            },
            ..ElasticShaft::of(sections.collect(), supports.collect())
        }
    }
}

/// Displacement and flexibility of the shaft at a nose.
#[derive(Debug, Clone, Deserialize)]
pub struct SolvedNose {
    /// Displacement, m and rad.
    #[serde(rename = "u")]
    pub displacement: [f64; 5],
    /// Displacement by force and moment.
    #[serde(rename = "C")]
    pub flexibility: [[f64; 5]; 5],
}

impl Case {
    /// A random case: 7 to 30 balls of 3 to 30 mm, steel or ceramic, and every rule of attitude. Loads are
    /// from a ten-thousandth of the static load rating up to it, axial or with radial parts and moments.
    /// It is at rest, or up to 60,000 rpm and `n dm` of two and a half millions (mm, rpm).
    pub fn random(seed: u64) -> Self {
        Self::random_with(seed, None)
    }

    /// A random case with this number of balls, if there is one.
    pub fn random_with(seed: u64, balls: Option<usize>) -> Self {
        let mut r = Random::seeded(seed);
        let drawn = r.between(7.0, 31.0) as usize;
        let balls = balls.unwrap_or(drawn);
        let d = (r.between(3e-3_f64.ln(), 30e-3_f64.ln())).exp();
        let crowding = r.between(0.55, 0.95);
        // Few balls fill no bearing.
        let dm = (d / ((PI / balls as f64).sin() * crowding)).max(3.0 * d);
        let design = Design {
            inner_groove_factor: r.between(0.505, 0.55),
            outer_groove_factor: r.between(0.505, 0.55),
            free_contact: FreeContact::Angle(r.between(10.0, 45.0).to_radians()),
            first_ball: r.zero_or(0.5, -3.0, 3.0),
            ball: if r.chance(0.5) {
                Material::STEEL
            } else {
                Material::SILICON_NITRIDE
            },
            ..Design::angular_contact(d, dm, 0.0)
        };
        let attitude = match r.between(0.0, 10.0) as usize {
            0 | 1 => Attitude::Outer,
            2 | 3 => Attitude::Inner,
            _ => Attitude::Raceless,
        };
        let rpm = r.between(0.0, (2500.0 / dm).min(60_000.0));
        let omega = if r.chance(0.2) { 0.0 } else { rad_per_s(rpm) };
        let rating = 12e6 * balls as f64 * d * d;
        let size = rating * 10f64.powf(r.between(-4.0, -0.3));
        let (radial, moment) = match r.between(0.0, 4.0) as usize {
            0 => (0.0, 0.0),
            1 => (r.between(0.0, 3.0), 0.0),
            2 => (0.0, r.between(0.0, 0.5)),
            _ => (r.between(0.0, 3.0), r.between(0.0, 0.5)),
        };
        let (to, about) = (r.between(0.0, TAU), r.between(0.0, TAU));
        let moment = moment * size * 0.5 * dm;
        Self {
            name: format!("random, seed {seed}"),
            balls,
            design,
            attitude,
            load: [
                size,
                size * radial * to.cos(),
                size * radial * to.sin(),
                moment * about.cos(),
                moment * about.sin(),
            ],
            omega,
        }
    }

    /// Radius that turns a tilt into a length.
    pub fn pitch_radius(&self) -> f64 {
        0.5 * self.design.pitch_diameter
    }

    /// The bearing, prepared by the reference build.
    ///
    /// # Panics
    ///
    /// If it refuses the design.
    pub fn reference(&self) -> Reference {
        reference(&self.design, self.balls)
    }

    /// The case, as the reference build is asked.
    pub fn task(&self) -> Task {
        Task::new(self.load, self.omega, self.attitude)
    }
}

/// A design, prepared by the reference build.
///
/// # Panics
///
/// If it refuses the design.
pub fn reference(design: &Design, balls: usize) -> Reference {
    Reference::new(design, balls).unwrap_or_else(|e| panic!("{design:?}: {e}"))
}
