//! Life that the shipped pair's monitor counts, against the life under the load of every tick, solved in double precision.

use super::spindle::{BORE, MONITOR, REACH, SECTIONS, SPINDLE};
use mock::rig::{B7005C, Rig};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng};
use spindle_bearing::{
    Arrangement, Bearing, Expansion, Facing, Growth, LifeRating, Material, Mounted, Preload,
    RacewayControlFree, RatingLife, Settings, Shaft, Speed, Spindle, SpindleSolver, Support,
};
use spindle_monitor::loads::LoadSample;
use spindle_monitor::settings::MonitorSettings;
use spindle_monitor::{Marks, Readings, TemperatureSettings};
use std::array::from_fn;

/// A speed (rad/s), and temperatures of the inner and of the outer side over the reference, K.
#[derive(Debug, Clone, Copy)]
struct State {
    speed: f64,
    warmer: [f64; 2],
}

/// Damage per million revolutions under each of some loads.
fn damages(state: State, loads: &[[f32; 5]]) -> Vec<f64> {
    let bearing = Bearing::<f64, 16>::new(&B7005C).unwrap();
    let shaft = Shaft::<f64, 2>::new(&SECTIONS, &Material::STEEL).unwrap();
    let row = |position, facing| {
        Mounted::<f64, 16>::new(&bearing, position, facing).with(Preload::Force(250.0))
    };
    let rows = [row(0.03, Facing::PlusX), row(0.13, Facing::MinusX)];
    let housing = Support {
        axial: 400e6,
        radial: 300e6,
        ..Support::RIGID
    };
    let spindle = Spindle::new(Arrangement::BackToBack, rows).unwrap();
    let spindle = spindle.elastic(&shaft, [housing; 2]).unwrap();
    let rating = LifeRating::<f64>::new(&B7005C, 16, B7005C.dynamic_load_rating(16));
    let State { speed, warmer } = state;
    let growth = Growth::by_temperatures(&B7005C, &Expansion::STEEL, REACH, warmer);
    let growth = growth + Growth::by_rotation(&B7005C, BORE, speed);
    let at = Speed::rad_per_s(speed).with_growth([growth; 2]);
    let mut solver = SpindleSolver::<f64, 2, 16, RacewayControlFree, 5, 2>::of();
    let damage = |load: &[f32; 5]| {
        let solution = solver
            .solve(&spindle, load.map(f64::from), at, &Settings::default())
            .unwrap_or_else(|status| panic!("{load:?}: {status}"));
        let weights = solution
            .rows()
            .map(|row| rating.weight_of(row.balls().map(|ball| (ball.q_i, ball.q_o))));
        1.0 / RatingLife::of_weight(weights.sum(), speed).million_revolutions
    };
    loads.iter().map(damage).collect()
}

/// Settings of the shipped monitor with so many cycles in a tick for a solve, and temperatures that are used at once.
fn settings(cycles: u32) -> &'static MonitorSettings<2> {
    let mut settings = MONITOR;
    settings.tick.deadline_cycles = settings.tick.cost.tick + cycles;
    settings.temperatures = settings
        .temperatures
        .map(|t| TemperatureSettings { rate: 1e3, ..t });
    settings.check().unwrap();
    assert!(settings.tick.has_time(2, 16));
    Box::leak(Box::new(settings))
}

/// A spindle that turns, and what its monitor is told.
struct Bench {
    rig: Rig<2, 2>,
    state: State,
}

impl Bench {
    fn new(settings: &'static MonitorSettings<2>, state: State) -> Self {
        let rig = Rig::of(&SPINDLE, settings, [0.0; 5]);
        Self { rig, state }
    }

    /// A tick at a part of the speed; whether there is a new estimate.
    fn tick(&mut self, load: [f32; 5], part: f64) -> bool {
        let heat = MONITOR.temperatures.unwrap();
        let sample = LoadSample {
            time_us: self.rig.time_us,
            load,
            speed: None,
            residual: 0.0,
            doubts: Marks::new(),
        };
        let outcome = self.rig.tick(&Readings {
            loads: Ok(Some(sample)),
            speed: Some(Some((part * self.state.speed) as f32)),
            temperatures: Some(
                self.state
                    .warmer
                    .map(|warmer| heat.reference + warmer as f32),
            ),
        });
        outcome.solved
    }

    fn run_up(&mut self) {
        for ms in 0..200 {
            // Not quite 0, and never twice the same.
            let load = [1e-3 * ms as f32; 5];
            self.tick(load, f64::from(ms) / 200.0);
        }
    }

    /// Stands still for more than five seconds, and has a new bearing.
    fn replace_bearing(&mut self) {
        self.tick([0.0; 5], 0.0);
        self.rig.leave_out(5500);
        self.tick([1e-3; 5], 0.0);
        assert!(self.rig.monitor.replace_bearing(self.rig.time_us));
        assert_eq!(self.rig.monitor.life().used(), 0.0);
    }

    /// Life used under these loads over the truth, and ticks per estimate.
    fn counted(&mut self, loads: &[[f32; 5]], damages: &[f64]) -> (f64, f64) {
        let before = self.rig.monitor.life().kept().0;
        let mut estimates = 0;
        for load in loads {
            estimates += u32::from(self.tick(*load, 1.0));
        }
        let units = self.rig.monitor.life().kept().0 - before;
        let revolutions = self.state.speed * 1e-3 / std::f64::consts::TAU;
        let used = units as f64 / 2f64.powi(56) * 1e6 / revolutions;
        (
            used / damages.iter().sum::<f64>(),
            loads.len() as f64 / f64::from(estimates),
        )
    }
}

const CUT: [f32; 5] = [0.0, 300.0, 0.0, 0.0, -15.0];
const DRILL: [f32; 5] = [-300.0, 0.0, 0.0, 0.0, 0.0];
const NOTHING: [f32; 5] = [0.0; 5];

/// Cycles that a tick leaves for a solve, so that one takes 1, 2 and some 4 ticks under a load that stays.
const CYCLES: [u32; 3] = [400_000, 140_000, 69_000];

/// Loads of some ticks, with a noise of each force up to this, N, and of moments on an arm of 50 mm.
fn loads(ticks: u32, noise: f64, load: impl Fn(u32) -> [f32; 5]) -> Vec<[f32; 5]> {
    let mut random = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let of_tick = |tick| {
        let load = load(tick);
        from_fn(|i| {
            let noise = noise * if i < 3 { 1.0 } else { 0.05 };
            load[i] + (noise * random.random_range(-1.0..1.0)) as f32
        })
    };
    (0..ticks).map(of_tick).collect()
}

fn half(period: u32, load: [f32; 5]) -> impl Fn(u32) -> [f32; 5] {
    move |tick| {
        if tick % period < period / 2 {
            load
        } else {
            NOTHING
        }
    }
}

/// Between solves the load's part of the life is scaled, and the preload's is not.
#[test]
fn life_between_solves_is_that_of_the_loads_to_a_tenth_below_and_15_per_cent_above() {
    let tenth = |tick| if tick < 100 { CUT } else { NOTHING };
    let patterns = [
        ("idle, 2 N of noise", loads(300, 2.0, |_| NOTHING)),
        ("idle, 10 N of noise", loads(300, 10.0, |_| NOTHING)),
        ("idle at exactly 0", loads(300, 0.0, |_| NOTHING)),
        (
            "cut of 300 N every second tick",
            loads(300, 2.0, half(2, CUT)),
        ),
        ("cut of 300 N, 4 ticks of 8", loads(300, 2.0, half(8, CUT))),
        (
            "cut of 300 N, half a second",
            loads(300, 2.0, half(300, CUT)),
        ),
        (
            "cut of 300 N for 0.1 s of a second",
            loads(1000, 2.0, tenth),
        ),
        ("drilling with 300 N", loads(300, 2.0, |_| DRILL)),
        (
            "drilling with 300 N, 4 ticks of 8",
            loads(300, 2.0, half(8, DRILL)),
        ),
    ];
    let mut states = Vec::new();
    for rpm in [12_000.0, 24_000.0] {
        let speed = rpm * std::f64::consts::PI / 30.0;
        states.extend([0.0, 10.0, -10.0].map(|inner| State {
            speed,
            warmer: [inner, 0.0],
        }));
    }
    let each_tick = CYCLES.map(settings);
    let judge = |state: State| {
        let of_pattern = |(what, loads): &(&'static str, Vec<[f32; 5]>)| {
            let truth = damages(state, loads);
            let of_settings = |(settings, ticks): (&&'static MonitorSettings<2>, u32)| {
                let mut bench = Bench::new(settings, state);
                if loads.len() == 1000 {
                    bench.replace_bearing();
                }
                bench.run_up();
                let (ratio, per_estimate) = bench.counted(loads, &truth);
                (*what, state, ticks, per_estimate, ratio)
            };
            let settings = each_tick.iter().zip([1, 2, 4]);
            settings.map(of_settings).collect::<Vec<_>>()
        };
        patterns.iter().flat_map(of_pattern).collect::<Vec<_>>()
    };
    let all: Vec<_> = states.into_iter().flat_map(judge).collect();
    let off: Vec<_> = all
        .iter()
        .filter(|(.., ratio)| !(0.9..=1.15).contains(ratio))
        .collect();
    assert!(off.is_empty(), "{off:#?}");
    // Under a load that stays, of which there are solves.
    for (ticks, within) in [(1, 1.0..1.2), (2, 1.5..2.2), (4, 3.2..4.2)] {
        let steady = all.iter().filter(|(what, _, of, ..)| {
            *of == ticks && !what.starts_with("idle at") && !what.contains("tick")
        });
        let mut count = 0;
        for (what, state, _, per_estimate, _) in steady {
            assert!(
                within.contains(per_estimate),
                "{what} {state:?}: {per_estimate}"
            );
            count += 1;
        }
        assert_eq!(count, 5 * 6);
    }
}
