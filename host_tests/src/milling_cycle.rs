//! A synthetic recording: what the front bearing of a small milling spindle carries in one cycle.
//!
//! Nothing here was measured. The forces are those of teeth passing through the work in a textbook
//! cutting law (force proportional to chip thickness), with run-out, uneven material, unbalance,
//! preload that grows with heat, and sensor noise; levels and timing are made up, within what a
//! B7005C carries in practice. `records/README.md` tells what happens when.
//!
//! The same rows come out everywhere: the noise comes from a generator with a fixed seed, and sines
//! from `libm` rather than from the platform.

use crate::loads::{COLUMNS, LoadRow};
use std::f64::consts::{PI, TAU};
use std::io::{self, Write};

/// Where the recording is kept.
pub const RECORD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/records/milling_cycle.csv");

/// Time between two rows, ms.
const PERIOD_MS: u32 = 10;

/// Length of the cycle, ms.
const LENGTH_MS: u32 = 72_000;

/// Speed of a spindle that carries nothing, `(s, rpm)`; between these points it changes smoothly.
const SPEED: [(f64, f64); 10] = [
    (0.0, 0.0),
    (3.0, 0.0),
    (8.0, 20_000.0),
    (31.0, 20_000.0),
    (35.0, 0.0),
    (42.0, 0.0),
    (46.0, 12_000.0),
    (65.0, 12_000.0),
    (69.0, 0.0),
    (72.0, 0.0),
];

/// What springs and the tool's clamping press axially onto the bearing, `(s, N)`.
const CLAMPING: [(f64, f64); 12] = [
    (0.0, 420.0),
    (36.5, 420.0),
    // The release cylinder pushes the tool out.
    (36.8, 800.0),
    (37.1, 800.0),
    (37.4, 320.0),
    // No tool.
    (39.3, 320.0),
    // The next tool is drawn in.
    (39.5, 690.0),
    (39.7, 690.0),
    (40.0, 450.0),
    (50.0, 450.0),
    (60.0, 450.0),
    (72.0, 450.0),
];

/// Loads of a shaft that is a little askew, N m.
const MISALIGNMENT: [f64; 2] = [0.05, -0.12];

/// Moment about the bearing for a radial force at the tool: the front bearing's share of it, m.
const ARM: f64 = 0.010;

struct Tool {
    /// From this time on, s.
    from: f64,
    teeth: u32,
    /// Radial offset of the cutter over the feed per tooth.
    run_out: f64,
    /// Unbalance, kg m.
    unbalance: f64,
}

const TOOLS: [Tool; 3] = [
    Tool {
        from: 0.0,
        teeth: 3,
        run_out: 0.15,
        unbalance: 3.0e-6,
    },
    Tool {
        from: 37.3,
        teeth: 4,
        run_out: 0.0,
        unbalance: 1.0e-6,
    },
    Tool {
        from: 39.4,
        teeth: 4,
        run_out: 0.2,
        unbalance: 12.0e-6,
    },
];

struct Cut {
    /// Start and end, s.
    time: [f64; 2],
    /// Feed direction, rad from +y towards +z.
    feed: f64,
    /// Tangential force of a tooth at full chip thickness, N.
    force: f64,
    /// Part of a turn during which a tooth cuts, from and to, rad from the feed direction.
    engaged: [f64; 2],
    /// Axial force over tangential force.
    axial: f64,
}

const CUTS: [Cut; 6] = [
    Cut {
        time: [10.0, 15.5],
        feed: 0.0,
        force: 230.0,
        engaged: [0.0, 0.5 * PI],
        axial: 0.35,
    },
    Cut {
        time: [17.0, 22.5],
        feed: PI,
        force: 230.0,
        engaged: [0.0, 0.5 * PI],
        axial: 0.35,
    },
    Cut {
        time: [24.0, 27.0],
        feed: 0.0,
        force: 70.0,
        engaged: [0.0, 0.25 * PI],
        axial: 0.3,
    },
    Cut {
        time: [27.8, 30.5],
        feed: 0.0,
        force: 45.0,
        engaged: [0.0, 0.25 * PI],
        axial: 0.3,
    },
    Cut {
        time: [48.0, 55.0],
        feed: 0.5 * PI,
        force: 150.0,
        engaged: [0.0, PI],
        axial: 0.4,
    },
    Cut {
        time: [61.5, 64.0],
        feed: 0.5 * PI,
        force: 60.0,
        engaged: [0.0, 0.25 * PI],
        axial: 0.3,
    },
];

/// Plunging: start and end, s, and axial force, N.
const PLUNGE: ([f64; 2], f64) = ([56.5, 60.0], 430.0);

/// The recording.
pub fn milling_cycle() -> Vec<LoadRow> {
    let mut noise = Noise(0x5EED_0FB7_005C);
    let mut turns = 0.0;
    let mut heat = 0.0;
    let mut uneven = 0.0;
    let period = f64::from(PERIOD_MS) / 1e3;
    (0..=LENGTH_MS / PERIOD_MS)
        .map(|i| {
            let time = f64::from(i * PERIOD_MS) / 1e3;
            let tool = TOOLS
                .iter()
                .rfind(|tool| time >= tool.from)
                .unwrap_or(&TOOLS[0]);
            uneven += 0.04 * (noise.next() - uneven);
            let free = profile(&SPEED, time);
            let effort: f64 = CUTS
                .iter()
                .map(|cut| cut.force * presence(cut.time, time))
                .sum();
            // Under load the drive gives way by half a percent, give or take.
            let speed = free * (1.0 - 2.3e-5 * effort * (1.0 + 0.3 * uneven));
            turns += speed / 60.0 * period;
            heat += period / 25.0 * (free / 20e3 - heat);

            let angle = TAU * turns.fract();
            let mut axial = profile(&CLAMPING, time) + 110.0 * heat;
            axial += PLUNGE.1 * presence(PLUNGE.0, time) * (1.0 + 0.3 * uneven);
            let omega = speed * PI / 30.0;
            let unbalance = tool.unbalance * omega * omega;
            let mut radial = [unbalance * libm::cos(angle), unbalance * libm::sin(angle)];
            for cut in &CUTS {
                let share = presence(cut.time, time) * (1.0 + uneven);
                let [along, across, up] = cut.forces(tool, angle);
                let (sin, cos) = (libm::sin(cut.feed), libm::cos(cut.feed));
                radial[0] += share * (along * cos - across * sin);
                radial[1] += share * (along * sin + across * cos);
                axial += share * up;
            }
            let [fy, fz] = radial.map(|force| force + 1.2 * noise.next());
            LoadRow {
                time_s: time,
                load: [
                    rounded(axial + 1.5 * noise.next(), 10.0),
                    rounded(fy, 10.0),
                    rounded(fz, 10.0),
                    rounded(MISALIGNMENT[0] - ARM * fz + 0.008 * noise.next(), 1e3),
                    rounded(MISALIGNMENT[1] + ARM * fy + 0.008 * noise.next(), 1e3),
                ],
                // The encoder counts, and so does not see movement where there is none.
                speed_rpm: rounded(speed * (1.0 + 5e-5 * noise.next()), 1.0),
            }
        })
        .collect()
}

/// Writes rows as a file of recorded loads.
///
/// # Errors
///
/// Those of the output.
pub fn write_csv(rows: &[LoadRow], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "{}", COLUMNS.join(","))?;
    for row in rows {
        let [fx, fy, fz, my, mz] = row.load;
        writeln!(
            out,
            "{},{fx},{fy},{fz},{my},{mz},{}",
            row.time_s, row.speed_rpm
        )?;
    }
    Ok(())
}

impl Cut {
    /// Force on the cutter along the feed, across it, and axial, at an angle of the spindle.
    fn forces(&self, tool: &Tool, angle: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for tooth in 0..tool.teeth {
            let place = f64::from(tooth) / f64::from(tool.teeth);
            let at = (angle + TAU * place) % TAU;
            if at < self.engaged[0] || at > self.engaged[1] {
                continue;
            }
            let (sin, cos) = (libm::sin(at), libm::cos(at));
            // In finishing, teeth touch near the thin end of the chip only; the force is scaled to
            // be the same there.
            let thickest = libm::sin(self.engaged[1].min(0.5 * PI));
            let chip = sin / thickest + tool.run_out * libm::cos(TAU * place);
            let tangential = self.force * chip.max(0.0);
            let radial = 0.35 * tangential;
            sum[0] -= tangential * cos + radial * sin;
            sum[1] += tangential * sin - radial * cos;
            sum[2] += self.axial * tangential;
        }
        sum
    }
}

/// Smooth step from 0 to 1.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// 1 during a time span, with soft ends of a third of a second inside it.
fn presence([start, end]: [f64; 2], time: f64) -> f64 {
    const SOFT: f64 = 1.0 / 3.0;
    smooth((time - start) / SOFT) * smooth((end - time) / SOFT)
}

/// Value at a time of a curve through points, smooth between them.
fn profile(points: &[(f64, f64)], time: f64) -> f64 {
    points
        .windows(2)
        .find(|ends| time <= ends[1].0)
        .map_or(points[points.len() - 1].1, |ends| {
            let ((t0, y0), (t1, y1)) = (ends[0], ends[1]);
            y0 + (y1 - y0) * smooth((time - t0) / (t1 - t0))
        })
}

/// Rounded to a fraction of 1, as sensors deliver it; never a negative zero.
fn rounded(x: f64, per_unit: f64) -> f64 {
    (x * per_unit).round() / per_unit + 0.0
}

/// Noise of standard deviation 1: the sum of twelve uniform numbers of a splitmix64 generator.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// From 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^= x >> 31;
        (x >> 11) as f64 / (1u64 << 53) as f64
    }
}
