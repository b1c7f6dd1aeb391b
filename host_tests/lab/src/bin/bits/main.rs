//! Checksums of the answers to a fixed set of cases. `.ci/targets` compares them between targets.

#![cfg_attr(any(target_arch = "arm", target_arch = "riscv32"), no_std, no_main)]

#[cfg(any(target_arch = "arm", target_arch = "riscv32"))]
#[allow(unsafe_code, reason = "there is no operating system")]
mod bare;

use core::array::from_fn;
use core::fmt::{self, Debug, Write};
use spindle_bearing::*;

/// Few balls, for small memories.
const N: usize = 8;
const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
const RPM: [f64; 4] = [0.0, 6e3, 2e4, 4e4];
const LOADS: [[f64; 5]; 4] = [
    [300.0, 0.0, 0.0, 0.0, 0.0],
    [350.0, 80.0, 0.0, 0.0, 1.0],
    [300.0, -60.0, 50.0, 0.7, -0.4],
    [900.0, 250.0, -200.0, -1.0, 0.5],
];

/// FNV-1a over printed answers: of a number, `Debug` prints the digits that tell all its bits.
struct Checksum(u64);

impl Write for Checksum {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        Ok(())
    }
}

impl Checksum {
    fn add(&mut self, answer: impl Debug) {
        write!(self, "{answer:?}").unwrap();
    }

    fn add_bearing<T: Real, M: Motion, const D: usize>(&mut self, bearing: &Bearing<T, N>) {
        let mut solver = Solver::<T, N, M, D>::of();
        let (limits, rating) = (Limits::DEFAULT, rating());
        let speeds = if M::AT_SPEED { &RPM[..] } else { &RPM[..1] };
        for (&rpm, load) in speeds.iter().flat_map(|rpm| LOADS.map(|load| (rpm, load))) {
            solver.reset();
            // From nothing, and warm.
            for factor in [1.0, 1.02] {
                let load: [T; D] = from_fn(|i| T::of(factor * load[i]));
                let speed = Speed::rpm(T::of(rpm));
                let s = solver
                    .solve(bearing, load, speed, &Settings::DEFAULT)
                    .unwrap();
                self.add((
                    s.snapshot(),
                    s.summary(&limits, &rating),
                    s.rating_life(&rating),
                ));
                s.kinematics().for_each(|motion| self.add(motion));
            }
        }
    }

    fn add_pair<T: Real, const D: usize>(&mut self, pair: Spindle<'_, T, 2, N, D>) {
        let mut solver = SpindleSolver::<T, 2, N, RacewayControlFree, D>::of();
        for (rpm, load) in RPM.iter().flat_map(|rpm| LOADS.map(|load| (*rpm, load))) {
            let (load, speed) = (load.map(|x| T::of(0.5 * x)), Speed::rpm(T::of(rpm)));
            let s = solver
                .solve(&pair, load, speed, &Settings::DEFAULT)
                .unwrap();
            self.add(s.snapshot());
            let rows = s.summary(&Limits::DEFAULT, &[rating(); 2]);
            rows.for_each(|row| self.add(row));
        }
    }
}

fn rating<T: Real>() -> LifeRating<T> {
    LifeRating {
        inner: T::of(3e3),
        outer: T::of(4e3),
    }
}

fn checksum<T: Real>() -> u64 {
    // The target makes the constants of the design, too.
    let bearing = &Bearing::<T, N>::of(core::hint::black_box(&DESIGN)).unwrap();
    let mut sum = Checksum(0xcbf2_9ce4_8422_2325);
    sum.add_bearing::<T, Static, 5>(bearing);
    sum.add_bearing::<T, Centrifugal, 5>(bearing);
    sum.add_bearing::<T, OuterRaceControl, 5>(bearing);
    sum.add_bearing::<T, RacewayControlFree, 3>(bearing);
    sum.add_bearing::<T, RacewayControlFree, 5>(bearing);
    let (set, distance, force) = (Arrangement::BackToBack, T::of(0.06), T::of(200.0));
    sum.add_pair(Spindle::pair(set, bearing, distance, Preload::Force(force)).unwrap());
    let sliding = Mounted::new(bearing, distance, Facing::MinusX).with(Preload::Spring);
    let rows = [Mounted::new(bearing, T::ZERO, Facing::PlusX), sliding];
    sum.add_pair(Spindle::sprung(set, rows, force).unwrap());
    sum.0
}

/// Checksum for JavaScript to print.
#[cfg(target_arch = "wasm32")]
#[allow(unsafe_code, reason = "a name for the caller")]
#[unsafe(no_mangle)]
extern "C" fn bits(double: bool) -> u64 {
    if double {
        checksum::<f64>()
    } else {
        checksum::<f32>()
    }
}

#[cfg(not(any(target_arch = "arm", target_arch = "riscv32")))]
fn main() {
    println!("{:016x} {:016x}", checksum::<f32>(), checksum::<f64>());
}
