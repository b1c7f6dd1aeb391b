//! A run by load steps, as blocks make them.

use crate::preload::spindles::{ARM, Cut, PROBES, SPEEDS, Used, normal};
use crate::preload::{DRIFT, Found, NOISE, RATE, RUNOUT, Row, STEPS};
use cli::random::Random;
use spindle_monitor::Probes;
use spindle_monitor::estimator::{Constants, Motion, Step};
use spindle_monitor::judgement::{AlarmChange, Judgement, Levels};
use spindle_monitor::revolutions::is_aliased;
use std::array::from_fn;
use std::f64::consts::{PI, TAU};

/// Steps of ten hours; of one; time of a step, s.
const TEN_HOURS: usize = 60_000;
const HOUR: usize = TEN_HOURS / 10;
const TIME: f64 = 0.6;
/// Most steps until commissioning.
const LONGEST: usize = 5000;
/// Steps from commissioning to a change, and after it.
const BEFORE: usize = 400;
const AFTER: usize = 600;

/// A block's step moves a probe by so many standard deviations.
const SEEN: f32 = 5.0;

/// Pairs of a block at a speed, and what is left of runout in its mean, um.
fn block(rpm: f64) -> (f64, f64) {
    assert!(
        !is_aliased(rpm as f32, RATE as f32),
        "{rpm} rpm stand still"
    );
    let turns = rpm / 60.0 / RATE;
    let off = |pairs: &i32| (f64::from(*pairs) * turns - (f64::from(*pairs) * turns).round()).abs();
    let best = (50..=100).min_by(|a, b| off(a).total_cmp(&off(b)));
    let pairs = f64::from(best.unwrap_or(50));
    let left = (PI * pairs * turns).sin() / (pairs * (PI * turns).sin());
    (pairs, RUNOUT * left.abs())
}

/// Runs a row: ten hours, or some steps after a change.
pub fn run(used: &mut Used, row: &Row, constants: &'static Constants, mut random: Random) -> Found {
    let (filed, mut found) = (used.filed, Found::default());
    let blocks = SPEEDS.map(block);
    let variances = blocks.map(|(pairs, left)| 2.0 * NOISE * NOISE / pairs + left * left);
    let variance = (variances.iter().sum::<f64>() / SPEEDS.len() as f64) as f32;
    let mut probes = Probes::with_constants(filed.settings, &filed.limits, 1000, constants);
    let mut judgement = Judgement::default();
    let mut cut = Cut::of(&mut random);
    let is_sound = row.what.is_always();
    let lost = random.below(8 * HOUR) + HOUR;
    for step in 0.. {
        let last = match found.commissioned {
            None => LONGEST,
            Some(_) if is_sound => TEN_HOURS,
            Some(at) => at + BEFORE + AFTER,
        };
        if step >= last {
            break;
        }
        let changed = found
            .commissioned
            .map(|at| at + BEFORE)
            .filter(|at| !is_sound && step >= *at);
        if changed == Some(step) {
            used.change(row.what);
            found.alarms = Default::default();
        }
        used.wander(&mut random, TIME);
        if step % STEPS == 0 && row.what.is_mixed(step) {
            cut = Cut::of(&mut random);
        }
        // A temperature is lost for an hour: no step counts.
        if is_sound && (lost..lost + HOUR).contains(&step) {
            continue;
        }
        let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
        let measured = used.measured(cut);
        let estimator = probes.estimator();
        let angles = from_fn(|i| estimator.fed_angle(i).into());
        let computed = used.computed(cut, estimator.fed_preload().into(), angles);
        let [x, y, z, my, mz] = used.load(cut);
        let load = [x, y, z, my / ARM, mz / ARM].map(|load| (sign * load) as f32);
        let (pairs, left) = blocks[cut.speed];
        let motions: [_; PROBES] = from_fn(|i| {
            let noise = (2.0 / pairs).sqrt() * NOISE * normal(&mut random)
                + left * (random.between(0.0, TAU).sin() - random.between(0.0, TAU).sin())
                + TIME * DRIFT;
            let [along, across, by_preload] = computed[i].map(|u| (sign * u) as f32);
            let motion = Motion {
                measured: (sign * measured[i] + noise) as f32,
                computed: along,
                across,
                by_preload,
                noise: variance,
            };
            let is_seen = along * along > SEEN * SEEN * variance;
            (is_seen && row.only.is_none_or(|only| only == i)).then_some(motion)
        });
        let (time_us, mut levels) = ((1e6 * TIME) as u64 * step as u64, Levels::default());
        probes.step(time_us, Step { motions, load }, &mut levels);
        let after = changed.or(found.commissioned).map(|from| step + 1 - from);
        for change in &judgement.judge(time_us, &levels, &filed.limits, |_| 2_000_000) {
            if change.change == AlarmChange::Raised {
                judgement.acknowledge(change.alarm);
                found.raise(change.alarm, after);
            }
        }
        if found.commissioned.is_none() && probes.estimator().is_commissioned() {
            found.commissioned = Some(step + 1);
        }
        if is_sound && found.commissioned.is_some_and(|at| step >= at + HOUR) {
            found.judge(&probes.report(&judgement), used.preload());
        }
    }
    let estimator = probes.estimator();
    let change = estimator.preload_change();
    let gains = [0, 1].map(|i| estimator.gain_change(i).value);
    found.end = [change.value, change.error, gains[0], gains[1]].map(f64::from);
    found.finish(&probes.report(&judgement));
    found
}
