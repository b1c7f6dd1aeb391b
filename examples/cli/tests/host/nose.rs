//! The stiffness at the nose is what a dial gauge finds there: one force or moment more, over the displacement that it makes.

use cli::replay::{Job, Table, replay};
use solvers::dispatch::Precision;
use solvers::{Balls, Choices, with_solver};
use spindle_bearing::{
    Arrangement, Bearing, Facing, Material, Mounted, Preload, RacewayControlFree, Section,
    Settings, Shaft, ShaftLoad, Speed, Spindle, SpindleSolver, Support,
};
use spindle_file::designs::SHIPPED;
use spindle_file::loads::LoadRow;
use spindle_file::spindles::SpindleFile;
use spindle_firmware::spindle::{BEARING_0, DESIGN_0};
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::{MonitorSettings, ShaftSettings};
use spindle_monitor::telemetry::{EstimateReport, FrameReader, Payload};
use spindle_monitor::tick::{NoCycles, NoWatchdog};
use spindle_monitor::{Marks, Monitor, Readings};
use std::array::from_fn;
use std::path::Path;

const LOAD: [f64; 5] = [60.0, 150.0, -40.0, 0.5, 1.0];
/// One force or moment more, N and N m.
const STEPS: [f64; 5] = [0.5, 0.5, 0.5, 0.02, 0.02];

/// Compliances that a dial gauge finds, by displacements under the loads and then under each one more and each one less.
fn gauge(mut moved: impl FnMut([f64; 5]) -> [f64; 5]) -> [f64; 5] {
    from_fn(|i| {
        let [more, less] = [1.0, -1.0].map(|sign| {
            let mut load = LOAD;
            load[i] += sign * STEPS[i];
            moved(load)[i]
        });
        (more - less) / (2.0 * STEPS[i])
    })
}

/// A spindle's file, its nose, where all loads act, at this position.
fn file(kind: &str, nose: f64) -> String {
    let mut text = "name = \"s\"\narrangement = \"back-to-back\"\n".to_owned();
    text += if kind == "sprung" {
        ""
    } else {
        "preload_n = 200\n"
    };
    for (position, facing) in [(0, "+x"), (100, "-x")] {
        text += "[[row]]\nbearing = \"b7005c.toml\"\n";
        text += &format!("position_mm = {position}\nfacing = \"{facing}\"\n");
        if kind == "sprung" && position > 0 {
            text += "spring = true\n";
        }
        if kind == "elastic" {
            text += "support = { axial_n_per_um = 400, radial_n_per_um = 300 }\n";
        }
    }
    text += match kind {
        "sprung" => "[spring]\nforce_n = 250\n",
        "elastic" => {
            "[shaft]\nsections = [{ from_mm = -60, to_mm = 130, outer_mm = 25, inner_mm = 8 }]\n"
        }
        _ => "",
    };
    text += &format!("[load]\nposition_mm = {nose}\n[nose]\nposition_mm = {nose}\n");
    text + match kind {
        "yielding" => "radial_um_per_kn = 4\naxial_um_per_kn = 1\n",
        _ => "",
    }
}

#[test]
fn the_stiffness_at_the_nose_of_a_replay_is_what_a_dial_gauge_finds() {
    let mut figures = 0;
    for kind in ["rigid", "yielding", "sprung", "elastic"] {
        for nose in [-90.0, -40.0, 0.0, 50.0, 130.0] {
            let text = file(kind, nose);
            let file = SpindleFile::parse("s.toml", &text, Path::new(SHIPPED)).unwrap();
            let row = |load| LoadRow {
                time_s: 0.0,
                load,
                speed_rpm: 12_000.0,
                temperatures: None,
                probes: [None; 4],
            };
            let choices = Choices {
                tolerance: Some(1e-12),
                ..Choices::default()
            };
            let mut table = Vec::new();
            let job = Job {
                file: &file,
                precision: Precision::F64,
                cold: true,
                at_rest: false,
                select: ["x_x", "y_y", "z_z", "ty_ty", "tz_tz"]
                    .map(|name| format!("k_nose_{name}"))
                    .to_vec(),
                choices,
                held: [None; 5],
                holds_pauses: false,
                lifetime: None,
            };
            let found = with_solver(&file.plan, Balls::Free, Precision::F64, |solver| {
                let out = vec![(Table::Results, Box::new(&mut table) as _)];
                replay(job, solver, [Ok(row(LOAD))].into_iter(), out).unwrap();
                solver.choose(&choices);
                gauge(|load| {
                    let question = file.question(&row(load));
                    let moved = solver.answer(&question).at[0].displacement;
                    // The end that yields by itself is in no displacement.
                    from_fn(|i| moved[i] + question.ends[0].flexibility[i] * load[i])
                })
            });
            let text = String::from_utf8(table).unwrap();
            let told = text.lines().nth(1).unwrap().split(',');
            for ((told, c), i) in told.zip(found.unwrap()).zip(0..) {
                let off = told.parse::<f64>().unwrap() * c - 1.0;
                assert!(off.abs() < 1e-5, "{kind}, {nose} mm, {i}: {off:e}");
                figures += 1;
            }
        }
    }
    assert_eq!(figures, 100);
}

/// Where the loads of the monitor act, m.
const LOADS_AT: f64 = -0.05;

/// Compliance at `nose` by a force there besides the load at [`LOADS_AT`], in double precision.
fn by_gauge<const D: usize, const E: usize>(
    spindle: &Spindle<'_, f64, 2, 16, D, E>,
    omega: f64,
    nose: f64,
) -> [f64; 5] {
    let mut solver = SpindleSolver::<f64, 2, 16, RacewayControlFree, D, E>::of();
    let settings = Settings {
        tolerance: 1e-12,
        ..Settings::default()
    };
    gauge(|load| {
        let at = |position, load| ShaftLoad { position, load };
        let more = from_fn(|i| load[i] - LOAD[i]);
        let loads = [at(LOADS_AT, LOAD), at(nose, more)];
        let solved = solver.solve(spindle, &loads, Speed::rad_per_s(omega), &settings);
        solved.unwrap().displacement_at(nose)
    })
}

/// The last estimate of a monitor under these loads, each of which may be off by its accuracy.
fn reported<const D: usize, const E: usize>(
    spindle: &'static Spindle<'static, f32, 2, 16, D, E>,
    omega: f64,
    shaft: ShaftSettings,
    accuracy: [f64; 5],
) -> EstimateReport {
    let mut settings = MonitorSettings::new(&DESIGN_0, 16);
    settings.shaft = shaft;
    settings.accuracy = accuracy.map(|load| load as f32);
    settings.tolerance = 1e-3;
    settings.plausibility.stuck_after = 0;
    let settings = Box::leak(Box::new(settings));
    let mut monitor: Monitor<2, 16, 12, D, E> = Monitor::new(spindle, settings);
    monitor.prepare([0.0; 5]).unwrap();
    let (mut reader, mut last) = (FrameReader::new(), None);
    for time_us in (0..200_000).step_by(1000) {
        let sample = LoadSample {
            time_us,
            load: LOAD.map(|load| load as f32),
            speed: Some(omega as f32),
            residual: 0.0,
            doubts: Marks::new(),
        };
        let readings = Readings {
            loads: Ok(Some(sample)),
            speed: None,
            temperatures: None,
        };
        monitor.tick(time_us, &readings, &mut NoCycles, &mut NoWatchdog);
        while let Some(byte) = monitor.outbox().next_byte() {
            if let Some(Ok(frame)) = reader.push(byte)
                && let Payload::Estimate(report) = frame.payload
            {
                last = Some(report);
            }
        }
    }
    last.unwrap()
}

const RADIAL: f64 = 4e-9;

/// The stiffness that the monitor reports is the gauge's within its stated error, which is small.
fn check<const D: usize, const E: usize>(
    kind: &str,
    wide: &Spindle<'_, f64, 2, 16, D, E>,
    narrow: Spindle<'static, f32, 2, 16, D, E>,
) {
    let narrow = Box::leak(Box::new(narrow));
    for nose in [-0.09, -0.04, 0.0, 0.05, 0.13] {
        for (flexibility, rpm) in [(0.0, 12_000.0), (RADIAL, 0.0)] {
            let omega = Speed::rpm(rpm).as_rad_per_s();
            let shaft = ShaftSettings {
                loads_at: LOADS_AT as f32,
                nose: nose as f32,
                flexibility: [0.0, flexibility as f32, flexibility as f32, 0.0, 0.0],
            };
            let report = reported(narrow, omega, shaft, [0.0; 5]);
            let own = [0.0, flexibility, flexibility, 0.0, 0.0];
            let truth = by_gauge(wide, omega, nose);
            let stated = f64::from(report.error[2]);
            assert!(stated < 0.02, "{kind}, {nose}: {stated}");
            for i in 0..5 {
                let off = f64::from(report.stiffness[i]) * (truth[i] + own[i]) - 1.0;
                assert!(
                    off.abs() <= stated,
                    "{kind}, {nose}, {i}: {off:e} {stated:e}"
                );
            }
        }
    }
}

/// Two rows back to back, the second one held by this preload.
fn rows<T: spindle_bearing::Real>(
    bearing: &Bearing<T, 16>,
    [first, second]: [Preload<T>; 2],
) -> [Mounted<'_, T, 16>; 2] {
    [
        Mounted::new(bearing, T::ZERO, Facing::PlusX).with(first),
        Mounted::new(bearing, T::of(0.1), Facing::MinusX).with(second),
    ]
}

/// Where loads act, and a nose: at one place, or one beyond the other. Between the rows an elastic shaft is not judged.
const PLACES: [[f64; 2]; 5] = [
    [-0.05, -0.05],
    [-0.09, -0.04],
    [-0.03, -0.05],
    [0.0, -0.05],
    [0.13, 0.1],
];

/// The stated error of the displacement is its change by each load that is solved once more, off by its accuracy; changes are added up.
/// A load without an accuracy adds nothing.
fn check_accuracy<const D: usize, const E: usize>(
    kind: &str,
    wide: &Spindle<'_, f64, 2, 16, D, E>,
    narrow: Spindle<'static, f32, 2, 16, D, E>,
) {
    let narrow = Box::leak(Box::new(narrow));
    let omega = Speed::rpm(12_000.0).as_rad_per_s();
    let mut solver = SpindleSolver::<f64, 2, 16, RacewayControlFree, D, E>::of();
    let settings = Settings {
        tolerance: 1e-12,
        ..Settings::default()
    };
    let largest = |u: [f64; 3]| u.into_iter().map(f64::abs).fold(0.0, f64::max);
    for [position, nose] in PLACES {
        let mut moved = |load: [f64; 5]| -> [f64; 3] {
            let loads = [ShaftLoad { position, load }];
            let solved = solver.solve(wide, &loads, Speed::rad_per_s(omega), &settings);
            let [x, y, z, ..] = solved.unwrap().displacement_at(nose);
            [x, y, z]
        };
        let at = moved(LOAD);
        let changes: [[f64; 3]; 5] = from_fn(|i| {
            let mut load = LOAD;
            load[i] += STEPS[i];
            let off = moved(load);
            from_fn(|axis| (off[axis] - at[axis]).abs())
        });
        let shaft = ShaftSettings {
            loads_at: position as f32,
            nose: nose as f32,
            flexibility: [0.0, RADIAL as f32, RADIAL as f32, 0.0, 0.0],
        };
        let stated = |accuracy| f64::from(reported(narrow, omega, shaft, accuracy).error[0]);
        let of_solve = stated([0.0; 5]);
        for exact in [None, Some(0), Some(1), Some(2), Some(3), Some(4)] {
            let is_off = |i: usize| Some(i) != exact;
            let accuracy = from_fn(|i| if is_off(i) { STEPS[i] } else { 0.0 });
            let off = (0..5).filter(|i| is_off(*i)).map(|i| changes[i]);
            let sum = off.fold([0.0; 3], |sum, u| from_fn(|axis| sum[axis] + u[axis]));
            let by_loads = stated(accuracy) - of_solve;
            let ratio = by_loads / (largest(sum) / largest(at));
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{kind}, {position}, {nose}, {exact:?}: {ratio}"
            );
        }
    }
}

/// Rigid, sprung and elastic pairs in both precisions, judged in turn.
macro_rules! judge_pairs {
    ($check:ident) => {
        let arrangement = Arrangement::BackToBack;
        let bearing = Bearing::<f64, 16>::new(&DESIGN_0).unwrap();
        let section = Section {
            from: -0.06,
            to: 0.13,
            outer: 0.025,
            inner: 0.008,
        };
        let wide_shaft = Shaft::<f64, 1>::new(&[section], &Material::STEEL).unwrap();
        let narrow_shaft = Shaft::<f32, 1>::new(&[section], &Material::STEEL).unwrap();
        let narrow_shaft = &*Box::leak(Box::new(narrow_shaft));
        let clamped =
            || Spindle::new(arrangement, rows(&bearing, [Preload::Force(200.0); 2])).unwrap();
        let single =
            || Spindle::new(arrangement, rows(&BEARING_0, [Preload::Force(200.0); 2])).unwrap();
        $check("rigid", &clamped(), single());

        let sprung = [Preload::Closure(0.0), Preload::Spring];
        let wide = Spindle::sprung(arrangement, rows(&bearing, sprung), 250.0);
        let sprung = [Preload::Closure(0.0), Preload::Spring];
        let narrow = Spindle::sprung(arrangement, rows(&BEARING_0, sprung), 250.0);
        $check("sprung", &wide.unwrap(), narrow.unwrap());

        let wide = Support {
            axial: 400e6,
            radial: 300e6,
            ..Support::RIGID
        };
        let narrow = Support {
            axial: 400e6,
            radial: 300e6,
            ..Support::RIGID
        };
        let wide = clamped().elastic(&wide_shaft, [wide; 2]);
        let narrow = single().elastic(narrow_shaft, [narrow; 2]);
        $check("elastic", &wide.unwrap(), narrow.unwrap());
    };
}

#[test]
fn the_stiffness_at_the_nose_of_a_monitor_is_a_dial_gauges_within_its_error() {
    judge_pairs!(check);
}

#[test]
fn the_stated_error_of_the_displacement_is_its_change_by_loads_off_by_their_accuracy() {
    judge_pairs!(check_accuracy);
}
