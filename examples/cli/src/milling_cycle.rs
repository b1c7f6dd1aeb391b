//! A synthetic recording of one cycle of a small milling spindle: loads of its front bearing, or at its nose.
//!
//! Nothing here was measured. Every tooth presses the shaft with a half-sine of a force that turns with the tooth. There
//! is run-out, uneven material, unbalance, preload that grows with heat, and sensor noise. Levels and timing are made
//! up, within a B7005C's loads in practice, but for a crash. `records/README.md` tells what happens when.
//!
//! Rows are the same everywhere: the noise comes from a generator with a fixed seed, and sines from
//! `libm` rather than from the platform.

use crate::random::Random;
use spindle_file::loads::LoadRow;
use std::f64::consts::{PI, TAU};

/// Where the recording is kept.
pub const RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/records/milling_cycle.csv");

/// Where the recording of the loads at the nose is kept.
pub const NOSE_RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/records/milling_nose.csv");

/// The recording that a monitor of so many rows is fed with.
pub const fn record_of(rows: usize) -> &'static str {
    match rows {
        1 => RECORD,
        _ => NOSE_RECORD,
    }
}

/// Where loads are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// At the front bearing, which carries them, and the springs' preload.
    Bearing,
    /// At the nose of the shaft, 50 mm behind the cutter. The preload of a pair of bearings does not act there.
    Nose,
}

/// Force on the cutter over the load that it puts onto the front bearing. The cutter is 180 mm in
/// front of the rear bearing, the front bearing 100 mm.
const AT_CUTTER: f64 = 0.55;

/// Position of the cutter, m, the nose being at 0.
const CUTTER: f64 = -0.05;

/// Temperatures of the inner and of the outer side at the start of the cycle, degrees Celsius. Then
/// their rise for a spindle that has always been at 20,000 rpm, K.
const WARM: [[f64; 2]; 2] = [[26.0, 18.0], [24.5, 8.0]];

/// Length of the cycle, ms: a row each.
const LENGTH_MS: u32 = 20_000;

/// The time in which the tool runs into something, s.
pub const CRASH: [f64; 2] = [9.3, 9.395];

/// The time in which the tool drills, s.
const DRILLING: [f64; 2] = [5.6, 6.8];

/// Speed of a spindle that carries nothing, `(s, rpm)`; between these points it changes smoothly.
/// Rates of teeth are no multiples or simple fractions of the rates of ticks and of telemetry. So
/// ticks and telemetry meet every part of a tooth's load.
const SPEED: [(f64, f64); 19] = [
    (0.0, 0.0),
    (0.2, 0.0),
    (1.4, 11_900.0),
    (3.55, 11_900.0),
    (3.85, 5_700.0),
    (5.35, 5_700.0),
    (5.5, 4_250.0),
    (7.75, 4_250.0),
    (8.15, 11_900.0),
    (10.15, 11_900.0),
    (10.85, 0.0),
    (11.8, 0.0),
    (13.3, 19_000.0),
    (14.65, 19_000.0),
    (15.2, 7_300.0),
    (16.35, 7_300.0),
    (16.65, 3_150.0),
    (19.1, 3_150.0),
    (19.6, 0.0),
];

/// Axial force of the springs and of the tool's clamping on the bearing, `(s, N)`.
const CLAMPING: [(f64, f64); 8] = [
    (10.95, 420.0),
    // The release cylinder pushes the tool out.
    (11.05, 800.0),
    (11.2, 800.0),
    (11.3, 320.0),
    // No tool.
    (11.45, 320.0),
    // The next tool is drawn in.
    (11.5, 690.0),
    (11.6, 690.0),
    (11.7, 450.0),
];

/// Loads of a shaft that is a little askew, N m.
const MISALIGNMENT: [f64; 2] = [0.05, -0.12];

/// Lever of a radial force at the tool about the bearing, m. The overhang is 50 mm, but the bearings
/// behind take most of the moment. A shaft that turns by 0.1 mrad under 1,000 N tilts a B7005C with some 3 N m.
const ARM: f64 = 0.003;

/// Axial force over radial force at a tooth, for a helix of 17 degrees.
const AXIAL: f64 = 0.3;

struct Tool {
    /// From this time on, s.
    from: f64,
    teeth: u32,
    /// Unbalance, kg m.
    unbalance: f64,
}

impl Tool {
    const fn new(from: f64, teeth: u32, unbalance: f64) -> Self {
        Self {
            from,
            teeth,
            unbalance,
        }
    }
}

/// The first one also drills.
const TOOLS: [Tool; 2] = [Tool::new(0.0, 2, 6.0e-6), Tool::new(11.3, 1, 3.0e-6)];

/// Force of the last tooth over the first one's: the cutter's run-out.
const RUN_OUT: f64 = 0.85;

struct Cut {
    /// Start and end, s.
    time: [f64; 2],
    /// Direction of the force in the middle of a tooth's time in the cut, rad from +y towards +z.
    towards: f64,
    /// Largest radial force of a tooth, N.
    force: f64,
    /// Time of a tooth in the cut over the time between two teeth.
    engaged: f64,
}

const CUTS: [Cut; 8] = [
    // Slots at 395 teeth a second: one tooth leaves as the next one enters.
    Cut::new([2.05, 3.5], 0.0, 500.0, 1.0),
    // Shoulders at 190.
    Cut::new([3.95, 5.3], 0.5 * PI, 1000.0, 0.4),
    // Slots at 140.
    Cut::new([6.9, 7.7], PI, 400.0, 1.0),
    // Shoulders at 395.
    Cut::new([8.2, 9.0], -0.25 * PI, 1000.0, 0.5),
    // Slots with one tooth, at 316 a second.
    Cut::new([13.5, 14.6], 0.75 * PI, 500.0, 0.5),
    // Slots at 120.
    Cut::new([15.3, 16.3], -0.5 * PI, 800.0, 0.5),
    // Shoulders at 52.
    Cut::new([16.7, 17.7], 0.0, 1000.0, 0.3),
    // Plunging leaves a little of it.
    Cut::new([17.8, 18.5], 0.25 * PI, 150.0, 0.5),
];

/// Thrusts along the shaft: start and end, s, and force, N. With the preload, drilling makes some 1,200 N, and hardly any
/// radial load.
const THRUSTS: [([f64; 2], f64); 2] = [(DRILLING, 800.0), ([17.8, 18.5], 500.0)];

/// Course of a push: `(ms, N)`, straight between these points.
type Course = &'static [(f64, f64)];

/// The tool bends, the holder hits, the tool breaks.
const CRASHING: Course = &[
    (0.0, 0.0),
    (9.0, 2700.0),
    (30.0, 2700.0),
    (36.0, 4500.0),
    (75.0, 4500.0),
    (80.0, 2600.0),
    (90.0, 2400.0),
    (95.0, 0.0),
];
/// Up and down by 200 N/ms.
const RADIAL_RAMP: Course = &[(0.0, 0.0), (7.5, 1500.0), (40.0, 1500.0), (47.5, 0.0)];
const AXIAL_RAMP: Course = &[(0.0, 0.0), (10.0, 2000.0), (40.0, 2000.0), (50.0, 0.0)];

/// Forces that come and go: when they begin, s; their parts along x, y and z; their course.
const PUSHES: [(f64, [f64; 3], Course); 4] = [
    (CRASH[0], [AXIAL, 0.8, -0.6], CRASHING),
    (18.65, [0.0, 1.0, 0.0], RADIAL_RAMP),
    (18.8, [0.0, 0.0, -1.0], RADIAL_RAMP),
    (18.95, [1.0, 0.0, 0.0], AXIAL_RAMP),
];

/// Axial force on the nose while the tool is changed, `(s, N)`.
const RELEASE: [(f64, f64); 4] = [(10.95, 0.0), (11.05, 210.0), (11.2, 210.0), (11.3, 0.0)];

/// The recording of one cycle.
pub fn recorded(place: Place) -> Vec<LoadRow> {
    let mut random = Random::seeded(0x5EED_0FB7_005C);
    let mut turns = 0.0;
    let mut heat = 0.0;
    let mut hard = 0.5;
    let period = 1e-3;
    (0..=LENGTH_MS)
        .map(|ms| {
            let time = f64::from(ms) / 1e3;
            let tool = &TOOLS[usize::from(time >= TOOLS[1].from)];
            // Part of the material's hardness that varies, 0 to 1.
            hard += 0.01 * (random.between(0.0, 1.0) - hard);
            let material = 0.9 + 0.1 * hard;
            let effort: f64 = CUTS
                .iter()
                .map(|cut| cut.force * cut.engaged * presence(cut.time, time))
                .sum();
            let free = curve(&SPEED, time, smooth);
            // Under load the drive gives way by half a percent, give or take.
            let speed = free * (1.0 - 1e-5 * effort * material);
            turns += speed / 60.0 * period;
            heat += period / 25.0 * (free / 20e3 - heat);

            let angle = TAU * turns.fract();
            let omega = speed * PI / 30.0;
            let unbalance = tool.unbalance * omega * omega;
            let mut axial = 0.0;
            let mut radial = [unbalance * libm::cos(angle), unbalance * libm::sin(angle)];
            let mut add = |share: f64, [x, y, z]: [f64; 3]| {
                axial += share * x;
                radial[0] += share * y;
                radial[1] += share * z;
            };
            for cut in &CUTS {
                add(
                    material * presence(cut.time, time),
                    cut.force_of(tool, turns),
                );
            }
            for (span, force) in THRUSTS {
                add(material * presence(span, time), [force, 0.0, 0.0]);
            }
            for (from, along, course) in PUSHES {
                add(curve(course, 1e3 * (time - from), |part| part), along);
            }
            let temperatures = WARM.map(|[start, more]| rounded(start + more * heat, 100.0));
            let (part, held, arm, askew, temperatures) = match place {
                Place::Bearing => {
                    let held = curve(&CLAMPING, time, smooth) + 110.0 * heat;
                    (1.0, held, ARM, MISALIGNMENT, None)
                }
                Place::Nose => {
                    let held = curve(&RELEASE, time, smooth);
                    (AT_CUTTER, held, CUTTER, [0.0; 2], Some(temperatures))
                }
            };
            let axial = held + part * axial;
            let [fy, fz] = radial.map(|force| part * force + 1.2 * noise(&mut random));
            LoadRow {
                time_s: time,
                load: [
                    rounded(axial + 1.5 * noise(&mut random), 10.0),
                    rounded(fy, 10.0),
                    rounded(fz, 10.0),
                    rounded(askew[0] - arm * fz + 0.008 * noise(&mut random), 1e3),
                    rounded(askew[1] + arm * fy + 0.008 * noise(&mut random), 1e3),
                ],
                // The encoder counts, and so does not see movement where there is none.
                speed_rpm: rounded(speed * (1.0 + 5e-5 * noise(&mut random)), 1.0),
                temperatures,
                probes: [None; 4],
            }
        })
        .collect()
}

impl Cut {
    const fn new(time: [f64; 2], towards: f64, force: f64, engaged: f64) -> Self {
        Self {
            time,
            towards,
            force,
            engaged,
        }
    }

    /// Force on the cutter along x, y and z after so many turns of the spindle.
    fn force_of(&self, tool: &Tool, turns: f64) -> [f64; 3] {
        let teeth = f64::from(tool.teeth);
        let passed = turns * teeth;
        let is_last = passed.rem_euclid(teeth) >= teeth - 1.0 && tool.teeth > 1;
        let run_out = if is_last { RUN_OUT } else { 1.0 };
        let force = self.force * run_out * tooth(passed, self.engaged);
        // The force turns with the tooth.
        let part = passed.fract() / self.engaged;
        let at = self.towards + TAU * self.engaged / teeth * (part - 0.5);
        [AXIAL * force, force * libm::cos(at), force * libm::sin(at)]
    }
}

/// Part of a tooth's largest load after so many teeth have passed, a half-sine: each cuts for a part of the time between two.
pub fn tooth(passed: f64, engaged: f64) -> f64 {
    let part = passed.fract() / engaged;
    if part < 1.0 {
        libm::sin(PI * part)
    } else {
        0.0
    }
}

/// Smooth step from 0 to 1.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// 1 during a time span, with soft ends of a tenth of a second inside it.
fn presence([start, end]: [f64; 2], time: f64) -> f64 {
    const SOFT: f64 = 0.1;
    smooth((time - start) / SOFT) * smooth((end - time) / SOFT)
}

/// Value at `x` of a curve through points, each piece of it shaped by `shape`. Beyond the points, it
/// is the first or last point's.
pub fn curve(points: &[(f64, f64)], x: f64, shape: impl Fn(f64) -> f64) -> f64 {
    let after = points.partition_point(|point| point.0 <= x);
    let (x0, y0) = points[after.saturating_sub(1)];
    let (x1, y1) = points[after.min(points.len() - 1)];
    if x1 <= x0 || x <= x0 {
        return y0;
    }
    y0 + (y1 - y0) * shape((x - x0) / (x1 - x0))
}

/// Rounded to a fraction of 1, as sensors deliver it; never a negative zero.
fn rounded(x: f64, per_unit: f64) -> f64 {
    (x * per_unit).round() / per_unit + 0.0
}

/// Noise of standard deviation 1: the sum of twelve uniform numbers.
fn noise(random: &mut Random) -> f64 {
    (0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0
}
