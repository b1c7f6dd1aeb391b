//! The estimator over load steps of a made-up spindle, whose truth is known.

use spindle_monitor::estimator::{Constants, Estimate, Estimator, Motion, Step};
use spindle_monitor::preload::{PreloadBy, PreloadLaw};
use spindle_monitor::{ProbeSettings, ResponseSettings};

const fn probe(direction: [f32; 3]) -> ProbeSettings {
    ProbeSettings {
        position: -0.01,
        direction,
        accuracy: 0.2,
        compliance: 0.3,
    }
}

pub static SETTINGS: ResponseSettings<2> = ResponseSettings {
    probes: [probe([1.0, 0.0, 0.0]), probe([0.0, 0.8, 0.6])],
    preload: Some(PreloadLaw {
        force: 250.0,
        by: PreloadBy::Closure {
            rows: 0b11,
            closures: [0.0, 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6, 7e-6, 8e-6],
            heat: [0.0; 2],
        },
    }),
    heat: 0.0,
    load_error: 0.02,
    gain: 0.1,
};

/// A spindle whose motion falls with its preload.
#[derive(Clone, Copy)]
pub struct Truth {
    /// ln preload, gains of both probes, and the angle of the second one.
    preload: f32,
    gains: [f32; 2],
    angle: f32,
    seed: u32,
}

impl Truth {
    const SOUND: Self = Self {
        preload: -0.2,
        gains: [1.05, 0.95],
        angle: 0.1,
        seed: 1,
    };

    /// A number between -1 and 1, the same in every run.
    fn random(&mut self) -> f32 {
        self.seed = self
            .seed
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        (self.seed >> 8) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Motions by a load step, at the preload and the angle that the estimator has told.
    fn step(&mut self, estimator: &Estimator<2>) -> Step<2> {
        let [x, y, z] = [0; 3].map(|_| 10.0 * self.random());
        // Motions, and the slopes of the first two: the larger a load, the less depends on the preload.
        let seen = |ln: f32, angle: f32| {
            let [along, across] = [x * x, y * y + z * z].map(|square| square / 64.0);
            let give = |square: f32, power: f32| (ln.exp() + square).powf(-power);
            let slope = |square: f32, power: f32| -power * ln.exp() / (ln.exp() + square);
            let [u, v, w] = [
                x * give(along, 0.8),
                y * give(across, 0.3),
                z * give(across, 0.3),
            ];
            let (sin, cos) = angle.sin_cos();
            let [v, w] = [cos * v + sin * w, cos * w - sin * v];
            ([u, v, w], [slope(along, 0.8) * u, slope(across, 0.3) * v])
        };
        let (truth, _) = seen(self.preload, self.angle);
        let (fed, angle) = (estimator.fed_preload(), estimator.fed_angle(1));
        let ([u, v, across], slopes) = seen(fed, angle);
        let motions = core::array::from_fn(|i| {
            Some(Motion {
                measured: self.gains[i] * truth[i] + 0.05 * self.random(),
                computed: [u, v][i],
                across: [0.0, across][i],
                by_preload: slopes[i],
                noise: 0.03 * 0.03,
            })
        });
        Step {
            motions,
            load: [x, y, z, 0.0, 0.0],
        }
    }

    fn teach(&mut self, estimator: &mut Estimator<2>, steps: usize) {
        for _ in 0..steps {
            let step = self.step(estimator);
            estimator.take(&step, true);
            estimator.feed();
        }
    }
}

fn new() -> Estimator<2> {
    Estimator::new(&SETTINGS, &Constants::USUAL)
}

/// A commissioned estimator of a sound spindle.
pub fn taught() -> Estimator<2> {
    let mut estimator = new();
    let mut truth = Truth::SOUND;
    truth.teach(&mut estimator, 300);
    estimator
}

fn assert_within(found: Estimate, truth: f32, most: f32) {
    let off = (found.value - truth).abs();
    assert!(
        off < 3.0 * found.error && off < most,
        "{found:?}, not {truth}"
    );
}

#[test]
fn preload_gains_and_angle_are_found_whatever_the_file_says() {
    for (preload, gains, angle) in [
        (0.0, [1.0, 1.0], 0.0),
        (-0.35, [1.1, 0.9], 0.35),
        (0.3, [0.9, 1.1], -0.35),
    ] {
        let mut truth = Truth {
            preload,
            gains,
            angle,
            seed: 7,
        };
        let mut estimator = new();
        truth.teach(&mut estimator, 150);
        assert!(!estimator.is_commissioned());
        assert!(!estimator.commission());
        truth.teach(&mut estimator, 150);
        assert!(estimator.is_commissioned());
        assert_within(estimator.preload(), preload, 0.03);
        for (i, gain) in gains.into_iter().enumerate() {
            assert_within(estimator.gain(i), gain, 0.03);
        }
        assert!((estimator.fed_angle(1) - angle).abs() < 0.02);
    }
}

#[test]
fn a_change_is_told_from_one_of_a_gain() {
    let mut lost = Truth {
        preload: -0.2 - 0.22,
        ..Truth::SOUND
    };
    let mut estimator = taught();
    lost.teach(&mut estimator, 60);
    assert_within(estimator.preload_change(), -0.22, 0.05);
    assert!(estimator.gain_change(1).value.abs() < 0.02);
    let mut soft = Truth {
        gains: [1.05, 0.95 * 1.1],
        ..Truth::SOUND
    };
    let mut estimator = taught();
    // At first the error of the load cells takes a part of it.
    soft.teach(&mut estimator, 60);
    assert!(estimator.gain_change(1).value > 0.06);
    soft.teach(&mut estimator, 240);
    assert_within(estimator.gain_change(1), 0.1, 0.02);
    assert!(estimator.preload_change().value.abs() < 0.03);
    // An order makes it the one to compare with.
    assert!(estimator.commission());
    assert_eq!(estimator.gain_change(1).value, 0.0);
    assert_within(estimator.gain(1), 0.95 * 1.1, 0.02);
}

#[test]
fn a_blow_is_left_out_and_a_probe_that_does_not_follow_brings_no_step() {
    let (mut estimator, mut truth) = (taught(), Truth::SOUND);
    let before = estimator.preload();
    for _ in 0..20 {
        let mut blow = truth.step(&estimator);
        for motion in blow.motions.iter_mut().flatten() {
            motion.measured += 40.0 * motion.computed.signum();
        }
        estimator.take(&blow, true);
        truth.teach(&mut estimator, 3);
    }
    assert!((estimator.preload().value - before.value).abs() < 0.02);
    assert!(!estimator.is_unexplained());
    // The sign of the second one.
    let mut swapped = Truth {
        gains: [1.05, -0.95],
        ..truth
    };
    swapped.teach(&mut estimator, 80);
    assert!(estimator.is_at_fault(1) && !estimator.is_at_fault(0));
    assert!((estimator.gain(1).value - 0.95).abs() < 0.02);
    assert!(estimator.ratio(1).is_some_and(|ratio| ratio < 0.0));
    truth.teach(&mut estimator, 20);
    assert!(!estimator.is_at_fault(1));
}

#[test]
fn ten_million_steps_leave_it_as_sharp_as_some_thousand() {
    let (mut estimator, mut truth) = (taught(), Truth::SOUND);
    truth.teach(&mut estimator, 5000);
    let some = [
        estimator.preload().error,
        estimator.preload_change().error,
        estimator.gain(0).error,
    ];
    for _ in 0..100 {
        truth.teach(&mut estimator, 100_000);
        let now = [
            estimator.preload().error,
            estimator.preload_change().error,
            estimator.gain(0).error,
        ];
        for (now, some) in now.into_iter().zip(some) {
            assert!(now > 0.3 * some && now < 3.0 * some, "{now}, not {some}");
        }
        assert_within(estimator.preload(), truth.preload, 0.05);
    }
}

/// Any bits: no number that is none is handed on.
#[test]
fn no_motion_spoils_it() {
    let (mut estimator, mut truth) = (taught(), Truth::SOUND);
    for _ in 0..2000 {
        let mut step = truth.step(&estimator);
        for motion in step.motions.iter_mut().flatten() {
            let any = [0; 5].map(|_| 10_f32.powf(20.0 * truth.random()) * truth.random());
            let [measured, computed, across, by_preload, noise] = any;
            *motion = Motion {
                measured,
                computed,
                across,
                by_preload,
                noise: noise.abs(),
            };
        }
        step.load = [0; 5].map(|_| 10_f32.powf(20.0 * truth.random()) * truth.random());
        estimator.take(&step, true);
        estimator.feed();
        let all = [
            estimator.preload(),
            estimator.preload_change(),
            estimator.gain(0),
            estimator.gain(1),
        ];
        assert!(
            all.iter()
                .all(|one| one.value.is_finite() && one.error.is_finite()),
            "{all:?}"
        );
    }
}
