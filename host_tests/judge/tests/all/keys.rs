//! Every key of a bearing's and a spindle's file, from text to number: against the library in SI units, and closed forms.

use super::solves::{Answer, Balls, ask};
use judge::cases::SKF6205;
use judge::compare::worse;
use solvers::dispatch::Precision;
use solvers::with_solver;
use spindle_bearing::{
    Arrangement, Bearing, Design, Facing, FreeContact, Growth, LifeRating, Limit, Material,
    Mounted, Preload, Settings, Shaft, Speed, Spindle, SpindleSolution, SpindleSolver, Support,
};
use spindle_file::designs::{DesignFile, SHIPPED};
use spindle_file::loads::LoadRow;
use spindle_file::plan::ShaftEnd;
use spindle_file::spindles::SpindleFile;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;

const DESIGN: &str = "\
name = \"b\"
balls = 16
ball_diameter_mm = 6.35
pitch_diameter_mm = 36
inner_groove_factor = 0.515
outer_groove_factor = 0.525
contact_angle_deg = 15
dynamic_load_rating_n = 14000
first_ball_deg = 4
inner_shoulder_deg = 48
outer_shoulder_deg = 47.5
bore_mm = 25
outside_mm = 47
";
const MATERIALS: &str = "\
ring = { youngs_modulus_gpa = 206, poissons_ratio = 0.3 }
ball = { youngs_modulus_gpa = 310, poissons_ratio = 0.26, density_kg_m3 = 3200 }
";
const LOADS: &str = "\
[load]
position_mm = -50
[[constant_load]]
position_mm = 120
fx_n = 5
fy_n = -30
fz_n = 12
";
const TOP: &str = "\
name = \"s\"
arrangement = \"back-to-back\"
";
const ROWS: &str = "\
[[row]]
bearing = \"b7005c.toml\"
position_mm = 10
facing = \"+x\"
preload_offset_um = 6
axial_growth_um = 0.5
radial_growth_um = 1
ball_growth_um = 0.25
[[row]]
bearing = \"b7005c.toml\"
position_mm = 110
facing = \"-x\"
preload_offset_um = 4
";
const SHAFT: &str = "\
[shaft]
bore_mm = 10
[heat]
reference_c = 20
shaft_per_k = 12e-6
housing_per_k = 23e-6
ring_per_k = 11e-6
ball_per_k = 4e-6
";
const NOSES: &str = "\
[nose]
position_mm = -40
radial_um_per_kn = 2
axial_um_per_kn = 0.5
";

fn bearing() -> String {
    format!("{DESIGN}{MATERIALS}{LOADS}")
}

fn spindle() -> String {
    format!("{TOP}{ROWS}{SHAFT}{LOADS}{NOSES}")
}

const LOAD: [f64; 5] = [160.0, 90.0, -40.0, 0.5, 1.0];
const RPM: f64 = 12_000.0;
const WARM: [f64; 2] = [32.0, 27.0];

/// Figures by kind.
type Figures = Vec<Vec<f64>>;

fn solved(file: &SpindleFile, load: [f64; 5], speed_rpm: f64) -> Answer {
    let row = LoadRow {
        time_s: 0.0,
        load,
        speed_rpm,
        temperatures: file.heat.map(|_| WARM),
        probes: [None; 4],
    };
    let answer = ask(
        &file.plan,
        Balls::Free,
        Precision::F64,
        &file.question(&row),
    );
    answer.unwrap_or_else(|e| panic!("{e}"))
}

fn parsed(text: &str) -> SpindleFile {
    let folder = Path::new(SHIPPED);
    let file = match text.contains("[[row]]") {
        true => SpindleFile::parse("s.toml", text, folder),
        false => DesignFile::parse("b.toml", text).map(SpindleFile::from),
    };
    file.unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Figures of a file: motion and stiffness at `x = 0`, compliance at the nose, forces, closures, weight of the life.
fn of_text(text: &str) -> Figures {
    let file = parsed(text);
    let answer = solved(&file, LOAD, RPM);
    let mut figures = vec![
        answer.displacement.to_vec(),
        answer.stiffness.as_flattened().to_vec(),
    ];
    figures.extend(
        answer
            .at
            .iter()
            .map(|at| at.compliance.as_flattened().to_vec()),
    );
    for (row, rating) in answer.rows.iter().zip(file.ratings()) {
        let forces = row.balls.iter().map(|ball| (ball.q_i, ball.q_o));
        figures.push(row.force.to_vec());
        figures.push(vec![row.closure]);
        figures.push(vec![rating.weight_of(forces)]);
    }
    figures
}

/// Figures of the library, in SI units.
fn of_library<const R: usize, const D: usize, const E: usize>(
    solution: &SpindleSolution<'_, f64, R, 16, spindle_bearing::RacewayControlFree, D, E>,
    closures: [f64; R],
    nose: Option<ShaftEnd>,
    ratings: [LifeRating<f64>; R],
) -> Figures {
    let mut figures = vec![
        solution.displacement.to_vec(),
        solution.stiffness().as_flattened().to_vec(),
    ];
    if let Some(nose) = nose {
        let mut compliance = solution.compliance_at(nose.position);
        for (i, by) in nose.flexibility.into_iter().enumerate() {
            compliance[i][i] += by;
        }
        figures.push(compliance.as_flattened().to_vec());
    }
    for ((row, closure), rating) in solution.rows().zip(closures).zip(ratings) {
        let forces = row.balls().map(|ball| (ball.q_i, ball.q_o));
        figures.push(row.force.to_vec());
        figures.push(vec![closure]);
        figures.push(vec![rating.weight_of(forces)]);
    }
    figures
}

/// The bearing of the text above.
#[derive(Clone, Copy)]
struct Alone {
    balls: usize,
    design: Design,
    rating: f64,
    loads: Loads,
}

#[derive(Clone, Copy)]
struct Loads {
    at: f64,
    constant_at: f64,
    constant: [f64; 3],
}

const OF_LOADS: Loads = Loads {
    at: -0.05,
    constant_at: 0.12,
    constant: [5.0, -30.0, 12.0],
};

impl Loads {
    /// Force and moment about `x = 0`.
    fn about_origin(&self) -> [f64; 5] {
        let ([fx, fy, fz, my, mz], [cx, cy, cz]) = (LOAD, self.constant);
        [
            fx + cx,
            fy + cy,
            fz + cz,
            my - self.at * fz - self.constant_at * cz,
            mz + self.at * fy + self.constant_at * cy,
        ]
    }
}

const RING: Material = Material {
    youngs_modulus: 206e9,
    poissons_ratio: 0.3,
    density: 7800.0,
};

fn alone() -> Alone {
    Alone {
        balls: 16,
        design: Design {
            ball_diameter: 0.00635,
            pitch_diameter: 0.036,
            inner_groove_factor: 0.515,
            outer_groove_factor: 0.525,
            free_contact: FreeContact::Angle(PI / 12.0),
            inner_shoulder_angle: 48.0 * PI / 180.0,
            outer_shoulder_angle: 47.5 * PI / 180.0,
            first_ball: PI / 45.0,
            ring: RING,
            ball: Material {
                youngs_modulus: 310e9,
                poissons_ratio: 0.26,
                density: 3200.0,
            },
        },
        rating: 14e3,
        loads: OF_LOADS,
    }
}

impl Alone {
    fn figures(&self) -> Figures {
        match self.balls {
            15 => self.of_balls::<15>(),
            _ => self.of_balls::<16>(),
        }
    }

    fn of_balls<const N: usize>(&self) -> Figures {
        let bearing = Bearing::<f64, N>::new(&self.design).unwrap();
        let row = Mounted::<f64, 16>::new(&bearing, 0.0, Facing::PlusX);
        let spindle = Spindle::new(Arrangement::ByRows, [row]).unwrap();
        let mut solver = SpindleSolver::new();
        let load = self.loads.about_origin();
        let solution = solver.solve(&spindle, load, Speed::rpm(RPM), &Settings::default());
        let rating = LifeRating::<f64>::new(&self.design, N, self.rating);
        of_library(&solution.unwrap(), [0.0], None, [rating])
    }
}

/// The spindle of the text above.
#[derive(Clone, Copy)]
struct Pair {
    arrangement: Arrangement,
    facings: [Facing; 2],
    designs: [Design; 2],
    balls: [usize; 2],
    positions: [f64; 2],
    closures: [f64; 2],
    preload: Option<f64>,
    support: Option<Support<f64>>,
    growth: Growth<f64>,
    bore: f64,
    reference: f64,
    /// Of shaft, housing, rings and balls.
    expansion: [f64; 4],
    loads: Loads,
    nose: f64,
    flexibility: [f64; 2],
}

const B7005C: Design = Design {
    inner_shoulder_angle: 48.0 * PI / 180.0,
    outer_shoulder_angle: 47.5 * PI / 180.0,
    ..Design::angular_contact(0.00635, 0.036, PI / 12.0)
};

fn pair() -> Pair {
    Pair {
        arrangement: Arrangement::BackToBack,
        facings: [Facing::PlusX, Facing::MinusX],
        designs: [B7005C; 2],
        balls: [16; 2],
        positions: [0.01, 0.11],
        closures: [6e-6, 4e-6],
        preload: None,
        support: None,
        growth: Growth {
            axial: 0.5e-6,
            radial: 1e-6,
            ball: 0.25e-6,
        },
        bore: 0.01,
        reference: 20.0,
        expansion: [12e-6, 23e-6, 11e-6, 4e-6],
        loads: OF_LOADS,
        nose: -0.04,
        flexibility: [2e-9, 0.5e-9],
    }
}

impl Pair {
    /// Growth of a row: the file's own, of heat with lengths from `x = 0` on, and of rotation.
    fn grown(&self, row: usize) -> Growth<f64> {
        let Design {
            ball_diameter: d,
            pitch_diameter: dm,
            free_contact,
            ring,
            ..
        } = self.designs[row];
        let cos = match free_contact {
            FreeContact::Angle(angle) => angle.cos(),
            FreeContact::DiametralClearance(pd) => 1.0 - pd / (2.0 * 0.04 * d),
        };
        let [inner, outer] = [0.5 * (dm - d * cos), 0.5 * (dm + d * cos)];
        let [ti, to] = WARM.map(|t| t - self.reference);
        let [shaft, housing, rings, balls] = self.expansion;
        let (omega, nu, a) = (RPM * PI / 30.0, ring.poissons_ratio, 0.5 * self.bore);
        let disc = (3.0 + nu) * a * a + (1.0 - nu) * inner * inner;
        let disc = ring.density * omega * omega * inner / (4.0 * ring.youngs_modulus) * disc;
        let sign = [1.0, -1.0][usize::from(self.facings[row] == Facing::MinusX)];
        let own = if row == 0 { self.growth } else { Growth::NONE };
        Growth {
            axial: own.axial + sign * self.positions[row] * (shaft * ti - housing * to),
            radial: own.radial + rings * (ti * inner - to * outer) + disc,
            ball: own.ball + balls * 0.5 * (ti + to) * d,
        }
    }

    fn figures(&self) -> Figures {
        let [first, second] = [0, self.balls[1] / 16].map(|i| self.designs[i]);
        let [first, second] = [first, second].map(|d| Bearing::<f64, 16>::new(&d).unwrap());
        let other = Bearing::<f64, 9>::new(&SKF6205).unwrap();
        let mounted = |i: usize| {
            let (x, facing) = (self.positions[i], self.facings[i]);
            let row = match (i, self.balls[i]) {
                (0, _) => Mounted::<f64, 16>::new(&first, x, facing),
                (_, 9) => Mounted::<f64, 16>::new(&other, x, facing),
                _ => Mounted::<f64, 16>::new(&second, x, facing),
            };
            row.with(match self.preload {
                Some(force) => Preload::Force(force),
                None => Preload::Closure(self.closures[i]),
            })
        };
        let spindle = Spindle::new(self.arrangement, [mounted(0), mounted(1)]).unwrap();
        let closures = [0, 1].map(|row| spindle.closures().nth(row).unwrap());
        let growth = [self.grown(0), self.grown(1)];
        let mut nose = ShaftEnd::rigid(self.nose);
        let [radial, axial] = self.flexibility;
        nose.flexibility[..3].copy_from_slice(&[axial, radial, radial]);
        let ratings = [0, 1].map(|i| {
            let (design, balls) = (&self.designs[i], self.balls[i]);
            LifeRating::<f64>::new(design, balls, design.dynamic_load_rating(balls))
        });
        let (load, at) = (
            self.loads.about_origin(),
            Speed::rpm(RPM).with_growth(growth),
        );
        let settings = Settings::default();
        match self.support {
            None => {
                let mut solver = SpindleSolver::new();
                let solution = solver.solve(&spindle, load, at, &settings).unwrap();
                of_library(&solution, closures, Some(nose), ratings)
            }
            // The shaft is rigid: loads may act where they stand, or be referred.
            Some(support) => {
                let shaft = Shaft::<f64, 2>::new(&[], &Material::STEEL).unwrap();
                let spindle = spindle.elastic(&shaft, [support, Support::RIGID]).unwrap();
                let mut solver = SpindleSolver::new();
                let solution = solver.solve(&spindle, load, at, &settings).unwrap();
                of_library(&solution, closures, Some(nose), ratings)
            }
        }
    }
}

/// Largest difference of figures, over the largest of their kind.
fn apart(found: &Figures, truth: &Figures) -> f64 {
    assert_eq!(found.len(), truth.len());
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, worse);
    let kinds = found.iter().zip(truth).map(|(found, truth)| {
        assert_eq!(found.len(), truth.len());
        let off = largest(&mut found.iter().zip(truth).map(|(a, b)| a - b));
        let size = largest(&mut truth.iter().copied());
        if off == 0.0 { 0.0 } else { off / size }
    });
    kinds.fold(0.0, worse)
}

/// A key, the text that another one takes the place of, and its meaning in SI units.
type Said<S> = (&'static str, &'static str, &'static str, fn(&mut S));

#[rustfmt::skip]
const BEARINGS: [Said<Alone>; 22] = [
    ("balls", "balls = 16", "balls = 15", |b| b.balls = 15),
    ("ball_diameter_mm", "= 6.35", "= 6", |b| b.design.ball_diameter = 0.006),
    ("pitch_diameter_mm", "= 36", "= 37", |b| b.design.pitch_diameter = 0.037),
    ("inner_groove_factor", "= 0.515", "= 0.52", |b| b.design.inner_groove_factor = 0.52),
    ("outer_groove_factor", "= 0.525", "= 0.53", |b| b.design.outer_groove_factor = 0.53),
    ("inner_groove_radius_mm", "inner_groove_factor = 0.515", "inner_groove_radius_mm = 3.302", |b| b.design.inner_groove_factor = 0.52),
    ("outer_groove_radius_mm", "outer_groove_factor = 0.525", "outer_groove_radius_mm = 3.302", |b| b.design.outer_groove_factor = 0.52),
    ("contact_angle_deg", "= 15", "= 18", |b| b.design.free_contact = FreeContact::Angle(PI / 10.0)),
    ("diametral_clearance_um", "contact_angle_deg = 15", "diametral_clearance_um = 12",
        |b| b.design.free_contact = FreeContact::DiametralClearance(12e-6)),
    ("dynamic_load_rating_n", "= 14000", "= 15000", |b| b.rating = 15e3),
    ("first_ball_deg", "= 4", "= 9", |b| b.design.first_ball = PI / 20.0),
    ("ring.youngs_modulus_gpa", "= 206", "= 190", |b| b.design.ring.youngs_modulus = 190e9),
    ("ring.poissons_ratio", "= 0.3 ", "= 0.2 ", |b| b.design.ring.poissons_ratio = 0.2),
    ("ball.youngs_modulus_gpa", "= 310", "= 206", |b| b.design.ball.youngs_modulus = 206e9),
    ("ball.poissons_ratio", "= 0.26", "= 0.3", |b| b.design.ball.poissons_ratio = 0.3),
    ("ball.density_kg_m3", "= 3200", "= 7800", |b| b.design.ball.density = 7800.0),
    ("load.position_mm", "= -50", "= -30", |b| b.loads.at = -0.03),
    ("constant_load.position_mm", "= 120", "= 20", |b| b.loads.constant_at = 0.02),
    ("constant_load.fx_n", "fx_n = 5", "fx_n = 25", |b| b.loads.constant[0] = 25.0),
    ("constant_load.fy_n", "= -30", "= 10", |b| b.loads.constant[1] = 10.0),
    ("constant_load.fz_n", "fz_n = 12", "fz_n = -7", |b| b.loads.constant[2] = -7.0),
    ("", "", "", |_| ()),
];

#[test]
fn keys_of_bearings_mean_what_the_library_is_told_in_si_units() {
    let base = of_text(&bearing());
    for (key, from, to, set) in BEARINGS {
        let text = bearing();
        assert!(text.contains(from), "{key}");
        let found = of_text(&text.replacen(from, to, 1));
        let mut said = alone();
        set(&mut said);
        let off = apart(&found, &said.figures());
        assert!(off < 1e-9, "{key}: {off:e}");
        assert!(
            key.is_empty() || apart(&found, &base) > 1e-4,
            "{key} does nothing"
        );
    }
}

#[rustfmt::skip]
const SPINDLES: [Said<Pair>; 32] = [
    ("preload_n", "arrangement", "preload_n = 200\narrangement", |s| s.preload = Some(200.0)),
    ("row.bearing", "bearing = \"b7005c.toml\"\nposition_mm = 110", "bearing = \"skf6205.toml\"\nposition_mm = 110",
        |s| (s.designs[1], s.balls[1]) = (SKF6205, 9)),
    ("row.design", "bearing = \"b7005c.toml\"\nposition_mm = 10\n",
        "design = { name = \"b\", balls = 16, ball_diameter_mm = 6, pitch_diameter_mm = 36, inner_groove_factor = 0.515, \
         outer_groove_factor = 0.525, contact_angle_deg = 15 }\nposition_mm = 10\n",
        |s| s.designs[0] = Design::angular_contact(0.006, 0.036, PI / 12.0)),
    ("row.ball.youngs_modulus_gpa", "position_mm = 110", "ball = { youngs_modulus_gpa = 310 }\nposition_mm = 110",
        |s| s.designs[1].ball.youngs_modulus = 310e9),
    ("row.ball.poissons_ratio", "position_mm = 110", "ball = { poissons_ratio = 0.26 }\nposition_mm = 110",
        |s| s.designs[1].ball.poissons_ratio = 0.26),
    ("row.ball.density_kg_m3", "position_mm = 110", "ball = { density_kg_m3 = 3200 }\nposition_mm = 110",
        |s| s.designs[1].ball.density = 3200.0),
    ("row.position_mm", "position_mm = 110", "position_mm = 90", |s| s.positions[1] = 0.09),
    ("row.facing", "facing = \"+x\"", "facing = \"-x\"", |s| s.facings = [Facing::MinusX, Facing::PlusX]),
    ("row.preload_offset_um", "_um = 6", "_um = 9", |s| s.closures[0] = 9e-6),
    ("row.axial_growth_um", "_um = 0.5", "_um = 2", |s| s.growth.axial = 2e-6),
    ("row.radial_growth_um", "radial_growth_um = 1", "radial_growth_um = 3", |s| s.growth.radial = 3e-6),
    ("row.ball_growth_um", "_um = 0.25", "_um = 1", |s| s.growth.ball = 1e-6),
    ("row.support.axial_n_per_um", "facing", "support = { axial_n_per_um = 50 }\nfacing",
        |s| s.support = Some(Support { axial: 50e6, ..Support::RIGID })),
    ("row.support.radial_n_per_um", "facing", "support = { radial_n_per_um = 60 }\nfacing",
        |s| s.support = Some(Support { radial: 60e6, ..Support::RIGID })),
    ("row.support.tilting_nm_per_rad", "facing", "support = { tilting_nm_per_rad = 5e3 }\nfacing",
        |s| s.support = Some(Support { tilting: 5e3, ..Support::RIGID })),
    ("shaft.bore_mm", "bore_mm = 10", "bore_mm = 20", |s| s.bore = 0.02),
    ("heat.reference_c", "= 20", "= 15", |s| s.reference = 15.0),
    ("heat.shaft_per_k", "= 12e-6", "= 20e-6", |s| s.expansion[0] = 20e-6),
    ("heat.housing_per_k", "= 23e-6", "= 10e-6", |s| s.expansion[1] = 10e-6),
    ("heat.ring_per_k", "= 11e-6", "= 30e-6", |s| s.expansion[2] = 30e-6),
    ("heat.ball_per_k", "= 4e-6", "= 12e-6", |s| s.expansion[3] = 12e-6),
    ("load.position_mm", "= -50", "= -30", |s| s.loads.at = -0.03),
    ("constant_load.position_mm", "= 120", "= 20", |s| s.loads.constant_at = 0.02),
    ("constant_load.fx_n", "fx_n = 5", "fx_n = 25", |s| s.loads.constant[0] = 25.0),
    ("constant_load.fy_n", "= -30", "= 10", |s| s.loads.constant[1] = 10.0),
    ("constant_load.fz_n", "fz_n = 12", "fz_n = -7", |s| s.loads.constant[2] = -7.0),
    ("nose.position_mm", "= -40", "= -45", |s| s.nose = -0.045),
    ("nose.radial_um_per_kn", "= 2\n", "= 5\n", |s| s.flexibility[0] = 5e-9),
    ("nose.axial_um_per_kn", "axial_um_per_kn = 0.5", "axial_um_per_kn = 5", |s| s.flexibility[1] = 5e-9),
    ("nose.tool", "[nose]", "[nose.tool]", |_| ()),
    ("arrangement", "back-to-back", "face-to-face", |s| s.arrangement = Arrangement::FaceToFace),
    ("", "", "", |_| ()),
];

#[test]
fn keys_of_spindles_mean_what_the_library_is_told_in_si_units() {
    let base = of_text(&spindle());
    for (key, from, to, set) in SPINDLES {
        let text = spindle();
        assert!(text.contains(from), "{key}");
        let mut text = text.replacen(from, to, 1);
        let mut said = pair();
        // Keys that do not stand together, or that stand for two rows.
        match key {
            "preload_n" => {
                text = text
                    .replace("preload_offset_um = 6\n", "")
                    .replace("preload_offset_um = 4\n", "");
            }
            "row.facing" => {
                text = text.replace("110\nfacing = \"-x\"", "110\nfacing = \"+x\"");
                text = text.replace("back-to-back", "face-to-face");
                said.arrangement = Arrangement::FaceToFace;
            }
            "arrangement" => {
                let refused = SpindleFile::parse("s.toml", &text, Path::new(SHIPPED)).unwrap();
                let solver = with_solver(&refused.plan, Balls::Static, Precision::F64, |_| ());
                assert!(solver.unwrap_err().to_string().contains("not face-to-face"));
                continue;
            }
            _ => {}
        }
        set(&mut said);
        let off = apart(&of_text(&text), &said.figures());
        assert!(off < 1e-9, "{key}: {off:e}");
        let is_said = key.is_empty() || key == "nose.tool";
        assert!(
            is_said || apart(&of_text(&text), &base) > 1e-5,
            "{key} does nothing"
        );
    }
}

/// Two rows that a closure presses, at rest and without load, at 10 and 110 mm; `more` is of the first one.
fn pressed(more: &str, rest: &str) -> String {
    let row = |x, facing, more: &str| {
        format!(
            "[[row]]\nbearing = \"b7005c.toml\"\nposition_mm = {x}\nfacing = \"{facing}\"\n{more}\n"
        )
    };
    let rows = row(10, "+x", more) + &row(110, "-x", more);
    format!("{TOP}{rows}{rest}")
}

/// A hollow section in front of the bearings, in m and Pa.
#[derive(Clone, Copy)]
struct Overhang {
    from: f64,
    to: f64,
    outer: f64,
    inner: f64,
    e: f64,
    nu: f64,
}

impl Overhang {
    /// Axial and lateral displacement of the nose at -40 mm per force there: a Timoshenko beam with Cowper's factor.
    fn flexibility(&self) -> [f64; 2] {
        let Self {
            from,
            to,
            outer,
            inner,
            e,
            nu,
        } = *self;
        let area = PI / 4.0 * (outer * outer - inner * inner);
        let second = PI / 64.0 * (outer.powi(4) - inner.powi(4));
        let m = inner / outer;
        let square = (1.0 + m * m).powi(2);
        let kappa =
            6.0 * (1.0 + nu) * square / ((7.0 + 6.0 * nu) * square + (20.0 + 12.0 * nu) * m * m);
        let [near, far] = [from + 0.04, to + 0.04];
        let bending = (far.powi(3) - near.powi(3)) / (3.0 * e * second);
        let shear = (to - from) * 2.0 * (1.0 + nu) / (kappa * e * area);
        [(to - from) / (e * area), bending + shear]
    }
}

#[rustfmt::skip]
const SECTIONS: [Said<Overhang>; 7] = [
    ("sections.from_mm", "= -40, ", "= -25, ", |s| s.from = -0.025),
    ("sections.to_mm", "to_mm = 5", "to_mm = -10", |s| s.to = -0.01),
    ("sections.outer_mm", "= 25", "= 28", |s| s.outer = 0.028),
    ("sections.inner_mm", "= 8", "= 12", |s| s.inner = 0.012),
    ("youngs_modulus_gpa", "= 210", "= 100", |s| s.e = 100e9),
    ("poissons_ratio", "= 0.28", "= 0.35", |s| s.nu = 0.35),
    ("", "", "", |_| ()),
];

#[test]
fn keys_of_sections_mean_a_beam() {
    let nose = "[nose]\nposition_mm = -40\n";
    let shaft = "[shaft]\nyoungs_modulus_gpa = 210\npoissons_ratio = 0.28\n\
        sections = [{ from_mm = -40, to_mm = 5, outer_mm = 25, inner_mm = 8 }]\n";
    let compliance = |shaft: &str| {
        let file = parsed(&pressed("preload_offset_um = 5", &format!("{shaft}{nose}")));
        let compliance = solved(&file, [0.0; 5], 0.0).at[0].compliance;
        [compliance[0][0], compliance[1][1], compliance[2][2]]
    };
    let rigid = compliance("");
    for (key, from, to, set) in SECTIONS {
        assert!(shaft.contains(from), "{key}");
        let mut said = Overhang {
            from: -0.04,
            to: 0.005,
            outer: 0.025,
            inner: 0.008,
            e: 210e9,
            nu: 0.28,
        };
        set(&mut said);
        let [axial, lateral] = said.flexibility();
        let found = compliance(&shaft.replacen(from, to, 1));
        for (i, truth) in [axial, lateral, lateral].into_iter().enumerate() {
            let off = (found[i] - rigid[i]) / truth - 1.0;
            assert!(off.abs() < 1e-7, "{key}, {i}: {off:e}");
        }
    }
}

/// `grow_with_speed` takes the bore of the section: a disc of Timoshenko and Goodier.
#[test]
fn rings_grow_on_the_bores_of_their_sections() {
    let sections = "[shaft]\ngrow_with_speed = true\n\
        sections = [{ from_mm = 0, to_mm = 120, outer_mm = 25, inner_mm = 15 }]\n";
    let file = parsed(&pressed("", sections));
    let row = LoadRow {
        time_s: 0.0,
        load: LOAD,
        speed_rpm: RPM,
        temperatures: None,
        probes: [None; 4],
    };
    let truth = Pair {
        bore: 0.015,
        expansion: [0.0; 4],
        growth: Growth::NONE,
        ..pair()
    }
    .grown(1)
    .radial;
    for growth in file.question(&row).growth {
        assert!(
            (growth.radial / truth - 1.0).abs() < 1e-12,
            "{growth:?} {truth:e}"
        );
    }
}

/// Preloads of the rows at rest, without load.
fn preloads(text: &str) -> Vec<f64> {
    let rows = solved(&parsed(text), [0.0; 5], 0.0).rows;
    rows.iter().map(|row| row.preload).collect()
}

#[test]
fn forces_of_preload_are_those_of_the_file() {
    let near = |found: &[f64], truth: f64| {
        let off = found.iter().map(|found| (found / truth - 1.0).abs());
        assert!(off.fold(0.0, worse) < 1e-6, "{found:?}, not {truth}");
    };
    let soft = "support = { axial_n_per_um = 30 }";
    let with =
        |key: &str, text: String| text.replacen("arrangement", &format!("{key}\narrangement"), 1);
    near(&preloads(&with("preload_n = 200", pressed("", ""))), 200.0);
    near(
        &preloads(&with("mounted_preload_n = 200", pressed("", ""))),
        200.0,
    );
    let ground = preloads(&with("preload_n = 200", pressed(soft, "")));
    assert!(ground[0] < 150.0, "{ground:?}");
    near(
        &preloads(&with("mounted_preload_n = 200", pressed(soft, ""))),
        200.0,
    );
    // Loads of the file and growth with speed do not count, a shaft and a press fit do.
    let shaft = "[shaft]\nsections = [{ from_mm = 0, to_mm = 120, outer_mm = 12 }]\n";
    let fitted = |load| {
        with(
            "mounted_preload_n = 200",
            pressed(
                &format!("{soft}\nradial_growth_um = 2"),
                &format!("{shaft}{load}"),
            ),
        )
    };
    near(&preloads(&fitted("")), 200.0);
    let closures = |text: &str| {
        solved(&parsed(text), [0.0; 5], 0.0)
            .rows
            .iter()
            .map(|row| row.closure)
            .collect::<Vec<_>>()
    };
    let [plain, loaded] =
        ["", "[[constant_load]]\nposition_mm = 0\nfx_n = 50\n"].map(|load| closures(&fitted(load)));
    assert!(
        plain == loaded && plain[0] == plain[1],
        "{plain:?} {loaded:?}"
    );
    let sprung = pressed("", "[spring]\nforce_n = 250\n")
        .replace("facing = \"-x\"", "facing = \"-x\"\nspring = true");
    near(&preloads(&sprung), 250.0);
}

/// A shoulder is passed by a contact angle that is a hundredth of a degree larger.
#[test]
fn shoulders_are_where_the_file_says() {
    let text = bearing();
    let free = text.replace("= 48", "= 89").replace("= 47.5", "= 89");
    let passes = |text: &str| {
        let rows = solved(&parsed(text), LOAD, RPM).rows;
        rows[0].limits.contains(Limit::Shoulder)
    };
    assert!(!passes(&free));
    let balls = &solved(&parsed(&free), LOAD, RPM).rows[0].balls;
    let largest = |of: fn(&spindle_bearing::BallState<f64>) -> f64| {
        balls
            .iter()
            .filter(|ball| ball.q_i > 0.0)
            .map(of)
            .fold(0.0, f64::max)
            .to_degrees()
    };
    let keys = [
        (
            "inner_shoulder_deg = 89",
            "inner_shoulder_deg",
            largest(|ball| ball.alpha_i),
        ),
        (
            "outer_shoulder_deg = 89",
            "outer_shoulder_deg",
            largest(|ball| ball.alpha_o),
        ),
    ];
    for (from, key, angle) in keys {
        for (off, is_passed) in [(-0.01, true), (0.01, false)] {
            let text = free.replace(from, &format!("{key} = {}", angle + off));
            assert_eq!(passes(&text), is_passed, "{key} {angle} {off}");
        }
    }
}

/// Where a shaft does not fit the bearing, that is told; and the diameters are the catalogue's.
#[test]
fn a_shaft_that_does_not_fit_the_bearing_is_told() {
    let file = DesignFile::parse("b.toml", &bearing()).unwrap();
    assert_eq!(file.size_mm, [Some(25.0), Some(47.0)]);
    let doubts = |shaft: &str| {
        let text = pressed("", &format!("[shaft]\n{shaft}\n"));
        parsed(&text.replacen("arrangement", "preload_n = 200\narrangement", 1)).doubts
    };
    let section =
        |outer: f64| format!("sections = [{{ from_mm = 0, to_mm = 120, outer_mm = {outer} }}]");
    let nothing: [String; 3] = ["bore_mm = 19".into(), section(20.5), section(31.0)];
    for shaft in nothing {
        assert_eq!(doubts(&shaft), [""; 0], "{shaft}");
    }
    assert_eq!(doubts("bore_mm = 25").len(), 1);
    for outer in [19.0, 32.0] {
        let told = doubts(&section(outer));
        let wanted = format!(
            ": `outer_mm` of the section at row 0 is {outer}, and the bore of its bearing 25: is it the diameter?"
        );
        assert!(told.len() == 1 && told[0].ends_with(&wanted), "{told:?}");
    }
    let listed = "[[row]]\nbearing = \"gmn:S6014C\"\nposition_mm = 0\nfacing = \"+x\"\n[shaft]\nbore_mm = 70\n";
    assert_eq!(
        parsed(&format!("{TOP}{listed}").replace("arrangement = \"back-to-back\"\n", ""))
            .doubts
            .len(),
        1
    );
}

const PROBE: &str = "\
[[probe]]
name = \"ax\"
position_mm = -10
direction = \"x\"
[[probe]]
name = \"up\"
position_mm = 25.5
angle_deg = 120
accuracy_um = 0.1
";

#[test]
fn a_probe_may_be_at_a_free_channel_of_the_converter() {
    const BRIDGES: &str = include_str!("../../../../examples/spindle_file/spindles/bridges.toml");
    let folder = Path::new(SHIPPED).join("../spindles");
    let read = |text: &str, channels: [&str; 2]| {
        let [ax, up] = channels;
        let probes = PROBE.replacen("accuracy_um = 0.1", up, 1).replacen(
            "direction = \"x\"",
            &format!("direction = \"x\"\n{ax}"),
            1,
        );
        SpindleFile::parse("s.toml", &format!("{text}\n{probes}"), &folder)
    };
    let [six, seven] = [
        "channel = 6\num_per_count = 1e-3",
        "channel = 7\num_per_count = -2e-3",
    ];
    let file = read(BRIDGES, [six, seven]).unwrap_or_else(|e| panic!("{e}"));
    let channels: Vec<_> = file.probes.iter().map(|probe| probe.channel).collect();
    assert_eq!(channels, [Some((6, 1e-3)), Some((7, -2e-3))]);
    let records = BRIDGES.split("[monitor]").next().unwrap();
    for (text, channels, told) in [
        (
            BRIDGES,
            [six, six],
            "channel 6 of the converter is not free",
        ),
        (
            BRIDGES,
            [six, "channel = 5\num_per_count = 1"],
            "channel 5 of the converter is not free",
        ),
        (
            BRIDGES,
            [six, "channel = 8\num_per_count = 1"],
            "channel 8 of the converter is not free",
        ),
        (
            records,
            [six, seven],
            "channel 6 of the converter is not free",
        ),
        (
            BRIDGES,
            [six, ""],
            "probes are all at the board's converter",
        ),
        (
            BRIDGES,
            [six, "channel = 7"],
            "such as `um_per_count = 1e-3`",
        ),
        (BRIDGES, [six, "um_per_count = 1"], "such as `channel = 7`"),
        (
            BRIDGES,
            [six, "channel = 7\num_per_count = 0"],
            "`um_per_count` must not be 0",
        ),
    ] {
        let error = read(text, channels).unwrap_err().to_string();
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn a_probe_sees_its_direction_at_its_position() {
    let file = parsed(&format!("{}{PROBE}", spindle()));
    let [ax, up] = &file.probes[..] else {
        panic!("{:?}", file.probes);
    };
    assert_eq!((&*ax.name, ax.position, ax.accuracy), ("ax", -0.01, 0.5));
    assert_eq!((&*up.name, up.position, up.accuracy), ("up", 0.0255, 0.1));
    let u = [1e-6, 2e-6, 3e-6, 0.1, 0.1];
    assert_eq!(ax.sees(&u), 1.0);
    assert!((up.sees(&u) - (1.5 * 3_f64.sqrt() - 1.0)).abs() < 1e-9);
    let row = LoadRow {
        time_s: 0.0,
        load: LOAD,
        speed_rpm: RPM,
        temperatures: Some(WARM),
        probes: [None; 4],
    };
    let ends = file.question_at_probes(&row).ends;
    assert_eq!(ends, [-0.01, 0.0255].map(ShaftEnd::rigid));
    for (from, to, line, told) in [
        ("\"up\"", "\"ax\"", 6, "another probe is called \"ax\""),
        ("\"up\"", "\"a b\"", 6, "the name of a probe has letters"),
        ("= 120", "= nan", 8, "`angle_deg` is nan"),
        (
            "angle_deg = 120",
            "direction = \"y\"",
            8,
            "`direction` is \"x\"",
        ),
        ("angle_deg = 120\n", "", 5, "add a line such as `direction"),
        ("= 120", "= 120\ndirection = \"x\"", 8, "remove one of them"),
        ("= 0.1", "= 0", 9, "must be above 0"),
        ("position_mm = 25.5\n", "", 5, "`position_mm = -10`"),
        ("name = \"up\"\n", "", 5, "`name = \"nose\"`"),
        (
            "[[probe]]\nname = \"up\"",
            "[[probe]]\n[[probe]]\n[[probe]]\n[[probe]]\nname = \"up\"",
            5,
            "this probe lacks a key",
        ),
    ] {
        let probes = PROBE.replacen(from, to, 1);
        let text = format!("{TOP}{probes}{ROWS}");
        let error = SpindleFile::parse("s.toml", &text, Path::new(SHIPPED)).unwrap_err();
        assert!(error.message.contains(told), "{from}: {error}");
        let place = error.place.map(|place| place.line);
        assert_eq!(place, Some(line + TOP.lines().count()), "{from}: {error}");
    }
}

/// Keys of tables, by the name of the table: `serde` lists them where a key is unknown.
fn keys_of(table: &str, text: &str) -> BTreeSet<String> {
    let error = match table.starts_with("bearing") {
        true => DesignFile::parse("b.toml", text).map(|_| ()),
        false => SpindleFile::parse("s.toml", text, Path::new(SHIPPED)).map(|_| ()),
    };
    let message = error.unwrap_err().message;
    let (unknown, expected) = message.split_once(", expected ").expect("a list of keys");
    assert_eq!(unknown, "unknown field `unknown`", "{table}");
    let keys = expected.split('`').skip(1).step_by(2);
    keys.map(|key| format!("{table}.{key}")).collect()
}

#[rustfmt::skip]
const TABLES: [(&str, &str); 18] = [
    ("bearing", "unknown = 0"),
    ("bearing.ring", "[ring]\nunknown = 0"),
    ("bearing.ball", "[ball]\nunknown = 0"),
    ("bearing.load", "[load]\nunknown = 0"),
    ("bearing.constant_load", "[[constant_load]]\nunknown = 0"),
    ("spindle", "unknown = 0"),
    ("spindle.row", "[[row]]\nunknown = 0"),
    ("spindle.row.design", "[[row]]\n[row.design]\nunknown = 0"),
    ("spindle.row.ball", "[[row]]\nball = { unknown = 0 }"),
    ("spindle.row.support", "[[row]]\nsupport = { unknown = 0 }"),
    ("spindle.spring", "[spring]\nunknown = 0"),
    ("spindle.shaft", "[shaft]\nunknown = 0"),
    ("spindle.shaft.sections", "[shaft]\nsections = [{ unknown = 0 }]"),
    ("spindle.heat", "[heat]\nunknown = 0"),
    ("spindle.load", "[load]\nunknown = 0"),
    ("spindle.constant_load", "[[constant_load]]\nunknown = 0"),
    ("spindle.nose", "[nose.tool]\nunknown = 0"),
    ("spindle.probe", "[[probe]]\nunknown = 0"),
];

/// Keys of the other tests here, of `monitor_keys.rs` and of `wrong_files.rs`. A name is a text.
const OTHERS: [&str; 22] = [
    "bearing.name",
    "bearing.inner_shoulder_deg",
    "bearing.outer_shoulder_deg",
    "bearing.bore_mm",
    "bearing.outside_mm",
    "bearing.monitor",
    "spindle.name",
    "spindle.mounted_preload_n",
    "spindle.row.spring",
    "spindle.spring.force_n",
    "spindle.shaft.grow_with_speed",
    "spindle.preload_n",
    "spindle.row.preload_offset_um",
    "spindle.heat.accuracy_k",
    "spindle.monitor",
    "spindle.probe.name",
    "spindle.probe.position_mm",
    "spindle.probe.direction",
    "spindle.probe.angle_deg",
    "spindle.probe.accuracy_um",
    "spindle.probe.channel",
    "spindle.probe.um_per_count",
];

#[test]
fn every_key_has_its_test() {
    let mut tested: BTreeSet<String> = OTHERS.map(str::to_owned).into();
    tested.extend(BEARINGS.map(|(key, ..)| format!("bearing.{key}")));
    tested.extend(SPINDLES.map(|(key, ..)| format!("spindle.{key}")));
    tested.extend(SECTIONS.map(|(key, ..)| format!("spindle.shaft.{key}")));
    let is_table = |key: &String| TABLES.iter().any(|(table, _)| table == key);
    for (table, text) in TABLES {
        let keys = keys_of(table, text);
        if table == "spindle.row.design" {
            let own = keys_of("bearing", TABLES[0].1).len();
            assert_eq!(keys.len(), own);
            continue;
        }
        for key in keys.iter().filter(|key| !is_table(key)) {
            assert!(tested.contains(key), "{key} has no test");
        }
    }
}
