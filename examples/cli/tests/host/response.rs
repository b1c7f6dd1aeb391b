//! Probes of a monitor: their columns, and their estimates over a power cycle.

use cli::random::Random;
use cli::recordings::{Loads, Wanted};
use cli::telemetry::simulated::MONITOR;
use mock::flash::FailingFlash;
use solvers::dispatch::Precision;
use solvers::{Balls, with_solver};
use spindle_bearing::Preload;
use spindle_file::designs::SHIPPED;
use spindle_file::loads::LoadRow;
use spindle_file::mounting::preload;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle::{BALLS, FREEDOMS, JOINTS, ROWS, SPINDLE};
use spindle_monitor::board::ResetCause;
use spindle_monitor::command::{AnswerCode, Request};
use spindle_monitor::estimator::State;
use spindle_monitor::judgement::AlarmChange;
use spindle_monitor::loads::LoadSample;
use spindle_monitor::revolutions::is_aliased;
use spindle_monitor::telemetry::{FrameReader, Payload, ProbesReport};
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Alarm, Identity, Marks, Monitor, Order, Past, Probes, Readings, Store};
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
/// Loads of cuts, which come in turn.
const CUTS: [[f64; 5]; 6] = [
    [-90.0, 270.0, 135.0, 6.75, -13.5],
    [-200.0, 60.0, -60.0, -1.8, -1.8],
    [0.0, -120.0, 200.0, 14.0, 8.4],
    [150.0, 80.0, 90.0, 1.8, -1.6],
    [-50.0, -250.0, -100.0, -6.0, 15.0],
    [-120.0, 20.0, 160.0, 12.8, -1.6],
];
const RPM: f64 = 12_007.0;

/// The shipped spindle with probes, ground for another preload.
fn spindle(force: f64) -> SpindleFile {
    let folder = Path::new(SHIPPED).join("../../firmware");
    let text = format!("{FILE}{PROBES}");
    let mut file =
        SpindleFile::parse("spindle.toml", &text, &folder).unwrap_or_else(|e| panic!("{e}"));
    for row in &mut file.plan.rows {
        row.preload = Preload::Force(force);
    }
    file
}

/// Displacements at the probes without a load, and in each cut, um.
fn seen(force: f64) -> Vec<[f64; 2]> {
    let file = spindle(force);
    let points = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
        let loads = [[0.0; 5]].into_iter().chain(CUTS);
        let points = loads.map(|load| {
            let row = LoadRow {
                time_s: 0.0,
                load,
                speed_rpm: RPM,
                temperatures: Some([20.0; 2]),
                probes: [None; 4],
            };
            let answer = solver.answer(&file.question_at_probes(&row));
            [0, 1].map(|i| file.probes[i].sees(&answer.at[i].displacement))
        });
        points.collect()
    });
    points.unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_recording_has_readings_of_probes() {
    // Readings of the probes `a` and `b`, row by row; none of a row that is refused.
    let readings = |csv: &str| -> Vec<Option<Vec<Option<f64>>>> {
        let wanted = Wanted {
            probes: ["a", "b"].map(str::to_owned).to_vec(),
            ..Wanted::default()
        };
        let input = Box::new(Cursor::new(csv.as_bytes().to_vec()));
        let loads = Loads::from_reader("r.csv", input, &wanted).unwrap_or_else(|e| panic!("{e}"));
        let rows = loads.map(|row| row.ok().map(|row| row.probes[..2].to_vec()));
        rows.collect()
    };
    let own = "probe_b_um,time_s,fx_n,fy_n,fz_n,my_nm,mz_nm,speed_rpm,probe_a_um\n\
        -1.5,0,1,0,0,0,0,0,2\n,1,1,0,0,0,0,0,3e1\n2,2,1,0,0,0,0,0,far\n";
    let both = [
        Some(vec![Some(2.0), Some(-1.5)]),
        Some(vec![Some(30.0), None]),
        None,
    ];
    assert_eq!(readings(own), both);
    let alone = own.replace("probe_b_um", "probe_c_um");
    assert_eq!(readings(&alone)[0], Some(vec![Some(2.0), None]));
}

#[test]
fn runout_stands_still_near_multiples_of_the_rate() {
    for (low, high) in [
        (14_700.0, 15_300.0),
        (19_600.0, 20_400.0),
        (29_400.0, 30_600.0),
        (58_800.0, 61_200.0),
    ] {
        assert!(is_aliased(low + 1.0, 1000.0) && is_aliased(high - 1.0, 1000.0));
        assert!(!is_aliased(low - 1.0, 1000.0) && !is_aliased(high + 1.0, 1000.0));
    }
}

/// A monitor with probes, its host, and the commands that it gets.
struct Bench {
    monitor: Monitor<ROWS, BALLS, 12, FREEDOMS, JOINTS, 2>,
    reader: FrameReader,
    random: Random,
    answers: Vec<AnswerCode>,
    probes: Option<ProbesReport>,
    raised: Vec<(Alarm, Option<u16>)>,
}

impl Bench {
    fn new(past: &Past) -> Self {
        let response = preload::response::<2>(&spindle(250.0)).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(response.check(), Ok(()));
        let probes = Probes::new(
            Box::leak(Box::new(response)),
            &MONITOR.alarms,
            MONITOR.tick.period_us,
        );
        let probes = Box::leak(Box::new(probes));
        let mut bench = Self {
            monitor: Monitor::with_probes(&SPINDLE, &MONITOR, probes).with_past(past),
            reader: FrameReader::new(),
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

    /// Runs from one tick to another, a cut of 200 ms every 400 ms, with displacements of the truth times `gains`.
    fn run(&mut self, ticks: Range<u64>, truth: &[[f64; 2]], gains: [f64; 2]) {
        for tick in ticks {
            let cut = (tick / 400) as usize;
            let (number, is_cutting) = (cut % CUTS.len(), tick % 400 >= 200);
            let load = CUTS[number].map(|load| if is_cutting { load } else { 0.0 });
            let seen = truth[if is_cutting { number + 1 } else { 0 }];
            let noise = [0; 7].map(|_| self.random.between(-1.0, 1.0));
            let measured = [0, 1].map(|i| Some((gains[i] * seen[i] + 0.2 * noise[i]) as f32));
            self.monitor.note_displacements(measured);
            let time_us = 1000 * tick;
            let readings = Readings {
                loads: Ok(Some(LoadSample {
                    time_us,
                    load: std::array::from_fn(|i| (load[i] + 0.01 * noise[2 + i]) as f32),
                    speed: Some((RPM / 60.0 * TAU) as f32),
                    residual: 0.0,
                    doubts: Marks::new(),
                })),
                speed: None,
                temperatures: tick.is_multiple_of(100).then_some([20.0; 2]),
            };
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

    fn state(&self) -> State {
        self.probes
            .as_ref()
            .map_or(State::Learning, |report| report.state)
    }
}

#[test]
fn a_monitor_is_commissioned_and_knows_a_change_over_a_power_cycle() {
    let open = |flash| Store::open(flash, Identity::of(1, 1), ResetCause::PowerOn);
    let (mut store, past) = open(FailingFlash::<4, 4096>::new(2));
    let [sound, lost] = [230.0, 180.0].map(seen);
    let gains = [1.04, 0.97];
    let mut bench = Bench::new(&past);
    bench.ask(Order::Commission, true);
    bench.run(0..2000, &sound, gains);
    bench.ask(Order::Commission, false);
    bench.run(2000..50_000, &sound, gains);
    bench.ask(Order::Commission, true);
    bench.run(50_000..52_001, &sound, gains);
    use AnswerCode::{Done, Learning, NotInService};
    assert_eq!(bench.answers, [Learning, NotInService, Done]);
    assert_eq!((bench.state(), &bench.raised[..]), (State::Ok, &[][..]));
    let preload = bench
        .probes
        .as_ref()
        .and_then(|report| report.preload)
        .unwrap();
    assert!(
        (preload.value - 230.0).abs() < 3.0 * preload.error.min(5.0),
        "{preload:?}"
    );
    bench.monitor.retain(52_000_000, &mut store);
    while store.step() {}

    let (mut store, past) = open(store.into_flash());
    let mut bench = Bench::new(&past);
    bench.run(0..15_001, &lost, gains);
    assert_eq!(bench.state(), State::PreloadLoss);
    assert_eq!(bench.raised, [(Alarm::PreloadChange, None)]);
    // A cable that is cut.
    bench.run(15_001..20_001, &lost, [1.04, 0.0]);
    let states: Vec<State> = bench
        .probes
        .iter()
        .flat_map(|report| &report.probes)
        .map(|probe| probe.state)
        .collect();
    assert_eq!(states, [State::Ok, State::Probe]);
    assert!(
        bench.raised.contains(&(Alarm::Probe, Some(1))),
        "{:?}",
        bench.raised
    );
    bench.monitor.retain(22_000_000, &mut store);
    while store.step() {}
    let flash = store.into_flash();
    let (_, past) = open(flash.clone());
    assert!(past.estimates.is_some());
    // Other probes do not take these estimates.
    let (_, past) = Store::open(flash, Identity::of(1, 2), ResetCause::PowerOn);
    let mut bench = Bench::new(&past);
    bench.run(0..3001, &lost, gains);
    assert_eq!(bench.state(), State::Learning);
}
