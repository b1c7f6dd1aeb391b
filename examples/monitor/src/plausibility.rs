//! Doubts about samples: every one has its [`Mark`], and a sample with a mark is not solved.
//!
//! | doubt | against |
//! | --- | --- |
//! | range | lowest and highest value of each load, and of the speed |
//! | rate of change | the last good value, over the time since then |
//! | stuck value | the same bits so many times, in any channel ([`StuckWatch`]; bridges watch their counts) |
//! | saturation | a converter's rail (known to its source) |
//! | missing samples | a time without any |
//! | order and age | numbers and times of records (known to their source) |
//! | disagreement | redundant channels of one another, and two sources of speed |
//!
//! A value that changed too fast is not the new truth at once. It is held against the last good value:
//! as time goes by, it may have come that far. A true step is thus believed after a few samples, and a
//! spike never. A speed that falls to 0 faster than the shaft can is not believed, however long it reads 0: a tachometer
//! that fails reads 0, too. The last speed that was believed counts, until the shaft is seen to turn or somebody at the machine
//! says that it stands.

use crate::loads::LoadSample;
use crate::marks::{Mark, Marks, StuckWatch};
use enumset::enum_set;

/// Bounds of plausible loads and speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PlausibilitySettings {
    /// Lowest and highest of each load, N, N m.
    pub load: [[f32; 2]; 5],
    /// Fastest change of each load, N/s, N m/s.
    pub load_rate: [f32; 5],
    /// A load that gives one and the same value so many times is stuck; 0 for never.
    pub stuck_after: u16,
    /// Time without a sample that is one without loads, us.
    pub missing_after_us: u32,
    /// Age of an estimate beyond which it is no longer fresh, us.
    pub fresh_us: u32,
    /// Largest residual of redundant channels, counts; none for any.
    pub residual: Option<f32>,
    /// Highest speed in either direction, rad/s.
    pub speed: f32,
    /// Fastest change of speed, rad/s^2, from tick to tick. A source with a new value every few ticks
    /// makes the change of all of them in one.
    pub speed_rate: f32,
    /// The greatest deceleration of the shaft, rad/s^2: what its brake can do, and more.
    pub deceleration: f32,
    /// Equal speeds in a row, other than 0, after which the speed is stuck. 0: never, for a control that sends the speed
    /// it commands instead of one it measures.
    pub speed_stuck_after: u16,
    /// By how much two sources of speed may differ, rad/s, and as a part of the speed.
    pub speed_difference: [f32; 2],
}

impl PlausibilitySettings {
    /// The part of its range that the load farthest out takes: above 1 outside, no number if a load is none.
    pub fn part(&self, load: &[f32; 5]) -> f32 {
        let mut part: f32 = 0.0;
        for (load, [low, high]) in load.iter().zip(&self.load) {
            let bound = if *load < 0.0 { low } else { high };
            // Zero is within any range.
            let of = if *load == 0.0 { 0.0 } else { load / bound };
            if !(of <= part) {
                part = of;
            }
        }
        part
    }

    /// The square of some loads: each in parts of the larger bound of its range, and their squares added up.
    pub fn square(&self, load: &[f32; 5]) -> f32 {
        let mut square = 0.0;
        for (load, [low, high]) in load.iter().zip(&self.load) {
            let part = load / low.abs().max(high.abs());
            square += part * part;
        }
        square
    }
}

/// Readings of the sensors in a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Readings {
    /// Result of the source of loads.
    pub loads: Result<Option<LoadSample>, Marks>,
    /// Shaft speed from a source of its own, rad/s, if there is one; `Some(None)` if that source fails.
    pub speed: Option<Option<f32>>,
    /// Temperatures of the inner and of the outer side, degrees Celsius, if there are new ones. No number from a sensor
    /// that fails. See [`temperature`](crate::temperature).
    pub temperatures: Option<[f32; 2]>,
}

/// A sample that nothing speaks against.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GoodSample {
    /// When it was taken, us.
    pub time_us: u64,
    /// `Fx, Fy, Fz` (N), `My, Mz` (N m).
    pub load: [f32; 5],
    /// Shaft speed `omega`, rad/s.
    pub speed: f32,
}

/// Speed below which the shaft stands still, rad/s.
const STANDSTILL: f32 = 1.0;
/// Time at that speed after which it is believed to stand, us.
const STANDING_US: u64 = 5_000_000;

/// Holds samples against the bounds of plausible ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plausibility {
    /// The last good loads and speed, each with its time.
    load: Option<([f32; 5], u64)>,
    speed: Option<(f32, u64)>,
    /// Speed from the source of loads, which may sample more slowly than ticks go.
    carried: Option<f32>,
    stuck: StuckWatch<5>,
    speed_stuck: StuckWatch<1>,
    /// When the last sample came, good or not.
    heard: Option<u64>,
    /// Doubts about the last sample, and about the last speed, which hold until the next one.
    doubts: Marks,
    speed_doubts: Marks,
    /// The speed fell to 0 faster than the shaft can: whatever it reads, the shaft may turn until it is seen to.
    lost: bool,
    /// Since when it has stood, us.
    standing: Option<u64>,
}

impl Plausibility {
    /// Without a sample.
    pub const fn new(settings: &PlausibilitySettings) -> Self {
        Self {
            load: None,
            speed: None,
            carried: None,
            stuck: StuckWatch::new(settings.stuck_after),
            speed_stuck: StuckWatch::new(settings.speed_stuck_after),
            heard: None,
            doubts: Marks::new(),
            speed_doubts: enum_set!(Mark::SpeedMissing),
            lost: false,
            standing: None,
        }
    }

    /// The last speed that could be believed, rad/s; 0 before there is one.
    pub const fn last_speed(&self) -> f32 {
        match self.speed {
            Some((speed, _)) => speed,
            None => 0.0,
        }
    }

    /// The shaft has stood still for five seconds, beyond doubt, as of a speed that is not older than `oldest_us`.
    pub fn stands_still(&self, time_us: u64, oldest_us: u32) -> bool {
        let is_new = |(_, then): (f32, u64)| time_us.saturating_sub(then) <= oldest_us.into();
        let long = |since: u64| time_us.saturating_sub(since) >= STANDING_US;
        self.standing.is_some_and(long) && self.speed.is_some_and(is_new)
    }

    /// Somebody at the machine says that the shaft stands still.
    pub const fn stand(&mut self, time_us: u64) {
        self.lost = false;
        self.speed = Some((0.0, time_us));
    }

    /// Judges the readings of a tick. With a new sample that nothing speaks against, returns it; without
    /// a new sample, the doubts about the last one stay.
    pub fn judge(
        &mut self,
        time_us: u64,
        readings: &Readings,
        settings: &PlausibilitySettings,
    ) -> (Marks, Option<GoodSample>) {
        let heard = *self.heard.get_or_insert(time_us);
        let mut fresh = None;
        match &readings.loads {
            Ok(Some(sample)) => {
                self.heard = Some(time_us);
                self.carried = sample.speed.or(self.carried);
                self.doubts = self.loads(time_us, sample, settings);
                fresh = Some(sample);
            }
            Ok(None) => {
                let silent = time_us.saturating_sub(heard) > settings.missing_after_us.into();
                self.doubts.extend(silent.then_some(Mark::Missing));
            }
            Err(doubts) => {
                self.heard = Some(time_us);
                self.doubts = *doubts;
                // An error without a name is one all the same.
                self.doubts.extend(doubts.is_empty().then_some(Mark::Bus));
            }
        }
        let speed = self.speed(time_us, readings, settings, fresh.is_some());
        let marks = self.doubts.union(self.speed_doubts);
        let good = match (fresh, speed) {
            (Some(sample), Some(speed)) if marks.is_empty() => Some(GoodSample {
                time_us,
                load: sample.load,
                speed,
            }),
            _ => None,
        };
        (marks, good)
    }

    /// The speed, if it was believed in the tick of this time.
    pub(crate) fn speed_of(&self, time_us: u64) -> Option<f32> {
        let (speed, then) = self.speed?;
        (then == time_us && self.speed_doubts.is_empty()).then_some(speed)
    }

    /// The last speed, unless the newest reading of it is doubted.
    pub(crate) fn undoubted_speed(&self) -> Option<f32> {
        let (speed, _) = self.speed?;
        self.speed_doubts.is_empty().then_some(speed)
    }

    fn loads(
        &mut self,
        time_us: u64,
        sample: &LoadSample,
        settings: &PlausibilitySettings,
    ) -> Marks {
        let mut marks = sample.doubts;
        let finite = sample.load.iter().all(|load| load.is_finite());
        marks.extend((!finite || !sample.residual.is_finite()).then_some(Mark::NotFinite));
        let within = |(load, [low, high]): (&f32, &[f32; 2])| load >= low && load <= high;
        let in_range = sample.load.iter().zip(&settings.load).all(within);
        marks.extend((finite && !in_range).then_some(Mark::Range));
        marks.extend(
            (settings.residual.is_some_and(|most| sample.residual > most))
                .then_some(Mark::Disagreement),
        );
        let bits = sample.load.map(|load| load.to_bits() as i32);
        marks.extend(self.stuck.watch(bits).then_some(Mark::Stuck));
        if let Some((last, then)) = self.load {
            let time = seconds(then, time_us);
            let changes = sample.load.iter().zip(&last).zip(&settings.load_rate);
            let mut fast = false;
            for ((load, last), rate) in changes {
                fast |= (load - last).abs() > rate * time;
            }
            marks.extend(fast.then_some(Mark::Rate));
        }
        if marks.is_empty() {
            self.load = Some((sample.load, time_us));
        }
        marks
    }

    /// The speed, if it can be believed; doubts are left in `speed_doubts`. `fresh` if there is a new
    /// sample of loads, which may carry a speed.
    fn speed(
        &mut self,
        time_us: u64,
        readings: &Readings,
        settings: &PlausibilitySettings,
        fresh: bool,
    ) -> Option<f32> {
        let known = |speed: f32| speed.is_finite().then_some(speed);
        // The source of its own is heard every tick, and goes first.
        let own = readings.speed.map(|speed| speed.and_then(known));
        if own.is_none() && !fresh {
            return None;
        }
        let mut marks = Marks::new();
        let carried = self.carried.map(known);
        if let (Some(Some(a)), Some(Some(b))) = (own, carried) {
            let [absolute, relative] = settings.speed_difference;
            let allowed = absolute + relative * a.abs();
            marks.extend((!((a - b).abs() <= allowed)).then_some(Mark::SpeedDisagreement));
        }
        let speed = own.or(carried).flatten();
        if let Some(speed) = speed {
            marks.extend((!(speed.abs() <= settings.speed)).then_some(Mark::SpeedRange));
            let stuck = self.speed_stuck.watch([speed.to_bits() as i32]);
            marks.extend((stuck && speed != 0.0).then_some(Mark::SpeedStuck));
            let stands = speed.abs() <= STANDSTILL;
            if let Some((last, then)) = self.speed {
                let slows = speed.abs() < last.abs() && speed * last >= 0.0;
                let (rate, allowance) = if slows {
                    (settings.deceleration, STANDSTILL)
                } else {
                    (settings.speed_rate, 0.0)
                };
                let fast = (speed - last).abs() > rate * seconds(then, time_us) + allowance;
                self.lost = stands && (self.lost || fast);
                marks.extend((fast || self.lost).then_some(Mark::SpeedRate));
            }
            if !stands || !marks.is_empty() {
                self.standing = None;
            } else {
                self.standing.get_or_insert(time_us);
            }
        } else {
            marks.insert(Mark::SpeedMissing);
        }
        self.speed_doubts = marks;
        let good = speed.filter(|_| marks.is_empty());
        self.speed = good.map(|speed| (speed, time_us)).or(self.speed);
        good
    }
}

/// Seconds between two times in us.
pub(crate) fn seconds(from: u64, to: u64) -> f32 {
    let us = to.saturating_sub(from).min(u32::MAX.into()) as u32;
    us as f32 * 1e-6
}
