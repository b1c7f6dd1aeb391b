//! A synthetic recording: a milling spindle that warms up.
//!
//! Nothing here was measured. The inner side warms with the heat of the bearings, in minutes. The outer side warms half
//! as much and more slowly; both cool when the spindle stands. A cutter 60 mm in front of the first row loads the shaft.
//! `records/README.md` tells what happens when.

use spindle_file::loads::LoadRow;
use std::f64::consts::TAU;

/// Where the recording is kept.
pub const RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/records/warm_up.csv");

/// Length, s: a row each.
const LENGTH_S: u32 = 1800;
/// Where the cutter is, m.
const CUTTER: f64 = -0.06;
/// Temperature of the room, degrees Celsius.
const ROOM: f64 = 20.0;

/// Speed, rpm, from a time (s) on.
const SPEED: [(u32, f64); 7] = [
    (0, 0.0),
    (30, 4_000.0),
    (300, 8_000.0),
    (700, 12_000.0),
    (1200, 6_000.0),
    (1500, 12_000.0),
    (1700, 0.0),
];

/// Radial and axial force of the cut, N, from a time (s) on.
const CUTS: [(u32, [f64; 2]); 9] = [
    (0, [0.0, 0.0]),
    (400, [400.0, -100.0]),
    (520, [0.0, 0.0]),
    (800, [600.0, -150.0]),
    (1000, [0.0, 0.0]),
    (1250, [1000.0, -300.0]),
    (1400, [0.0, 0.0]),
    (1550, [500.0, 0.0]),
    (1650, [0.0, 0.0]),
];

/// Value at a time. Every table begins at 0.
fn at<T: Copy>(table: &[(u32, T)], time: u32) -> T {
    table[table.partition_point(|(from, _)| *from <= time) - 1].1
}

/// The recording.
pub fn warm_up() -> Vec<LoadRow> {
    let (mut speed, mut inner, mut outer) = (0.0_f64, ROOM, ROOM);
    let row = |time: u32| {
        // The drive reaches a new speed in some ten seconds.
        speed += 0.3 * (at(&SPEED, time) - speed);
        if time >= 1700 + 60 {
            speed = 0.0;
        }
        let heat = libm::pow(speed / 12_000.0, 1.6);
        inner += (ROOM + 22.0 * heat - inner) / 240.0;
        outer += (ROOM + 12.0 * heat - outer) / 600.0;
        let [radial, axial] = at(&CUTS, time);
        // The cutter feeds round a pocket.
        let turn = TAU * f64::from(time) / 37.0;
        let (fy, fz) = (radial * libm::cos(turn), radial * libm::sin(turn));
        let round = |x: f64, per: f64| libm::round(x * per) / per + 0.0;
        LoadRow {
            time_s: f64::from(time),
            load: [
                axial,
                round(fy, 10.0),
                round(fz, 10.0),
                round(-CUTTER * fz, 100.0),
                round(CUTTER * fy, 100.0),
            ],
            speed_rpm: round(speed, 1.0),
            temperatures: Some([round(inner, 100.0), round(outer, 100.0)]),
            probes: [None; 4],
        }
    };
    (0..LENGTH_S).map(row).collect()
}
