//! Alarms that latch: levels, held against their thresholds.
//!
//! They serve firmware without the rest of the monitor, too: half a kilobyte of flash.
//!
//! - **Alarm.** A condition begins where a level reaches `raise`, and ends where it has fallen to `clear`
//!   ([`Threshold`]). Its time is added up; time without it is taken off at a quarter of the rate. A condition that comes
//!   and goes, as teeth pass, counts like a lasting one if it is there for more than a fifth of the time. The alarm is
//!   raised when the sum reaches the hold time, or when the level reaches `at_once`. When the sum has run off, the
//!   condition is gone, but the alarm stays latched until somebody acknowledges it. An acknowledged alarm whose
//!   level grows further by `worse` is raised again. A level that is not known changes nothing. A level stands until the next one,
//!   for as long as that is due at most: the time after that counts for neither.

use crate::alarms::{Alarm, Threshold};
use enumset::EnumSet;
use serde::{Deserialize, Serialize};

/// Where an alarm stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AlarmState {
    /// No condition, nothing to acknowledge.
    #[default]
    Clear,
    /// The condition is there, or was, but not yet for its hold time.
    Pending,
    /// The condition stands, and nobody has acknowledged it.
    Raised,
    /// Active, acknowledged by an operator.
    Acknowledged,
    /// The condition is gone, but nobody has acknowledged it.
    Latched,
}

impl AlarmState {
    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Pending => "pending",
            Self::Raised => "raised",
            Self::Acknowledged => "acknowledged",
            Self::Latched => "latched",
        }
    }
}

/// A level that an alarm watches, and its place.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Level {
    /// In the unit of the [`Alarm`].
    pub value: f32,
    /// The worst ball, counted on from row to row, or the worst probe, if it is about one.
    pub place: Option<u16>,
}

impl Level {
    /// A level that is about no ball and no probe.
    pub const fn of(value: f32) -> Self {
        Self { value, place: None }
    }
}

/// Change of an alarm, for which a report is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AlarmChange {
    /// The condition has stood for its hold time.
    Raised,
    /// The condition is gone.
    Cleared,
    /// Somebody has acknowledged the alarm.
    Acknowledged,
    /// Nothing changed: the alarm stands, or is in the state that a full queue held back.
    Standing,
}

/// Time without a condition takes this part of itself off the condition's time.
const FADE: u32 = 4;

/// One alarm's memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AlarmMachine {
    state: AlarmState,
    /// The condition is there, as of this time, us; and its time, added up.
    there: bool,
    seen_us: u64,
    held_us: u32,
    level: f32,
    place: Option<u16>,
    /// Highest level that somebody was told of.
    worst: f32,
    raised: u32,
    cleared: u32,
}

impl AlarmMachine {
    /// Where it stands.
    pub const fn state(&self) -> AlarmState {
        self.state
    }

    /// How often it was raised, and how often its condition went away.
    pub const fn counts(&self) -> (u32, u32) {
        (self.raised, self.cleared)
    }

    /// The last level, and its place.
    pub const fn level(&self) -> Level {
        Level {
            value: self.level,
            place: self.place,
        }
    }

    /// Holds a level against its threshold. The level before it has stood for `due_us` at most.
    pub fn update(
        &mut self,
        time_us: u64,
        level: Level,
        threshold: &Threshold,
        due_us: u32,
    ) -> Option<AlarmChange> {
        use AlarmState as S;
        // Most levels are far off: a third of the cost.
        let clear = self.state == S::Clear && !self.there && self.held_us == 0;
        if clear && level.value < threshold.raise && !threshold.is_at_once(level.value) {
            (self.level, self.place, self.seen_us) = (level.value, level.place, time_us);
            return None;
        }
        // A level that is no number tells nothing.
        if level.value.is_nan() {
            return None;
        }
        (self.level, self.place) = (level.value, level.place);
        let since = time_us.saturating_sub(self.seen_us).min(due_us.into()) as u32;
        self.seen_us = time_us;
        self.held_us = if self.there {
            self.held_us.saturating_add(since).min(threshold.hold_us)
        } else {
            self.held_us.saturating_sub(since / FADE)
        };
        self.there = if self.there {
            level.value > threshold.clear
        } else {
            level.value >= threshold.raise
        };
        if threshold.is_at_once(level.value) {
            self.held_us = threshold.hold_us;
        }
        let gone = !self.there && self.held_us == 0;
        let held = !gone && self.held_us >= threshold.hold_us;
        match self.state {
            S::Clear | S::Pending if held => self.raise(),
            S::Clear | S::Pending => {
                self.state = if gone { S::Clear } else { S::Pending };
                None
            }
            // A latched alarm is known to be one, and needs no hold time to be one again.
            S::Latched if self.there => {
                self.held_us = threshold.hold_us;
                self.raise()
            }
            S::Acknowledged
                if threshold
                    .worse
                    .is_some_and(|step| level.value - self.worst >= step) =>
            {
                self.raise()
            }
            S::Raised if gone => self.clear(S::Latched),
            S::Acknowledged if gone => self.clear(S::Clear),
            S::Raised => {
                self.worst = self.worst.max(level.value);
                None
            }
            _ => None,
        }
    }

    fn raise(&mut self) -> Option<AlarmChange> {
        (self.state, self.worst) = (AlarmState::Raised, self.level);
        self.raised = self.raised.saturating_add(1);
        Some(AlarmChange::Raised)
    }

    fn clear(&mut self, to: AlarmState) -> Option<AlarmChange> {
        self.state = to;
        self.cleared = self.cleared.saturating_add(1);
        Some(AlarmChange::Cleared)
    }

    /// It was raised before a power cycle, and nobody has acknowledged it.
    const fn latch(&mut self) {
        if matches!(self.state, AlarmState::Clear | AlarmState::Pending) {
            self.state = AlarmState::Latched;
        }
    }

    /// Somebody has seen it.
    pub const fn acknowledge(&mut self) -> Option<AlarmChange> {
        self.state = match self.state {
            AlarmState::Raised => AlarmState::Acknowledged,
            AlarmState::Latched => AlarmState::Clear,
            _ => return None,
        };
        Some(AlarmChange::Acknowledged)
    }

    /// Whether there is something to know about it.
    pub const fn stands(&self) -> bool {
        matches!(
            self.state,
            AlarmState::Raised | AlarmState::Acknowledged | AlarmState::Latched
        )
    }
}

/// The levels of a tick, one for each alarm; none where nothing is known.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Levels([Option<Level>; Alarm::COUNT]);

impl Levels {
    /// Takes the level of an alarm.
    pub const fn set(&mut self, alarm: Alarm, level: Level) {
        self.0[alarm as usize] = Some(level);
    }

    /// Takes the level of an alarm that is about no ball and no probe.
    pub const fn set_value(&mut self, alarm: Alarm, value: f32) {
        self.set(alarm, Level::of(value));
    }
}

/// An alarm that changed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Change {
    /// Which.
    pub alarm: Alarm,
    /// How.
    pub change: AlarmChange,
}

/// The changes of one tick. Each alarm changes once a tick at most.
pub type Changes = heapless::Vec<Change, { Alarm::COUNT }>;

/// All alarms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Judgement {
    alarms: [AlarmMachine; Alarm::COUNT],
    /// Alarms raised and cleared so far.
    raised: u64,
    cleared: u64,
}

impl Judgement {
    /// One alarm.
    pub fn alarm(&self, alarm: Alarm) -> &AlarmMachine {
        // As many as there are names.
        &self.alarms[alarm as usize]
    }

    /// Alarms that were raised and that nobody has acknowledged. To be kept over a power cycle.
    pub fn unacknowledged(&self) -> EnumSet<Alarm> {
        let open = |alarm: &Alarm| {
            let state = self.alarm(*alarm).state();
            matches!(state, AlarmState::Raised | AlarmState::Latched)
        };
        Alarm::ALL.into_iter().filter(open).collect()
    }

    /// Latches the alarms that nobody had acknowledged before a power cycle ([`Judgement::unacknowledged`]).
    pub fn latch(&mut self, alarms: EnumSet<Alarm>) {
        for (machine, alarm) in self.alarms.iter_mut().zip(Alarm::ALL) {
            if alarms.contains(alarm) {
                machine.latch();
            }
        }
    }

    /// Alarms raised and cleared so far.
    pub const fn counts(&self) -> (u64, u64) {
        (self.raised, self.cleared)
    }

    /// Holds the levels of a tick against their thresholds; the alarms that changed. A level of an alarm stands for the time in
    /// which the next one is due, us, at most.
    pub fn judge(
        &mut self,
        time_us: u64,
        levels: &Levels,
        thresholds: &[Threshold; Alarm::COUNT],
        due_us: impl Fn(Alarm) -> u32,
    ) -> Changes {
        let mut changes = Changes::new();
        let machines = self.alarms.iter_mut().zip(thresholds).zip(Alarm::ALL);
        for (((machine, threshold), alarm), level) in machines.zip(levels.0) {
            let Some(change) =
                level.and_then(|level| machine.update(time_us, level, threshold, due_us(alarm)))
            else {
                continue;
            };
            match change {
                AlarmChange::Raised => self.raised = self.raised.saturating_add(1),
                AlarmChange::Cleared => self.cleared = self.cleared.saturating_add(1),
                AlarmChange::Acknowledged | AlarmChange::Standing => {}
            }
            // There is room for one of each.
            let _ = changes.push(Change { alarm, change });
        }
        changes
    }

    /// Somebody has seen an alarm.
    pub fn acknowledge(&mut self, alarm: Alarm) -> Option<AlarmChange> {
        self.alarms[alarm as usize].acknowledge()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const THRESHOLD: Threshold = Threshold {
        raise: 10.0,
        clear: 8.0,
        hold_us: 3000,
        at_once: Some(100.0),
        worse: Some(2.5),
    };

    const DUE_US: u32 = 20_000;

    fn run(machine: &mut AlarmMachine, from: u64, levels: &[f32]) -> Vec<(u64, AlarmChange)> {
        let mut changes = Vec::new();
        for (time, level) in (from..).zip(levels) {
            let level = Level::of(*level);
            if let Some(change) = machine.update(time * 1000, level, &THRESHOLD, DUE_US) {
                changes.push((time, change));
            }
        }
        changes
    }

    #[test]
    fn an_alarm_is_raised_after_its_hold_time_and_stays_until_acknowledged() {
        let mut a = AlarmMachine::default();
        // Too short, then long enough though it falls below the upper level meanwhile.
        let changes = run(&mut a, 0, &[9.9, 10.0, 12.0, 8.0, 10.0, 9.0, 8.1]);
        assert_eq!(changes, [(6, AlarmChange::Raised)]);
        // Gone when its three milliseconds have run off, at a quarter of the rate.
        let mut quiet = [8.0; 13];
        quiet[0] = f32::NAN;
        assert_eq!(run(&mut a, 7, &quiet), []);
        assert_eq!(run(&mut a, 20, &[9.9]), [(20, AlarmChange::Cleared)]);
        assert_eq!(a.state(), AlarmState::Latched);
        // Latched, it needs no hold time.
        assert_eq!(run(&mut a, 21, &[10.0, 10.0]), [(21, AlarmChange::Raised)]);
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        assert_eq!(a.acknowledge(), None);
        assert_eq!(a.state(), AlarmState::Acknowledged);
        assert_eq!(run(&mut a, 23, &[0.0; 14]), [(35, AlarmChange::Cleared)]);
        assert_eq!((a.state(), a.counts()), (AlarmState::Clear, (2, 2)));
        assert_eq!(a.acknowledge(), None);
    }

    #[test]
    fn an_acknowledged_alarm_that_grows_worse_is_raised_again_at_each_step() {
        let mut a = AlarmMachine::default();
        assert_eq!(run(&mut a, 0, &[10.0, 10.0, 10.0, 12.0]).len(), 1);
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        // From the highest level before the acknowledgement on.
        assert_eq!(run(&mut a, 4, &[10.0, 14.4, 11.0]), []);
        assert_eq!(run(&mut a, 7, &[14.5, 14.6]), [(7, AlarmChange::Raised)]);
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        assert_eq!(run(&mut a, 9, &[17.0, 17.2]), [(10, AlarmChange::Raised)]);
        assert_eq!(a.counts(), (3, 0));
        // No further than infinite.
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        let endless = [f32::INFINITY; 2];
        assert_eq!(run(&mut a, 11, &endless), [(11, AlarmChange::Raised)]);
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        assert_eq!(run(&mut a, 13, &endless), []);
    }

    #[test]
    fn a_condition_that_comes_and_goes_counts_and_a_rare_one_does_not() {
        let (mut often, mut rare) = (AlarmMachine::default(), AlarmMachine::default());
        let levels = |every: u32| -> Vec<f32> {
            (0..1000)
                .map(|i| if i % every == 0 { 10.0 } else { 0.0 })
                .collect()
        };
        assert_eq!(run(&mut often, 0, &levels(4))[0].1, AlarmChange::Raised);
        assert_eq!(run(&mut often, 1000, &levels(4)), []);
        assert_eq!(run(&mut rare, 0, &levels(6)), []);
        // A level stands for no longer than until the next one is due.
        let mut unknown = AlarmMachine::default();
        let hold = Threshold {
            hold_us: 100_000,
            ..THRESHOLD
        };
        for (ms, level) in [(0, 10.0), (10_000, 10.0), (20_000, 0.0)] {
            let level = Level::of(level);
            assert_eq!(unknown.update(ms * 1000, level, &hold, DUE_US), None);
        }
        // A level that is far too high is not waited for.
        assert_eq!(
            run(&mut rare, 1000, &[100.0]),
            [(1000, AlarmChange::Raised)]
        );
    }

    #[test]
    fn without_a_hold_time_the_first_level_raises() {
        let threshold = Threshold {
            hold_us: 0,
            ..THRESHOLD
        };
        let mut a = AlarmMachine::default();
        let change = a.update(5, Level::of(f32::INFINITY), &threshold, DUE_US);
        assert_eq!(change, Some(AlarmChange::Raised));
        a.update(6, Level::of(0.0), &threshold, DUE_US);
        assert_eq!(a.acknowledge(), Some(AlarmChange::Acknowledged));
        assert_eq!(a.state(), AlarmState::Clear);
    }
}
