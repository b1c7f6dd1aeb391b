//! Spindles in use: a file, the spindle that it is taken for, and the displacement at the probes of both.

use crate::preload::What;
use cli::random::Random;
use spindle_bearing::{Growth, Preload, Settings, Speed};
use spindle_file::loads::LoadRow;
use spindle_file::mounting::{DynSolver, DynSpindle, Parts, closed, growths, preload};
use spindle_file::plan::{MOST_ROWS, Plan};
use spindle_file::spindles::SpindleFile;
use spindle_monitor::ResponseSettings;
use spindle_monitor::alarms::{Alarm, Threshold};
use spindle_monitor::preload::{PreloadBy, PreloadLaw};
use spindle_monitor::tick::Core;
use std::array::from_fn;
use std::f64::consts::TAU;
use std::path::Path;

/// Probes of a spindle: an axial one, and a radial one.
pub const PROBES: usize = 2;
/// Their place, m.
const PLACE: f64 = -0.01;
/// Angle of the radial one, from +y towards +z, degrees.
const ANGLE: f64 = 30.0;
/// Tools.
const TOOLS: usize = 16;
/// Speeds, rpm. At 1 kHz none of them stands still.
pub const SPEEDS: [f64; 5] = [6300.0, 9300.0, 11_700.0, 14_300.0, 17_700.0];
/// Depths of a cut, over the one that its tool's forces are for.
const DEPTHS: [f64; 2] = [0.36, 1.43];
/// A moment counts as a force so far away, m.
pub const ARM: f64 = 0.05;
/// Wander of temperatures, K, and the time that it takes, s.
const WANDER: f64 = 0.1;
const WANDERS: f64 = 600.0;

/// Nodes over the depths.
const OF_DEPTH: usize = 5;
/// Nodes over the two thirds power of the preload of the file: the least, the step, and how many.
const OF_PRELOAD: (f64, f64, usize) = (0.2, 0.07, 32);

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/firmware");

/// A spindle of the campaign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The one that the firmware is shipped for.
    Shipped,
    /// Two S 6005 C on a shaft that bends.
    Elastic,
    /// The shipped rows face to face.
    FaceToFace,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Shipped, Self::Elastic, Self::FaceToFace];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Shipped => "shipped",
            Self::Elastic => "elastic pair",
            Self::FaceToFace => "face to face",
        }
    }

    fn text(self) -> String {
        let shipped = std::fs::read_to_string(format!("{FOLDER}/spindle.toml"));
        let shipped = shipped.expect("the shipped spindle is there");
        let probes = format!(
            "\n[[probe]]\nname = \"axial\"\nposition_mm = {x}\ndirection = \"x\"\naccuracy_um = 0.2\n\
             [[probe]]\nname = \"radial\"\nposition_mm = {x}\nangle_deg = {ANGLE}\naccuracy_um = 0.2\n",
            x = 1e3 * PLACE
        );
        let text = match self {
            Self::Shipped => shipped,
            Self::FaceToFace => {
                let turned = shipped.replace("\"+x\"", "\"other\"").replace("\"-x\"", "\"+x\"");
                let turned = turned.replace("\"other\"", "\"-x\"");
                turned.replace("back-to-back", "face-to-face")
            }
            Self::Elastic => "name = \"pair of S 6005 C\"\narrangement = \"back-to-back\"\nmounted_preload_n = 250\n\
                [[row]]\nbearing = \"gmn:S6005C\"\nposition_mm = 20\nfacing = \"+x\"\n\
                support = { axial_n_per_um = 300, radial_n_per_um = 300 }\n\
                [[row]]\nbearing = \"gmn:S6005C\"\nposition_mm = 90\nfacing = \"-x\"\n\
                support = { axial_n_per_um = 300, radial_n_per_um = 300 }\n\
                [shaft]\ngrow_with_speed = true\n\
                sections = [ { from_mm = -12, to_mm = 12, outer_mm = 34, inner_mm = 8 }, { from_mm = 12, to_mm = 110, outer_mm = 25, inner_mm = 8 } ]\n\
                [heat]\nreference_c = 20\n[nose]\nposition_mm = -12\n"
                .to_owned(),
        };
        text + &probes
    }
}

/// A file of the campaign, as a monitor takes it.
#[derive(Debug)]
pub struct Filed {
    /// Which.
    pub kind: Kind,
    /// The file.
    pub file: SpindleFile,
    /// Settings of the estimates.
    pub settings: &'static ResponseSettings<PROBES>,
    /// Limits of the alarms.
    pub limits: [Threshold; Alarm::COUNT],
}

impl Filed {
    /// The file of a spindle. It stays in memory until the program ends, as the board's does.
    pub fn of(kind: Kind) -> Self {
        let file = SpindleFile::parse(kind.name(), &kind.text(), Path::new(FOLDER));
        let file = file.unwrap_or_else(|error| panic!("{error}"));
        let settings = preload::response::<PROBES>(&file).unwrap_or_else(|error| panic!("{error}"));
        let limits = file.settings(&Core::STM32F405).alarms;
        let settings = Box::leak(Box::new(settings));
        Self {
            kind,
            file,
            settings,
            limits,
        }
    }

    /// The law of its preload.
    pub fn law(&self) -> &PreloadLaw {
        self.settings
            .preload
            .as_ref()
            .expect("rows oppose each other")
    }
}

/// What a spindle in use is, besides its file.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Preload as it was mounted, over the file's.
    pub preload: f64,
    /// Measured loads over loads.
    pub cells: [[f64; 5]; 5],
    /// Gain of each probe.
    pub gains: [f64; PROBES],
    /// Angle of the radial probe besides the file's, rad.
    pub angle: f64,
    /// Stiffness of the supports of each row over the file's: axial, radial, tilting.
    pub supports: [[f64; 3]; 2],
    /// Errors of both temperatures, K.
    pub kelvin: [f64; 2],
    /// Forces of each tool, N, and how far in front of the nose it is, m.
    pub tools: [([f64; 3], f64); TOOLS],
}

impl Drawn {
    /// All of it drawn.
    pub fn of(random: &mut Random) -> Self {
        let mut within = |most: f64| random.between(-most, most);
        let preload = 1.0 + within(0.3);
        let cells = from_fn(|i| {
            from_fn(|j| {
                if i == j {
                    1.0 + within(0.03)
                } else {
                    within(0.02)
                }
            })
        });
        let gains = from_fn(|_| 1.0 + within(0.1));
        let angle = within(20_f64.to_radians());
        let kelvin = from_fn(|_| within(0.5));
        let supports = from_fn(|_| from_fn(|_| random.log_between(0.7, 1.5)));
        let tools = from_fn(|_| {
            let (radial, turn) = (random.between(60.0, 300.0), random.between(0.0, TAU));
            let axial = random.between(0.0, 200.0);
            let place = random.between(0.02, 0.08);
            ([axial, radial * turn.cos(), radial * turn.sin()], place)
        });
        Self {
            preload,
            cells,
            gains,
            angle,
            supports,
            kelvin,
            tools,
        }
    }

    /// Has the load cells measure what there is.
    pub fn set_cells_right(&mut self) {
        self.cells = from_fn(|i| from_fn(|j| if i == j { 1.0 } else { 0.0 }));
    }

    /// Loads of a cut.
    fn load(&self, cut: Cut) -> [f64; 5] {
        let ([x, y, z], place) = self.tools[cut.tool];
        [x, y, z, place * z, -place * y].map(|load| cut.depth * load)
    }

    /// Loads of a cut as the cells measure them.
    fn measured(&self, cut: Cut) -> [f64; 5] {
        let (load, unit) = (self.load(cut), [1.0, 1.0, 1.0, ARM, ARM]);
        from_fn(|i| {
            let row = self.cells[i].iter().zip(load).zip(unit);
            unit[i]
                * row
                    .map(|((cell, load), unit)| cell * load / unit)
                    .sum::<f64>()
        })
    }
}

/// A cut: which tool, at which speed, and how deep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cut {
    /// Index of the tool.
    pub tool: usize,
    /// Index of the speed.
    pub speed: usize,
    /// Depth.
    pub depth: f64,
}

impl Cut {
    /// Any cut.
    pub fn of(random: &mut Random) -> Self {
        Self {
            tool: random.below(TOOLS),
            speed: random.below(SPEEDS.len()),
            depth: random.between(DEPTHS[0], DEPTHS[1]),
        }
    }
}

/// Displacement where the probes are, less that of the idling spindle, um, and its slope by ln preload: of each tool, speed and depth, over
/// the preload. A node is solved when it is wanted.
pub struct Table {
    file: SpindleFile,
    plan: Plan,
    spindle: &'static DynSpindle<'static, f64>,
    law: PreloadLaw,
    loads: [[f64; 5]; TOOLS],
    /// The closure of the front row is gone.
    gone: bool,
    solver: DynSolver<f64>,
    /// Over preload, speed, and tools and depths, of which the last is idling.
    nodes: Vec<Option<[f64; 6]>>,
}

impl Table {
    /// That of the file, for loads as the cells measure them.
    pub fn of_file(filed: &Filed, drawn: &Drawn) -> Self {
        let plan = closed(&filed.file.plan).expect("its rows are closed");
        let load = |cut| drawn.measured(cut);
        Self::new(filed.file.clone(), plan, *filed.law(), false, load)
    }

    /// That of the spindle that is taken for this file, about the preload as mounted. Its front support has this radial stiffness over the
    /// drawn one.
    pub fn of_truth(filed: &Filed, drawn: &Drawn, front: f64, gone: bool) -> Self {
        let mut file = filed.file.clone();
        let plan = &mut file.plan;
        for row in &mut plan.rows {
            if let Preload::Force(force) = &mut row.preload {
                *force *= drawn.preload;
            }
        }
        if let Some((force, _)) = &mut plan.mounted_preload {
            *force *= drawn.preload;
        }
        let supports = plan.shaft.iter_mut().flat_map(|shaft| &mut shaft.supports);
        for (support, by) in supports.zip(drawn.supports) {
            support.axial *= by[0];
            support.radial *= by[1];
            support.tilting *= by[2];
        }
        let mut plan = closed(&file.plan).expect("its rows are closed");
        let law = preload::response::<PROBES>(&file).map(|settings| settings.preload);
        let law = law.expect("it has a law").expect("rows oppose each other");
        // What is mounted stays so when a support gives way.
        if let Some(shaft) = &mut plan.shaft {
            shaft.supports[0].radial *= front;
        }
        Self::new(file, plan, law, gone, |cut| drawn.load(cut))
    }

    /// It stays until the program ends, as a board's spindle does.
    fn new(
        file: SpindleFile,
        plan: Plan,
        law: PreloadLaw,
        gone: bool,
        load: impl Fn(Cut) -> [f64; 5],
    ) -> Self {
        let parts = Box::leak(Box::new(Parts::<f64>::of(&plan).expect("it can be built")));
        let spindle = parts.spindle(&plan).expect("it can be built");
        let (_, _, count) = OF_PRELOAD;
        Self {
            file,
            plan,
            spindle: Box::leak(Box::new(spindle)),
            law,
            loads: from_fn(|tool| {
                load(Cut {
                    tool,
                    speed: 0,
                    depth: 1.0,
                })
            }),
            gone,
            solver: DynSolver::new(),
            nodes: vec![None; count * SPEEDS.len() * (TOOLS * OF_DEPTH + 1)],
        }
    }

    /// Displacement at this ln preload, and its slope.
    pub fn at(&mut self, cut: Cut, ln: f64) -> [f64; 6] {
        let (from, step, count) = OF_PRELOAD;
        let power = (ln / 1.5).exp();
        let (first, of_preload) = weights((power - from) / step, count);
        let deepest = (DEPTHS[1] - DEPTHS[0]) / (OF_DEPTH - 1) as f64;
        let (column, of_depth) = weights((cut.depth - DEPTHS[0]) / deepest, OF_DEPTH);
        let mut sum = [0.0; 6];
        for (i, a) in (first..).zip(of_preload) {
            let idle = self.node(i, cut.speed, TOOLS * OF_DEPTH);
            for (j, b) in (column..).zip(of_depth) {
                let node = self.node(i, cut.speed, cut.tool * OF_DEPTH + j);
                sum = from_fn(|k| sum[k] + a * b * (node[k] - idle[k]));
            }
        }
        sum
    }

    fn node(&mut self, of_preload: usize, speed: usize, cut: usize) -> [f64; 6] {
        let index = (of_preload * SPEEDS.len() + speed) * (TOOLS * OF_DEPTH + 1) + cut;
        if let Some(node) = self.nodes[index] {
            return node;
        }
        let (from, step, _) = OF_PRELOAD;
        let ln = 1.5 * (from + step * of_preload as f64).ln();
        let part = (cut % OF_DEPTH) as f64 / (OF_DEPTH - 1) as f64;
        let depth = DEPTHS[0] + part * (DEPTHS[1] - DEPTHS[0]);
        let load = self
            .loads
            .get(cut / OF_DEPTH)
            .map_or([0.0; 5], |load| load.map(|load| depth * load));
        let node = self.solve(ln, load, SPEEDS[speed]);
        self.nodes[index] = Some(node);
        node
    }

    fn solve(&mut self, ln: f64, load: [f64; 5], speed_rpm: f64) -> [f64; 6] {
        let [closure, slope] = self.law.closure(ln as f32).map(f64::from);
        let question = self.file.question(&LoadRow {
            time_s: 0.0,
            load,
            speed_rpm,
            temperatures: None,
            probes: [None; 4],
        });
        let mut grown: [Growth<f64>; MOST_ROWS] = growths(&question.growth);
        for (row, grown) in grown.iter_mut().enumerate().take(self.plan.rows.len()) {
            grown.axial += closure;
            if self.gone && row == 0 {
                grown.axial -= self.spindle.closures().next().unwrap_or_default();
            }
        }
        let at = Speed::rad_per_s(question.omega).with_growth(grown);
        let solution = self
            .solver
            .solve(self.spindle, question.load, at, &Settings::DEFAULT);
        let Ok(solution) = solution else {
            return [f64::NAN; 6];
        };
        let place = PLACE - self.plan.loaded_at();
        let u = solution.displacement_at(place);
        let clamped = from_fn(|row| if self.law.clamps(row) { slope } else { 0.0 });
        let by = solution.by_closures(clamped).displacement_at(place);
        from_fn(|i| 1e6 * if i < 3 { u[i] } else { by[i - 3] })
    }

    /// Change of ln preload by a K on the inner and on the outer side.
    fn per_kelvin(&self, ln: f64) -> [f64; 2] {
        let [_, slope] = self.law.closure(ln as f32);
        match self.law.by {
            PreloadBy::Closure { heat, .. } => heat.map(|heat| f64::from(heat / slope)),
            PreloadBy::Spring => [0.0; 2],
        }
    }
}

/// The first of four nodes, and the weight of each, at a place between nodes.
fn weights(place: f64, count: usize) -> (usize, [f64; 4]) {
    let first = (place.floor() as isize - 1).clamp(0, count as isize - 4) as usize;
    let x = place - first as f64;
    let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
    let weights = [
        -b * c * d / 6.0,
        a * c * d / 2.0,
        -a * b * d / 2.0,
        a * b * c / 6.0,
    ];
    (first, weights)
}

/// Tables of a draw: of its file, of the spindle, and of what has become of that.
pub struct Tables {
    file: Table,
    truth: Table,
    soft: Option<Table>,
    gone: Option<Table>,
}

impl Tables {
    /// Those of a draw, without a node.
    pub fn of(filed: &Filed, drawn: &Drawn) -> Self {
        Self {
            file: Table::of_file(filed, drawn),
            truth: Table::of_truth(filed, drawn, 1.0, false),
            soft: None,
            gone: None,
        }
    }
}

/// A spindle in use.
pub struct Used<'u> {
    /// Its file.
    pub filed: &'u Filed,
    /// What it is besides.
    pub drawn: &'u Drawn,
    tables: &'u mut Tables,
    /// What has changed.
    what: What,
    /// Wander of both temperatures, K.
    wander: [f64; 2],
}

impl<'u> Used<'u> {
    /// A sound spindle.
    pub fn new(filed: &'u Filed, drawn: &'u Drawn, tables: &'u mut Tables) -> Self {
        Self {
            filed,
            drawn,
            tables,
            what: What::Nothing,
            wander: [0.0; 2],
        }
    }

    /// Changes at once.
    pub fn change(&mut self, what: What) {
        self.what = what;
        let (filed, drawn) = (self.filed, self.drawn);
        match what {
            What::Front(part) => {
                self.tables
                    .soft
                    .get_or_insert_with(|| Table::of_truth(filed, drawn, part, false));
            }
            What::RowGone => {
                self.tables
                    .gone
                    .get_or_insert_with(|| Table::of_truth(filed, drawn, 1.0, true));
            }
            _ => {}
        }
    }

    /// Lets the temperatures wander for a time, s.
    pub fn wander(&mut self, random: &mut Random, time: f64) {
        let part = time / WANDERS;
        for wander in &mut self.wander {
            *wander += (2.0 * part).sqrt() * WANDER * normal(random) - *wander * part;
        }
    }

    /// Its preload, N; no number of two rows that differ.
    pub fn preload(&self) -> f64 {
        let change = match self.what {
            What::Preload(part) => part,
            What::RowGone => f64::NAN,
            _ => 1.0,
        };
        f64::from(self.filed.law().force) * self.drawn.preload * change
    }

    /// Motion that each probe measures from idling to a cut, um, but for its noise.
    pub fn measured(&mut self, cut: Cut) -> [f64; PROBES] {
        let tables = &mut *self.tables;
        let (table, ln) = match (self.what, &mut tables.soft, &mut tables.gone) {
            (What::Front(_), Some(soft), _) => (soft, 0.0),
            (What::RowGone, _, Some(gone)) => (gone, 0.0),
            (What::Preload(part), ..) => (&mut tables.truth, part.ln()),
            _ => (&mut tables.truth, 0.0),
        };
        let mut kelvin = self.drawn.kelvin;
        if let What::Kelvin(by) = self.what {
            kelvin[0] += by;
        }
        let warm = table
            .per_kelvin(ln)
            .into_iter()
            .zip(kelvin)
            .zip(self.wander);
        let warm: f64 = warm
            .map(|((per, error), wander)| per * (error + wander))
            .sum();
        let u = table.at(cut, ln + warm);
        from_fn(|i| {
            let by = match self.what {
                What::Gains(by) => by[i],
                _ => 1.0,
            };
            let [along, _] = self.seen(i, &u[..3], self.drawn.angle);
            by * self.drawn.gains[i] * along
        })
    }

    /// The cut that the load cells see.
    fn sensed(&self, cut: Cut) -> Cut {
        match self.what {
            What::Cells(by) => Cut {
                depth: by * cut.depth,
                ..cut
            },
            _ => cut,
        }
    }

    /// Loads of a cut as the cells measure them.
    pub fn load(&self, cut: Cut) -> [f64; 5] {
        self.drawn.measured(self.sensed(cut))
    }

    /// Motion from idling to a cut as a monitor computes it that the solves serve at this ln preload, and at this angle of each probe:
    /// along, across, by ln preload.
    pub fn computed(&mut self, cut: Cut, ln: f64, angles: [f64; PROBES]) -> [[f64; 3]; PROBES] {
        let u = self.tables.file.at(self.sensed(cut), ln);
        from_fn(|i| {
            let [along, across] = self.seen(i, &u[..3], angles[i]);
            let [by_preload, _] = self.seen(i, &u[3..], angles[i]);
            [along, across, by_preload]
        })
    }

    /// A displacement along and across a probe that is turned by this angle.
    fn seen(&self, probe: usize, u: &[f64], angle: f64) -> [f64; 2] {
        let [x, y, z] = self.filed.settings.probes[probe].direction.map(f64::from);
        if x != 0.0 {
            return [x * u[0], 0.0];
        }
        let (sin, cos) = angle.sin_cos();
        let [y, z] = [cos * y - sin * z, cos * z + sin * y];
        [y * u[1] + z * u[2], y * u[2] - z * u[1]]
    }
}

/// A number about 0 with a standard deviation of 1.
pub fn normal(random: &mut Random) -> f64 {
    (-2.0 * random.between(1e-12, 1.0).ln()).sqrt() * random.between(0.0, TAU).cos()
}
