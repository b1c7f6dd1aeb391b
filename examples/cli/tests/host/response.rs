//! Measured over computed displacement, on spindles whose truth is another spindle: runout, drift, noise and errors of gain included.

use cli::import::{Import, Wanted};
use cli::random::Random;
use cli::recordings::Loads;
use cli::telemetry::simulated::MONITOR;
use spindle_bearing::{FreeContact, Preload, Support};
use spindle_file::designs::SHIPPED;
use spindle_file::dispatch::Precision;
use spindle_file::loads::LoadRow;
use spindle_file::plan::{Plan, Question};
use spindle_file::probes::Probe;
use spindle_file::solvers::{Balls, with_solver};
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle::{BALLS, FREEDOMS, JOINTS, ROWS, SPINDLE};
use spindle_monitor::board::ResetCause;
use spindle_monitor::command::{AnswerCode, Request};
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::mock::flash::FailingFlash;
use spindle_monitor::pairs::{Pairs, TickReadings};
use spindle_monitor::response::{ProbeReport, Ratio, Response, State, is_aliased};
use spindle_monitor::telemetry::{FrameReader, Payload, ProbesReport};
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{
    Alarm, Identity, Marks, Monitor, Order, Past, ProbeSettings, Readings, ResponseSettings, Store,
};
use std::f64::consts::TAU;
use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

const FILE: &str = include_str!("../../../firmware/spindle.toml");
/// An axial probe and a radial one, 10 mm in front of the nose.
const PROBES: &str = "
[[probe]]
name = \"axial\"
position_mm = -10
direction = \"x\"
accuracy_um = 0.2
[[probe]]
name = \"nose\"
position_mm = -10
angle_deg = 0
accuracy_um = 0.2
";
/// Load of the cut, 50 mm in front of `x = 0`.
const CUT: [f64; 5] = [-90.0, 270.0, 135.0, 6.75, -13.5];
/// Errors of the load cells' gains.
const CELLS: [f64; 5] = [1.01, 0.99, 1.01, 1.01, 0.99];
/// Errors of the probes' gains.
const GAINS: [f64; 2] = [1.02, 0.98];
/// A tick, s.
const TICK: f64 = 1e-3;

/// The shipped spindle with probes, with a fault.
fn spindle(fault: Fault) -> SpindleFile {
    let (text, folder) = (
        format!("{FILE}{PROBES}"),
        Path::new(SHIPPED).join("../../firmware"),
    );
    let file = SpindleFile::parse("spindle.toml", &text, &folder);
    let mut file = file.unwrap_or_else(|e| panic!("{e}"));
    fault(&mut file.plan);
    file
}

type Fault = fn(&mut Plan);

fn ground(plan: &mut Plan, force: f64) {
    for row in &mut plan.rows {
        row.preload = Preload::Force(force);
    }
}

/// The front row without its closure.
fn loosen(plan: &mut Plan) {
    let closure = with_solver(plan, Balls::Free, Precision::F64, |solver| {
        solver.answer(&Question::default()).rows[1].closure
    });
    plan.rows[0].preload = Preload::Closure(0.0);
    plan.rows[1].preload = Preload::Closure(closure.unwrap_or_else(|e| panic!("{e}")));
}

/// A free contact angle, degrees, with the closure that was ground for the other one.
fn incline(plan: &mut Plan, degrees: f64) {
    let closures = with_solver(plan, Balls::Free, Precision::F64, |solver| {
        let rows = solver.answer(&Question::default()).rows;
        rows.iter().map(|row| row.closure).collect::<Vec<_>>()
    });
    let closures = closures.unwrap_or_else(|e| panic!("{e}"));
    for (row, closure) in plan.rows.iter_mut().zip(closures) {
        row.preload = Preload::Closure(closure);
        row.design.free_contact = FreeContact::Angle(degrees.to_radians());
    }
}

fn support(plan: &mut Plan, row: usize) -> &mut Support<f64> {
    let shaft = plan.shaft.as_mut().expect("an elastic shaft");
    &mut shaft.supports[row]
}

const NONE: Fault = |_| ();
const LOST_20: Fault = |plan| ground(plan, 200.0);
const LOST_5: Fault = |plan| ground(plan, 237.5);
const SOFT: Fault = |plan| support(plan, 0).radial /= 1.5;

/// Faults of the page.
const FAULTS: [(&str, Fault); 11] = [
    ("5 % of the preload lost", LOST_5),
    ("20 %", LOST_20),
    ("40 %", |plan| ground(plan, 150.0)),
    ("99 %", |plan| ground(plan, 2.5)),
    ("front nut loose: the front row's closure gone", loosen),
    ("contact angle 16 deg for 15", |plan| incline(plan, 16.0)),
    ("contact angle 14 deg for 15", |plan| incline(plan, 14.0)),
    ("front support a third softer radially", SOFT),
    ("rear support a third softer radially", |plan| {
        support(plan, 1).radial /= 1.5
    }),
    ("front support a third softer axially", |plan| {
        support(plan, 0).axial /= 1.5
    }),
    ("rear support a third softer axially", |plan| {
        support(plan, 1).axial /= 1.5
    }),
];

/// Displacement at the probes (um) over the share of the cut, from 0 to [`Curve::MOST`].
#[derive(Clone)]
struct Curve(Vec<[f64; 2]>);

impl Curve {
    const MOST: f64 = 2.0;
    const STEPS: usize = 40;

    fn of(file: &SpindleFile, rpm: f64, cut: [f64; 5]) -> Self {
        let points = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
            let shares = (0..=Self::STEPS).map(|i| Self::MOST * i as f64 / Self::STEPS as f64);
            let points = shares.map(|share| {
                let row = LoadRow {
                    time_s: 0.0,
                    load: cut.map(|load| share * load),
                    speed_rpm: rpm,
                    temperatures: Some([20.0; 2]),
                    probes: [None; 4],
                };
                let answer = solver.answer(&file.question_at_probes(&row));
                let seen = |i: usize| {
                    let probe: &Probe = &file.probes[i];
                    probe.sees(&answer.at[i].displacement)
                };
                [seen(0), seen(1)]
            });
            points.collect()
        });
        Self(points.unwrap_or_else(|e| panic!("{e}")))
    }

    fn at(&self, share: f64) -> [f64; 2] {
        let place = (share / Self::MOST * Self::STEPS as f64).clamp(0.0, Self::STEPS as f64 - 1e-9);
        let (i, part) = (place as usize, place.fract());
        std::array::from_fn(|k| self.0[i][k] + part * (self.0[i + 1][k] - self.0[i][k]))
    }
}

/// State of the axial probe.
#[derive(Clone, Copy, PartialEq)]
enum Axial {
    Well,
    /// It repeats its value.
    Frozen,
    /// It gives nothing.
    Absent,
    /// It gives noise.
    CutOff,
    /// With the other one.
    Swapped,
}

/// A spindle in use: half a second of cutting each second.
#[derive(Clone)]
struct Scene {
    /// Before and after the change, as all pairs here.
    rpm: [f64; 2],
    computed: [Curve; 2],
    truth: [Curve; 2],
    /// Time of the change, after which the probe is at fault, too, s.
    change: f64,
    /// Runout at one and at two a revolution, um; drift, um/h; noise, um.
    runout: [f64; 2],
    drift: [f64; 2],
    noise: f64,
    axial: Axial,
    /// Loads of the whole cut, as the cells say.
    cells: [[f64; 5]; 2],
    /// A solve takes 2 or 3 ticks, as on a board.
    is_on_board: bool,
    limit: f32,
    /// Length of the reference, s.
    reference: f64,
}

impl Scene {
    /// A spindle that is another one after the change.
    fn new(rpm: f64, after: Fault) -> Self {
        Self::of([rpm; 2], [CUT; 2], after)
    }

    fn of(rpm: [f64; 2], cut: [[f64; 5]; 2], after: Fault) -> Self {
        let faults = [NONE, after];
        let cells = |i: usize| std::array::from_fn(|k| CELLS[k] * cut[i][k]);
        Self {
            rpm,
            computed: [0, 1].map(|i| Curve::of(&spindle(NONE), rpm[i], cells(i))),
            truth: [0, 1].map(|i| Curve::of(&spindle(faults[i]), rpm[i], cut[i])),
            change: 20.3,
            runout: [3.0; 2],
            drift: [5.0; 2],
            noise: 0.2,
            axial: Axial::Well,
            cells: [0, 1].map(cells),
            is_on_board: false,
            limit: 0.05,
            reference: 10.0,
        }
    }

    /// Without disturbances.
    fn clean(&self) -> Self {
        Self {
            runout: [0.0; 2],
            drift: [0.0; 2],
            noise: 0.0,
            ..self.clone()
        }
    }

    /// Runs for so many seconds; `each` sees the reports after each second, until it says `false`.
    fn run(
        &self,
        seed: u64,
        seconds: usize,
        mut each: impl FnMut(usize, [ProbeReport; 2]) -> bool,
    ) {
        let mut random = Random::seeded(seed);
        let mut response = Response::new([0.2; 2], 1000.0, [self.limit; 2]);
        let phases: [f64; 6] = std::array::from_fn(|_| random.between(0.0, TAU));
        let begin = random.between(0.1, 0.9);
        let mut frozen = [0.0; 2];
        let (mut pairs, mut begun, mut ticks_left) = (Pairs::<2>::default(), None, 0);
        for second in 0..seconds {
            let length = random.between(0.45, 0.55);
            for tick in 0..1000 {
                let part = tick as f64 * TICK;
                let time = second as f64 + part;
                let is_after = time >= self.change;
                let after = usize::from(is_after);
                let rpm = self.rpm[after];
                let turn = time * rpm / 60.0 * TAU;
                let tooth = 1.0 + 0.3 * (4.0 * turn + phases[0]).cos();
                let cuts = (part - begin).rem_euclid(1.0) < length;
                let share = if cuts { tooth } else { 0.0 };
                let cell = share + 0.002 * normal(&mut random);
                let computed = self.computed[after].at(cell).map(|p| p as f32);
                let truth = self.truth[after].at(share);
                let drift = self.drift[after] * time / 3600.0;
                let mut measured: [f64; 2] = std::array::from_fn(|i| {
                    let runout = self.runout[after]
                        * ((turn + phases[1 + i]).cos() + (2.0 * turn + phases[3 + i]).cos());
                    GAINS[i] * truth[i] + runout + drift + self.noise * normal(&mut random) + 40.0
                });
                let mut present = [true; 2];
                match self.axial {
                    _ if !is_after => frozen = measured,
                    Axial::Well => {}
                    Axial::Frozen => measured[0] = frozen[0],
                    Axial::Absent => present[0] = false,
                    Axial::CutOff => measured[0] = self.noise * normal(&mut random),
                    Axial::Swapped => measured.swap(0, 1),
                }
                let measured = [0, 1].map(|i| present[i].then_some(measured[i] as f32));
                let rpm = rpm + 0.5 * normal(&mut random);
                let now = (1000 * second + tick) as u64;
                if self.is_on_board {
                    let load = self.cells[after].map(|load| (cell * load) as f32);
                    if ticks_left == 0 {
                        if let Some((tick, load, computed)) = begun.replace((now, load, computed)) {
                            pairs.solved(tick, &load, computed);
                        }
                        ticks_left = 2 + usize::from(random.between(0.0, 1.0) < 0.5);
                    }
                    ticks_left -= 1;
                    let readings = TickReadings {
                        rpm: Some(rpm as f32),
                        load: Some(load),
                        measured,
                    };
                    pairs.tick(now, readings, &mut response);
                } else {
                    response.tick(Some(rpm as f32), Some(computed), measured);
                }
                if (time + TICK - self.reference).abs() < 0.5 * TICK {
                    let is_aliased = is_aliased(rpm as f32, 1000.0);
                    assert!([0, 1].iter().all(|i| response.refer(*i) != is_aliased));
                }
            }
            if !each(second + 1, response.reports()) {
                return;
            }
        }
    }

    /// Ratios after so many seconds.
    fn ratios(&self, seed: u64, seconds: usize) -> [Ratio; 2] {
        let mut last = None;
        self.run(seed, seconds, |_, reports| {
            last = Some(reports);
            true
        });
        last.expect("a second")
            .map(|report| report.ratio.expect("a load step"))
    }

    /// Engagements after the change until a probe says so, and until then nothing else; none within 30.
    fn until(&self, seed: u64, state: State) -> Option<usize> {
        let (mut found, begin) = (None, self.change as usize);
        self.run(seed, begin + 30, |second, reports| {
            let states = reports.map(|report| report.state);
            if states.contains(&state) && second > begin {
                found = Some(second - begin);
            }
            let others = states
                .iter()
                .find(|one| ![State::Ok, State::Learning, state].contains(one));
            assert!(others.is_none() || second <= begin, "{others:?}");
            found.is_none()
        });
        found
    }

    /// [`Scene::until`], whatever else is said.
    fn first(&self, seed: u64, state: State) -> Option<usize> {
        let (mut found, begin) = (None, self.change as usize);
        self.run(seed, begin + 30, |second, reports| {
            let is_said = reports.iter().any(|report| report.state == state);
            found = (is_said && second > begin).then(|| second - begin);
            found.is_none()
        });
        found
    }

    /// Seconds in which a probe says anything but `ok` and `learning`.
    fn alarms(&self, seed: u64, seconds: usize) -> usize {
        let mut alarms = 0;
        self.run(seed, seconds, |_, reports| {
            let is_well =
                |report: &ProbeReport| [State::Ok, State::Learning].contains(&report.state);
            alarms += usize::from(!reports.iter().all(is_well));
            true
        });
        alarms
    }
}

/// A normal number: the sum of twelve even ones.
fn normal(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(-0.5, 0.5)).sum()
}

/// Readings of the probes `a` and `b`, row by row; none of a row that is refused.
fn readings(csv: &str, import: Option<&str>) -> Result<Vec<Option<Vec<Option<f64>>>>, String> {
    let import = import.map(|text| Import::parse("i.toml", text).map_err(|e| e.to_string()));
    let import = import.transpose()?;
    let wanted = Wanted {
        probes: ["a", "b"].map(str::to_owned).to_vec(),
        ..Wanted::default()
    };
    let input = Box::new(Cursor::new(csv.as_bytes().to_vec()));
    let loads = Loads::from_reader("r.csv", input, import.as_ref(), &wanted);
    let loads = loads.map_err(|e| e.to_string())?;
    let mut rows = Vec::new();
    for row in loads {
        rows.push(row.ok().map(|row| row.probes[..2].to_vec()));
    }
    Ok(rows)
}

#[test]
fn a_recording_has_readings_of_probes() {
    let own = "probe_b_um,time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,probe_a_um\n\
        -1.5,0,1,0,0,0,0,0,2\n,1,1,0,0,0,0,0,3e1\n2,2,1,0,0,0,0,0,far\n";
    let both = [
        Some(vec![Some(2.0), Some(-1.5)]),
        Some(vec![Some(30.0), None]),
        None,
    ];
    assert_eq!(readings(own, None).unwrap(), both);
    let alone = own.replace("probe_b_um", "probe_c_um");
    assert_eq!(
        readings(&alone, None).unwrap()[0],
        Some(vec![Some(2.0), None])
    );
    let described = "header_line = 1\nfirst_row = 2\nseparator = \"semicolon\"\ndecimal = \",\"\n[columns]\n\
        time = { column = 1, unit = \"s\" }\nfx = { column = 2, unit = \"N\" }\nfy = { value = 0, unit = \"N\" }\n\
        fz = { value = 0, unit = \"N\" }\nmy = { value = 0, unit = \"Nm\" }\nmz = { value = 0, unit = \"Nm\" }\n\
        speed = { value = 0, unit = \"rpm\" }\n\
        probe.b = { column = \"s2\", unit = \"mm\" }\nprobe.a = { column = 3, unit = \"um\", factor = -2 }\n";
    let other = "t;F;s1;s2\n0;1;1,5;0,25\n1;1;;0,5\n";
    let both = [
        Some(vec![Some(-3.0), Some(250.0)]),
        Some(vec![None, Some(500.0)]),
    ];
    assert_eq!(readings(other, Some(described)).unwrap(), both);
    for (from, to, told) in [
        (
            "\"mm\"",
            "\"V\"",
            "i.toml: line 13, column 11: `probe.b`: \"V\" is none of the units um, µm, nm, mm, m; others take a factor",
        ),
        ("\"s2\"", "3", "one column for probe.a and probe.b"),
        ("\"s2\"", "\"s3\"", "not the column \"s3\""),
    ] {
        let error = readings(other, Some(&described.replacen(from, to, 1))).unwrap_err();
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn changes_of_the_spindle_are_known_within_three_engagements() {
    let [preload, support] = [LOST_20, SOFT].map(|fault| Scene::new(12_007.0, fault));
    let mut little = Scene::new(12_007.0, LOST_5);
    little.limit = 0.01;
    for seed in 0..10 {
        for (scene, most) in [(&preload, 3), (&support, 3), (&little, 20)] {
            let until = scene.until(seed, State::StiffnessLoss);
            assert!((1..=most).contains(&until.unwrap_or(99)), "{until:?}");
        }
    }
    // More preload than at commissioning.
    let tightened = Scene::new(12_007.0, |plan| ground(plan, 330.0));
    assert!(tightened.until(1, State::StiffnessGain).unwrap_or(99) <= 3);
}

#[test]
fn ratios_are_those_of_the_truth_within_their_errors() {
    for (fault, least) in [(NONE, 0.999), (LOST_20, 1.2)] {
        let scene = Scene::new(12_007.0, fault);
        let truth = scene.clean().ratios(0, 40);
        assert!(truth[0].value > least);
        assert_eq!(
            within(&scene, truth, 40, 40).map(|share| share >= 0.85),
            [true; 2]
        );
        let errors = scene.ratios(1, 40).map(|ratio| ratio.error);
        assert!(errors[0] < 0.007 && errors[1] < 0.0012, "{errors:?}");
    }
}

#[test]
fn solves_of_some_ticks_tell_as_much() {
    let mut scene = Scene::new(12_007.0, LOST_20);
    let truth = scene.clean().ratios(0, 40);
    scene.is_on_board = true;
    let shares = within(&scene, truth, 40, 200);
    println!(
        "{shares:?} {truth:?} {:?}",
        [1, 2, 3].map(|seed| scene.ratios(seed, 40))
    );
    assert!(
        shares.iter().all(|share| (0.93..0.99).contains(share)),
        "{shares:?}"
    );
    let errors = scene.ratios(1, 40).map(|ratio| ratio.error);
    assert!(errors[0] < 0.007 && errors[1] < 0.0012, "{errors:?}");
    let mut support = Scene::new(12_007.0, SOFT);
    support.is_on_board = true;
    for seed in 0..10 {
        for scene in [&scene, &support] {
            let until = scene.until(seed, State::StiffnessLoss);
            assert!((1..=3).contains(&until.unwrap_or(99)), "{until:?}");
        }
    }
    let mut well = Scene::new(12_007.0, NONE);
    well.is_on_board = true;
    assert_eq!(well.alarms(1, 120), 0);
}

static ON_BOARD: ResponseSettings<2> = ResponseSettings {
    probes: [
        ProbeSettings {
            position: -0.01,
            direction: [1.0, 0.0, 0.0],
            accuracy: 0.2,
        },
        ProbeSettings {
            position: -0.01,
            direction: [0.0, 1.0, 0.0],
            accuracy: 0.2,
        },
    ],
};

/// A monitor with probes, its host, and the commands that it gets.
struct Bench {
    monitor: Monitor<ROWS, BALLS, 12, FREEDOMS, JOINTS, 2>,
    reader: FrameReader,
    curve: Curve,
    random: Random,
    answers: Vec<AnswerCode>,
    probes: Option<ProbesReport>,
    raised: Vec<(Alarm, Option<u16>)>,
}

impl Bench {
    fn new(past: &Past) -> Self {
        let monitor = Monitor::with_probes(&SPINDLE, &MONITOR, &ON_BOARD).with_past(past);
        let mut bench = Self {
            monitor,
            reader: FrameReader::new(),
            curve: Curve::of(&spindle(NONE), 12_007.0, CUT),
            random: Random::seeded(1),
            answers: Vec::new(),
            probes: None,
            raised: Vec::new(),
        };
        bench.monitor.prepare([0.0; 5]).unwrap();
        bench
    }

    fn ask(&mut self, order: Order, service: bool) {
        self.monitor.ask(&Request { number: 1, order }, service);
    }

    /// Runs from one tick to another, with displacements of the truth times `gain`, and none of the axial probe without it.
    fn run(&mut self, ticks: Range<u64>, gain: f64, has_axial: bool) {
        for tick in ticks {
            let cuts = tick % 1000 < 500;
            let share = f64::from(u8::from(cuts)) + 0.02 * normal(&mut self.random);
            let mut measured = self.curve.at(share).map(|p| Some((gain * p) as f32));
            measured[0] = measured[0].filter(|_| has_axial);
            self.monitor.note_displacements(measured);
            let readings = Readings {
                loads: Ok(Some(LoadSample {
                    time_us: 1000 * tick,
                    load: CUT.map(|load| (share * load) as f32),
                    speed: Some((12_007.0 / 60.0 * TAU) as f32),
                    residual: 0.0,
                    doubts: Marks::new(),
                })),
                speed: None,
                temperatures: None,
            };
            let time_us = 1000 * tick;
            self.monitor
                .tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
            while let Some(byte) = self.monitor.outbox().next_byte() {
                let Some(read) = self.reader.push(byte) else {
                    continue;
                };
                match read.unwrap().payload {
                    Payload::Answer(answer) => self.answers.push(answer.outcome),
                    Payload::Probes(report) => self.probes = Some(report),
                    Payload::Alarm(report) if report.change == AlarmChange::Raised => {
                        self.raised.push((report.alarm, report.place));
                    }
                    _ => {}
                }
            }
        }
    }

    fn states(&self) -> Vec<State> {
        let probes = self.probes.iter().flat_map(|report| &report.probes);
        probes.map(|probe| probe.state).collect()
    }
}

#[test]
fn a_monitor_is_commissioned_and_knows_a_change_over_a_power_cycle() {
    assert_eq!(ON_BOARD.check(), Ok(()));
    let mut store = Store::open(
        FailingFlash::<4, 4096>::new(2),
        Identity::of(1, 1),
        ResetCause::PowerOn,
    )
    .0;
    let mut bench = Bench::new(&Past::default());
    bench.ask(Order::Commission, true);
    bench.run(0..4000, 1.0, true);
    bench.ask(Order::Commission, false);
    bench.run(4000..8000, 1.0, true);
    bench.ask(Order::Commission, true);
    bench.run(8000..10_001, 1.0, true);
    // Nobody measures temperatures here.
    bench
        .raised
        .retain(|(alarm, _)| *alarm != Alarm::Temperature);
    use AnswerCode::{Done, NotInService, TooFewSteps};
    assert_eq!(bench.answers, [TooFewSteps, NotInService, Done]);
    assert_eq!(
        (bench.states(), &bench.raised[..]),
        (vec![State::Ok; 2], &[][..])
    );
    bench.monitor.retain(10_000_000, &mut store);
    while store.step() {}

    let (mut store, past) =
        Store::open(store.into_flash(), Identity::of(1, 1), ResetCause::PowerOn);
    let mut bench = Bench::new(&past);
    bench.run(0..3001, 1.2, true);
    assert_eq!(bench.states(), [State::StiffnessLoss; 2]);
    for probe in &bench.probes.as_ref().unwrap().probes {
        let ratio = probe.ratio.unwrap();
        assert!(
            (ratio.value - 1.2).abs() < 0.02 && ratio.error < 0.02,
            "{ratio:?}"
        );
    }
    bench.run(3001..6001, 1.2, false);
    assert_eq!(bench.states(), [State::Probe, State::StiffnessLoss]);
    assert_eq!(bench.raised[0].0, Alarm::StiffnessLoss);
    assert!(
        bench.raised.contains(&(Alarm::Probe, Some(0))),
        "{:?}",
        bench.raised
    );
    // A probe at fault is no reference.
    bench.ask(Order::Commission, true);
    bench.run(6001..6010, 1.2, true);
    assert_eq!(bench.answers, [TooFewSteps]);
    // Of a spindle that is far stiffer than the reference, the order forgets that, and takes another one after some steps.
    bench.run(6010..12_001, 0.4, true);
    assert_eq!(bench.states(), [State::Probe; 2]);
    bench.ask(Order::Commission, true);
    bench.run(12_001..18_001, 0.4, true);
    assert_eq!(bench.states(), [State::Learning; 2]);
    bench.ask(Order::Commission, true);
    bench.run(18_001..21_001, 0.4, true);
    assert_eq!(bench.states(), [State::Ok; 2]);
    assert_eq!(bench.answers, [TooFewSteps, TooFewSteps, Done]);
    bench.monitor.retain(22_000_000, &mut store);
    while store.step() {}
    let flash = store.into_flash();
    let (_, past) = Store::open(flash.clone(), Identity::of(1, 1), ResetCause::PowerOn);
    assert!(past.references[..2].iter().all(Option::is_some));
    // Other probes do not take these references.
    let (_, past) = Store::open(flash, Identity::of(1, 2), ResetCause::PowerOn);
    let mut bench = Bench::new(&past);
    bench.run(0..3001, 1.2, true);
    assert_eq!(bench.states(), [State::Learning; 2]);
}

/// Share of runs whose ratio is within two stated errors of the truth.
fn within(scene: &Scene, truth: [Ratio; 2], seconds: usize, runs: u64) -> [f64; 2] {
    let mut within = [0.0; 2];
    for seed in 0..runs {
        let ratios = scene.ratios(seed, seconds);
        for ((within, ratio), truth) in within.iter_mut().zip(ratios).zip(truth) {
            let is_within = (ratio.value - truth.value).abs() < 2.0 * ratio.error;
            *within += f64::from(u8::from(is_within)) / runs as f64;
        }
    }
    within
}

#[test]
fn disturbances_are_no_change_of_the_spindle() {
    let scene = Scene::new(12_007.0, NONE);
    assert_eq!(scene.alarms(1, 120), 0);
    let mut worse = scene.clone();
    (worse.runout, worse.drift) = ([3.0, 6.0], [5.0, 50.0]);
    assert_eq!(worse.alarms(2, 60), 0);
    for rpm in [6000.0, 18_013.0, 24_000.0] {
        let faster = Scene::of([12_007.0, rpm], [CUT; 2], NONE);
        assert_eq!(faster.alarms(3, 60), 0, "{rpm} rpm");
    }
    // The tool 30 mm longer: the moments say so.
    let [fx, fy, fz, ..] = CUT;
    let longer = [fx, fy, fz, 0.08 * fz, -0.08 * fy];
    let longer = Scene::of([12_007.0; 2], [CUT, longer], NONE);
    assert_eq!(longer.alarms(4, 60), 0);
}

#[test]
fn a_probe_at_fault_is_told_from_a_change_of_the_spindle() {
    let mut scene = Scene::new(12_007.0, NONE);
    for axial in [Axial::Frozen, Axial::Absent, Axial::CutOff, Axial::Swapped] {
        scene.axial = axial;
        for seed in 0..20 {
            scene.change = 15.0 + 0.083 * seed as f64;
            let until = scene.until(seed, State::Probe);
            assert!(until.unwrap_or(99) <= 10, "{until:?}");
        }
    }
}

#[test]
fn blocks_do_not_count_where_runout_stands_still() {
    for (low, high) in [
        (14_700.0, 15_300.0),
        (19_600.0, 20_400.0),
        (29_400.0, 30_600.0),
        (58_800.0, 61_200.0),
    ] {
        assert!(is_aliased(low + 1.0, 1000.0) && is_aliased(high - 1.0, 1000.0));
        assert!(!is_aliased(low - 1.0, 1000.0) && !is_aliased(high + 1.0, 1000.0));
    }
    let mut scene = Scene::new(12_007.0, NONE);
    for rpm in [29_990.0, 30_000.0, 30_010.0, 29_395.0] {
        scene.rpm = [rpm; 2];
        let mut steps = 0;
        scene.run(1, 30, |_, reports| {
            assert!(
                reports
                    .iter()
                    .all(|report| [State::Ok, State::Learning].contains(&report.state))
            );
            steps = reports[0].steps;
            true
        });
        assert_eq!(steps > 0, rpm == 29_395.0);
    }
}

/// Change of the displacement by the whole cut at each probe.
fn changes(rpm: f64, fault: Fault) -> [f64; 2] {
    let [was, is] = [NONE, fault].map(|fault| {
        let curve = Curve::of(&spindle(fault), rpm, CUT);
        let [idle, cut] = [0.0, 1.0].map(|share| curve.at(share));
        [0, 1].map(|i| cut[i] - idle[i])
    });
    [0, 1].map(|i| is[i] / was[i] - 1.0)
}

#[test]
fn the_page_has_what_probes_see() {
    const PAGE: &str = include_str!("../../../../docs/response.md");
    for (name, fault) in FAULTS {
        let percent =
            |rpm: f64| changes(rpm, fault).map(|change| format!("{:+.1}", 100.0 * change));
        let [[x, y], [fast_x, fast_y]] = [6000.0, 18_000.0].map(percent);
        let mut scene = Scene::new(12_007.0, fault);
        let known = [0.05, 0.01].map(|limit| {
            scene.limit = limit;
            let states = [State::StiffnessLoss, State::StiffnessGain];
            let until = states
                .iter()
                .filter_map(|state| scene.first(1, *state))
                .min();
            until.map_or("-".to_owned(), |engagements| engagements.to_string())
        });
        let [of_five, of_one] = known;
        let line = format!("| {name} | {x} to {fast_x} | {y} to {fast_y} | {of_five} | {of_one} |");
        assert!(PAGE.contains(&line), "add to the page: {line}");
    }
}

/// `cargo test --profile host -p cli --test host -- --ignored --nocapture figures_of_a_thousand_runs`: some minutes.
#[test]
#[ignore = "10 hours of cutting, and 1,000 runs"]
fn figures_of_a_thousand_runs() {
    let scene = Scene::new(12_007.0, NONE);
    println!("no fault, 10 h: {} s of alarm", scene.alarms(1, 36_000));
    for (name, fault, limit) in [
        ("no fault", NONE, 0.05),
        ("20 % of the preload lost", LOST_20, 0.05),
        ("5 % lost, limit 1 %", LOST_5, 0.01),
        ("radial supports a third softer", SOFT, 0.05),
    ] {
        let mut scene = Scene::new(12_007.0, fault);
        scene.limit = limit;
        let truth = scene.clean().ratios(0, 41);
        let errors = scene.ratios(1, 41).map(|ratio| 100.0 * ratio.error);
        let within = within(&scene, truth, 41, 1000).map(|share| 100.0 * share);
        let truth = truth.map(|ratio| ratio.value);
        println!(
            "{name}: ratios {truth:.4?}, errors {errors:.3?} %, within two errors {within:.1?} %"
        );
        if name != "no fault" {
            let until = (0..100).map(|seed| scene.until(seed, State::StiffnessLoss));
            let early: usize = (0..100).map(|seed| scene.alarms(seed, 20)).sum();
            println!("{name}: {early} of 2,000 s with an early alarm");
            println!(
                "{name}: most engagements {:?}",
                until.map(|one| one.unwrap_or(99)).max()
            );
        }
    }
}
