//! Checksums over every bit of very many answers: what a move or a rename leaves as it is.
//!
//! `golden/net.txt` has them. A change of the solver that may change answers writes new ones, and says by how much the
//! answers differ.

use super::solves::{Answer, Balls, GROWN, PRECISIONS, Question, SKEW, ask, ring_solver};
use cli::random::Random;
use judge::campaign::families::{Family, Trial};
use judge::cases::{B7005C, Case, public, sets};
use rayon::prelude::*;
use solvers::with_solver;
use spindle_bearing::{
    Arrangement, Bearing, Given, Preload, Settings, Solver, Speed, Spindle, SpindleSolver, Status,
};
use spindle_file::plan::Plan;
use std::fmt::Write;
use std::path::Path;

/// Cases of each family of the campaign, 14,000 in all.
const CASES: usize = 14_000 / Family::ALL.len() + 1;
/// Ticks of a warm sequence.
const TICKS: usize = 5000;

/// FNV-1a, of 64 bits.
struct Checksum(u64);

impl Checksum {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn word(&mut self, word: u64) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn numbers<'a>(&mut self, numbers: impl IntoIterator<Item = &'a f64>) {
        for number in numbers {
            self.word(number.to_bits());
        }
    }

    fn text(&mut self, text: &str) {
        for byte in text.bytes() {
            self.word(byte.into());
        }
    }

    fn status(&mut self, status: &Status<f32>) {
        self.text(&format!("{status:?}"));
    }

    fn balls(&mut self, balls: &[spindle_bearing::BallState<f64>]) {
        for b in balls {
            self.numbers(&[b.azimuth, b.alpha_i, b.alpha_o, b.q_i, b.q_o]);
            self.numbers(&[
                b.delta_i,
                b.delta_o,
                b.centrifugal_force,
                b.gyroscopic_moment,
            ]);
        }
    }

    fn set(&mut self, answer: &Result<Answer, Status<f32>>) {
        let answer = match answer {
            Ok(answer) => answer,
            Err(status) => return self.status(status),
        };
        self.text(answer.status.name());
        self.word(answer.iterations.into());
        self.numbers(&answer.displacement);
        let at = &answer.at[0];
        for matrix in [&answer.stiffness, &at.compliance, &at.stiffness] {
            self.numbers(matrix.as_flattened());
        }
        self.numbers(&[answer.spring_closure]);
        self.numbers(&answer.error);
        for row in &answer.rows {
            self.numbers(&row.force);
            self.numbers(&[row.preload]);
            self.numbers(row.stiffness.as_flattened());
            let off = u64::from(row.lifted_off);
            self.word(u64::from(row.limits.bits()) << 1 | off << 7 | off);
            self.balls(&row.balls);
            for motion in &row.motions {
                self.numbers(&[motion.cage_speed, motion.rotation, motion.attitude]);
                for patch in [&motion.inner, &motion.outer] {
                    self.numbers(&[patch.peak_pressure, patch.semi_major]);
                    self.numbers(&[patch.semi_minor, patch.spin_to_roll]);
                }
            }
            let f = &row.frequencies;
            self.numbers(&[f.cage, f.outer_race, f.inner_race, f.ball]);
        }
    }

    fn bearing(&mut self, found: &Result<Answer, Status<f32>>) {
        let found = match found {
            Ok(found) => found,
            Err(status) => return self.status(status),
        };
        self.status(&found.status);
        self.numbers(&found.displacement);
        self.numbers(&found.load);
        self.numbers(found.stiffness.as_flattened());
        self.numbers(&found.error);
        self.balls(&found.rows[0].balls);
    }
}

/// One line of the file.
type Line = (String, u64);

fn solved_cases() -> Vec<Line> {
    let scenes = |case: &Case| {
        let mut scenes = vec![Balls::from(case.attitude)];
        scenes.extend((case.omega == 0.0).then_some(Balls::Static));
        scenes
    };
    let line = |precision| {
        let (mut bearings, mut shafts) = (Checksum::new(), Checksum::new());
        for solved in public() {
            let case = &solved.case;
            let plan = Plan::alone(&case.design, case.balls);
            for balls in scenes(case) {
                let question = Question::load(case.load, case.omega).at(0.0);
                bearings.set(&ask(&plan, balls, precision, &question));
            }
        }
        for set in sets() {
            let question = set.question.clone().at(-0.05);
            shafts.set(&ask(&set.plan, set.attitude.into(), precision, &question));
        }
        [
            (format!("solved bearings {precision:?}"), bearings.0),
            (format!("solved sets {precision:?}"), shafts.0),
        ]
    };
    PRECISIONS.into_par_iter().flat_map_iter(line).collect()
}

/// Cases of the campaign, by family and precision.
fn campaign() -> Vec<Line> {
    let kinds: Vec<_> = Family::ALL
        .into_iter()
        .flat_map(|family| PRECISIONS.map(|precision| (family, precision)))
        .collect();
    let line = |(family, precision): (Family, _)| {
        let sum = |index| {
            let trial = Trial::new(7, family, index);
            let plan = Plan::alone(&trial.case.design, trial.case.balls);
            let balls = match trial.at_rest {
                true => Balls::Static,
                false => Balls::from(trial.case.attitude),
            };
            let mut sum = Checksum::new();
            let solved = with_solver(&plan, balls, precision, |solver| {
                for tick in &trial.ticks {
                    sum.set(&solver.load(tick.load, tick.omega));
                }
            });
            solved.unwrap();
            sum.0
        };
        let sums: Vec<_> = (0..CASES / family.ticks())
            .into_par_iter()
            .map(sum)
            .collect();
        let mut all = Checksum::new();
        sums.into_iter().for_each(|sum| all.word(sum));
        (format!("{} {precision:?}", family.name()), all.0)
    };
    kinds.into_par_iter().map(line).collect()
}

/// Scenes of one bearing: all motions of the balls and all freedoms, loads and displacements, growth.
fn scenes() -> Vec<Line> {
    let motions = [
        Balls::Static,
        Balls::Centrifugal,
        Balls::CentrifugalOuter,
        Balls::Free,
        Balls::Outer,
        Balls::Inner,
    ];
    let line = |balls: Balls| {
        let mut sum = Checksum::new();
        for (n, seed) in [5, 8, 16, 33].into_iter().zip(1..) {
            for precision in PRECISIONS {
                for freedoms in [1, 3, 5] {
                    let case = Case::random_with(seed, Some(n));
                    let mut solver = ring_solver(&case.design, n, precision, balls, freedoms);
                    let mut ask = |question: &Question| sum.bearing(&solver.solve(question));
                    let question = Question::load(case.load, case.omega);
                    ask(&question);
                    ask(&question.clone().grown(GROWN));
                    let u = [1e-5, 2e-6, -1e-6, 1e-4, 0.0];
                    let held = [true, false, true, false, true];
                    ask(&Question::load(case.load, 0.5 * case.omega).holding(held, u));
                }
            }
        }
        (format!("scenes {balls:?}"), sum.0)
    };
    motions.into_par_iter().map(line).collect()
}

/// Loads and speeds of a warm sequence: they drift, and now and then they jump.
fn ticks() -> impl Iterator<Item = ([f64; 5], f64, bool)> {
    let mut r = Random::seeded(58);
    let (mut load, mut rpm) = (SKEW, 20_000.0);
    (0..TICKS).map(move |_| {
        let jumps = r.chance(0.02);
        let range = if jumps { 1.5 } else { 0.02 };
        for x in &mut load {
            *x *= 1.0 + r.between(-range, range);
        }
        if r.chance(0.01) {
            load = SKEW.map(|x| x * r.log_between(0.01, 5.0));
        }
        rpm = r.between(rpm - 50.0, rpm + 50.0).clamp(5_000.0, 30_000.0);
        if r.chance(0.005) {
            rpm = r.zero_or(0.3, 5_000.0, 30_000.0);
        }
        (load, rpm, r.chance(0.002))
    })
}

/// Hashes the figures that every solution has, of a bearing or of a set.
macro_rules! figures {
    ($sum:expr, $solution:expr) => {{
        let s = $solution;
        $sum.text(s.status.name());
        $sum.word(s.iterations.into());
        let vectors = s.displacement.iter().chain(&s.load);
        let error = [s.error.displacement, s.error.force, s.error.stiffness];
        for x in vectors.chain(s.stiffness().as_flattened()).chain(&error) {
            $sum.numbers([&f64::from(*x)]);
        }
    }};
}

fn warm_bearings() -> Vec<Line> {
    let single = Bearing::<f32, 15>::new(&B7005C).unwrap();
    let double = Bearing::<f64, 15>::new(&B7005C).unwrap();
    let (mut narrow, mut wide) = (Checksum::new(), Checksum::new());
    let (mut solver, mut precise) = (Solver::new(), Solver::new());
    for (load, rpm, reset) in ticks() {
        if reset {
            solver.reset();
            precise.reset();
        }
        let given = load.map(|x| Given::Load(x as f32));
        let speed = Speed::rpm(rpm as f32);
        match solver.solve(&single, given, speed, &Settings::TICK) {
            Ok(solution) => figures!(narrow, solution),
            Err(status) => {
                narrow.status(&status);
                if let Some(reached) = solver.unfinished(&single) {
                    figures!(narrow, reached);
                }
            }
        }
        match precise.solve(&double, load, Speed::rpm(rpm), &Settings::default()) {
            Ok(solution) => figures!(wide, solution),
            Err(status) => wide.text(status.name()),
        }
    }
    vec![
        ("warm bearing F32".into(), narrow.0),
        ("warm bearing F64".into(), wide.0),
    ]
}

fn warm_pair() -> Vec<Line> {
    let bearing = Bearing::<f32, 15>::new(&B7005C).unwrap();
    let (arrangement, preload) = (Arrangement::BackToBack, Preload::Force(200.0));
    let pair = Spindle::pair(arrangement, &bearing, 0.1, preload).unwrap();
    let (mut sum, mut solver) = (Checksum::new(), SpindleSolver::new());
    for (load, rpm, reset) in ticks() {
        if reset {
            solver.reset();
        }
        let load = load.map(|x| x as f32);
        match solver.solve(&pair, load, Speed::rpm(rpm as f32), &Settings::TICK) {
            Ok(solution) => figures!(sum, solution),
            Err(status) => {
                sum.status(&status);
                if let Some(reached) = solver.unfinished(&pair) {
                    figures!(sum, reached);
                }
            }
        }
    }
    vec![("warm pair F32".into(), sum.0)]
}

#[test]
fn answers_have_the_bits_of_the_file() {
    let parts = [solved_cases, scenes, campaign, warm_bearings, warm_pair];
    let lines: Vec<_> = parts.into_par_iter().flat_map_iter(|part| part()).collect();
    let mut found = String::new();
    for (name, sum) in lines {
        writeln!(found, "{sum:016x} {name}").unwrap();
    }
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (file, new) = (
        here.join("golden/net.txt"),
        here.join("../../target/net.txt"),
    );
    let kept = std::fs::read_to_string(&file).unwrap_or_default();
    if found == kept {
        return;
    }
    std::fs::write(&new, &found).unwrap();
    let changed: Vec<_> = found.lines().filter(|line| !kept.contains(line)).collect();
    panic!(
        "answers have other bits: {changed:#?}\nIf they may: cp {} {}",
        new.display(),
        file.display()
    );
}
