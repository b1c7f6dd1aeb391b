//! Levels of a tick, for the alarms to judge.

use crate::alarms::Alarm;
use crate::judgement::{Level, Levels};
use crate::plausibility::seconds;
use spindle_bearing::{Facing, Limit, RowSummary};

/// A second of ticks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Second {
    ticks: u32,
    /// Of these, ticks with a fresh estimate, and ticks that overran.
    fresh: u32,
    late: u32,
}

/// How well the monitor itself sees, second by second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Watch<const R: usize> {
    /// Number of balls of each row, and whether rows of either facing hold each other.
    balls: [u16; R],
    opposed: bool,
    /// Preload of each row, cold and at rest, N; 0 before it is known.
    mounted: [f32; R],
    /// The second that runs, when it began, and the last one.
    now: Second,
    began_us: u64,
    last: Second,
    /// Ticks that did not begin, as of the last tick.
    missed: u64,
    /// When a sample was good last, or when the monitor began, us.
    good_us: Option<u64>,
    /// When there was a fresh estimate last, us.
    fresh_us: Option<u64>,
}

/// Time over which ticks are counted, and without a fresh estimate after which the monitor is blind, us.
pub(crate) const SECOND_US: u32 = 1_000_000;

impl<const R: usize> Watch<R> {
    /// Of rows of so many balls, and of these facings.
    pub(crate) fn new(
        balls: impl IntoIterator<Item = u16>,
        facings: impl IntoIterator<Item = Facing>,
    ) -> Self {
        let (mut all, mut facings) = ([0; R], facings.into_iter());
        all.iter_mut()
            .zip(balls)
            .for_each(|(of, count)| *of = count);
        let first = facings.next();
        Self {
            balls: all,
            opposed: facings.any(|facing| Some(facing) != first),
            mounted: [0.0; R],
            now: Second::default(),
            began_us: 0,
            last: Second {
                ticks: 1,
                fresh: 1,
                late: 0,
            },
            missed: 0,
            good_us: None,
            fresh_us: None,
        }
    }

    /// Whether there was a fresh estimate within the last second.
    pub(crate) fn sees(&self, time_us: u64) -> bool {
        let is_new = |then: u64| time_us.saturating_sub(then) < SECOND_US.into();
        self.fresh_us.is_some_and(is_new)
    }

    /// Takes the rows of the mounted spindle, cold and at rest.
    pub(crate) fn mount(&mut self, rows: &[RowSummary<f32>]) {
        for (mounted, row) in self.mounted.iter_mut().zip(rows) {
            *mounted = row.preload;
        }
    }

    /// Whether rows of either facing hold each other.
    pub(crate) const fn is_opposed(&self) -> bool {
        self.opposed
    }

    /// Share of ticks with a fresh estimate in the last second, a part of 1.
    pub(crate) fn availability(&self) -> f32 {
        self.last.fresh as f32 / self.last.ticks as f32
    }

    /// Takes how well a tick sees: a sample without doubts, a fresh estimate, ticks before it that overran or did not
    /// begin (`missed` since the start).
    pub(crate) fn tick(
        &mut self,
        time_us: u64,
        [good, fresh, late]: [bool; 3],
        missed: u64,
        levels: &mut Levels,
    ) {
        let good_us = self.good_us.get_or_insert(time_us);
        if good {
            *good_us = time_us;
        }
        levels.set_value(Alarm::Sensor, seconds(*good_us, time_us));
        if fresh {
            self.fresh_us = Some(time_us);
        }
        let left_out = missed.saturating_sub(self.missed).min(u32::MAX.into()) as u32;
        self.missed = missed;
        let now = &mut self.now;
        now.ticks = now.ticks.saturating_add(left_out).saturating_add(1);
        now.fresh = now.fresh.saturating_add(fresh.into());
        now.late = now.late.saturating_add(late.into());
        let of_two = now.late.saturating_add(self.last.late);
        levels.set_value(Alarm::Deadline, of_two as f32);
        if time_us.saturating_sub(self.began_us) >= SECOND_US.into() {
            self.began_us = time_us;
            self.last = core::mem::take(now);
            levels.set_value(Alarm::Availability, 1.0 - self.availability());
        }
    }

    /// Takes the levels of an equilibrium. Balls are counted on from row to row.
    pub(crate) fn rows(&self, rows: &[RowSummary<f32>], levels: &mut Levels) {
        for (alarm, limit, least) in [
            (Alarm::PeakPressure, Limit::PeakPressure, 0.0),
            (Alarm::ContactAngle, Limit::Shoulder, f32::NEG_INFINITY),
            (Alarm::Slip, Limit::Friction, 0.0),
        ] {
            let mut worst = Level::of(least);
            let mut first = 0;
            for (row, count) in rows.iter().zip(&self.balls) {
                if let Some(margin) = row.margins.get(limit)
                    && margin.value > worst.value
                {
                    worst = Level {
                        value: margin.value,
                        place: Some(first + margin.ball),
                    };
                }
                first += count;
            }
            levels.set(alarm, worst);
        }
        let (mut unloaded, mut first) = (Level::of(0.0), 0);
        for (row, count) in rows.iter().zip(&self.balls) {
            if let Some(off) = row.margins.get(Limit::InnerContact) {
                unloaded.value += f32::from(row.margins.unloaded);
                unloaded.place = unloaded.place.or(Some(first + off.ball));
            }
            first += count;
        }
        levels.set(Alarm::UnloadedBalls, unloaded);
        let mut mounted = self.mounted.iter().take(rows.len());
        if !self.opposed || !mounted.all(|mounted| *mounted > 0.0) {
            return;
        }
        let (mut least, mut largest) = (f32::INFINITY, 0.0_f32);
        for (row, mounted) in rows.iter().zip(&self.mounted) {
            let part = row.preload / mounted;
            (least, largest) = (least.min(part), largest.max(part));
        }
        levels.set_value(Alarm::PreloadGrowth, largest);
        levels.set_value(Alarm::PreloadLoss, 1.0 - least);
    }
}

/// The level of measured loads, doubted or not, over the `most` that the spindle may carry. None if it is not known: the load that is
/// missing may be the largest, unless the others `raise` the alarm already.
pub(crate) fn overload(load: &[f32; 5], most: &[f32; 5], raise: f32) -> Option<f32> {
    let mut largest = 0.0_f32;
    for (load, most) in load.iter().zip(most) {
        if load.is_finite() {
            largest = largest.max(load.abs() / most);
        }
    }
    let is_known = load.iter().all(|load| load.is_finite());
    (is_known || largest >= raise).then_some(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_is_that_of_the_last_second_with_ticks_that_did_not_begin() {
        let mut seen = Watch::<1>::new([16], [Facing::PlusX]);
        let mut time = 0_u64;
        let mut share = |every: u64, missed: u64| {
            for _ in 0..2000 {
                time += 1000;
                let fresh = (time / 1000).is_multiple_of(every);
                seen.tick(time, [true, fresh, false], missed, &mut Levels::default());
            }
            seen.availability()
        };
        assert_eq!(share(1, 0), 1.0);
        assert!((share(2, 0) - 0.5).abs() < 2e-3);
        assert_eq!(share(1, 0), 1.0);
        let mut seen = Watch::<1>::new([16], [Facing::PlusX]);
        for ms in 1..=1000 {
            seen.tick(1000 * ms, [true; 3], 2 * ms, &mut Levels::default());
        }
        assert!((seen.availability() - 1.0 / 3.0).abs() < 1e-6);
    }

    /// A load that is no number takes no time off an overload that goes on.
    #[test]
    fn loads_that_are_missing_say_nothing_of_an_overload() {
        let of = |load: [f32; 5]| overload(&load, &[100.0, 100.0, 100.0, 5.0, 5.0], 1.0);
        assert_eq!(of([50.0, -80.0, 0.0, 0.0, 1.0]), Some(0.8));
        assert_eq!(of([f32::NAN, 0.0, f32::INFINITY, 0.0, 0.0]), None);
        assert_eq!(of([200.0, 0.0, 0.0, 0.0, f32::NAN]), Some(2.0));
    }
}
