//! Health of board, monitor and link in words.

use super::state::State;
use spindle_file::reading::short;
use spindle_monitor::TemperatureSource;
use spindle_monitor::board::{BoardReport, Check, ResetCause};
use spindle_monitor::retained::{Recovery, StartReport};
use spindle_monitor::telemetry::HealthReport;

/// Least share of ticks with a fresh estimate that is well.
const AVAILABLE: f32 = 0.9;

/// Sentences about the monitor. Counts of 0, and whatever is as it should be, are left out.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Health {
    /// Troubles of the monitor, the board and the link.
    pub wrong: Vec<String>,
    /// Figures that tell of no trouble.
    pub rest: Vec<String>,
}

impl Health {
    /// Health by the last reports.
    pub fn of(state: &State) -> Self {
        let mut health = Self::default();
        if let Some(board) = &state.board {
            health.board(board);
        }
        if let Some(start) = &state.start {
            health.start(start);
        }
        if let Some(report) = &state.health {
            health.counts(report);
            health.temperatures(report);
            health.retention(report, state.probes.is_some());
        }
        health.link(state);
        health
    }

    fn say(&mut self, is_wrong: bool, words: impl Into<String>) {
        let list = if is_wrong {
            &mut self.wrong
        } else {
            &mut self.rest
        };
        list.push(words.into());
    }

    fn count(&mut self, is_wrong: bool, count: u64, what: &str) {
        if count > 0 {
            self.say(is_wrong, format!("{count} {what}"));
        }
    }

    fn board(&mut self, board: &BoardReport) {
        for (check, what) in [
            (board.known_answer, "a solve"),
            (board.image, "code in flash"),
        ] {
            match check {
                Check::Failed => self.say(true, format!("self-check of {what} failed")),
                Check::Passed => self.say(false, format!("self-check of {what} passed")),
                Check::NotYet | Check::Unchecked => {}
            }
        }
        match board.brown_out {
            Some(0) => self.say(false, "brown-out reset is off"),
            Some(level) => self.say(false, format!("brown-out level {level}")),
            None => {}
        }
        let stack = board.unused_stack.unwrap_or_default();
        self.count(false, stack.into(), "bytes of stack never used");
    }

    fn start(&mut self, start: &StartReport) {
        use ResetCause as C;
        let is_wrong = matches!(
            start.cause,
            C::BrownOut | C::Watchdog | C::WindowWatchdog | C::LowPower
        );
        let number = match start.boots {
            0 => "start".into(),
            boots => format!("start {boots}"),
        };
        match start.cause {
            C::Unknown if start.boots == 0 => {}
            C::Unknown => self.say(false, number),
            cause => self.say(is_wrong, format!("{number} by {}", cause.name())),
        }
    }

    fn counts(&mut self, of: &HealthReport) {
        let fresh = of.availability;
        let share = short(f64::from(100.0 * fresh));
        self.say(
            fresh < AVAILABLE,
            format!("{share} % of ticks with a fresh estimate"),
        );
        self.count(true, of.overruns, "ticks past their deadline");
        self.count(true, of.missed_ticks, "ticks that never began");
        self.count(true, of.records.corrupt, "load records damaged");
        self.count(true, of.records.lost, "load records lost");
        self.count(true, of.records.disordered, "load records out of order");
        self.count(true, of.records.late, "load records late");
        self.count(false, of.ticks, "ticks");
        self.count(false, of.estimates, "estimates");
        self.count(false, of.refusals, "solves without an answer");
        self.count(false, of.marked_samples, "samples doubted");
        self.count(false, of.records.received, "load records");
        self.count(false, of.records.passed_over, "load records passed over");
        self.count(false, of.frames_dropped, "frames dropped by a slow link");
        self.count(false, of.most_cycles.into(), "cycles in the longest tick");
        self.count(false, of.revolutions, "revolutions");
        self.count(false, of.doubtful_revolutions, "doubtful revolutions");
        if of.life_used > 0.0 {
            let [used, part] = [of.life_used, of.life_estimated].map(|part| 100.0 * part);
            self.say(
                false,
                format!("{used:.2e} % of life used, {part:.2e} % by estimate"),
            );
        }
    }

    fn temperatures(&mut self, of: &HealthReport) {
        use TemperatureSource as S;
        let sides = ["inner", "outer"].into_iter().zip(of.temperatures);
        for ((side, temperature), source) in sides.zip(of.temperature_sources) {
            let how = match source {
                S::Unused => continue,
                S::Measured => "",
                S::Held => " is held: not measured any more",
                S::Assumed => " is assumed: not measured for long",
            };
            self.say(
                source != S::Measured,
                format!("{side} side {temperature:.1} °C{how}"),
            );
        }
    }

    fn retention(&mut self, of: &HealthReport, has_probes: bool) {
        let kept = of.retention;
        let estimates = has_probes.then_some((kept.estimates, "estimates of the probes"));
        let recovered = [(kept.recovery, "life and alarms")];
        for (recovery, what) in recovered.into_iter().chain(estimates) {
            let why = match recovery {
                Recovery::NoMemory | Recovery::Blank | Recovery::Recovered => continue,
                Recovery::OtherSpindle => "those kept are another spindle's",
                Recovery::OtherVersion => "those kept are another version's",
                Recovery::Damaged => "those kept are damaged",
            };
            self.say(true, format!("{what} begin at 0: {why}"));
        }
        if kept.recovery == Recovery::NoMemory {
            self.say(true, "no memory: life and alarms are lost with the power");
        }
        self.count(true, kept.damaged.into(), "kept records damaged");
        self.count(
            true,
            kept.failed.into(),
            "records not kept: the flash is worn or full",
        );
        self.count(false, kept.written.into(), "records kept");
    }

    fn link(&mut self, state: &State) {
        let tally = &state.tally;
        self.say(tally.lost + tally.damaged > 0, format!("link: {tally}"));
        if let Some(error) = state.last_damage {
            self.say(true, format!("last damage: {error}"));
        }
    }
}
