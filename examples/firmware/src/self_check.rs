//! The board's self-checks: all of them before ticks begin, and then again and again between ticks.

use crate::dog::{Watchdogs, feed_at_start};
use crate::memory::{Stack, image, seal};
use crate::spindle::{BALLS, FREEDOMS, JOINTS, KNOWN_LOAD, PERIOD_US, ROWS, SPINDLE};
use spindle_bearing::{RacewayControlFree, SpindleSolver};
use spindle_monitor::BoardReport;
use spindle_monitor::board::Check;
use spindle_monitor::self_check::{ImageCheck, KnownAnswer, Seal};
use spindle_monitor::tick::CycleCounter;

/// Ticks from one solve whose answer is known to the next: a minute.
const MINUTE: u32 = 60_000_000 / PERIOD_US;
/// Bytes of the image, and words of the stack, in a step between ticks, and cycles enough for both.
/// A byte takes ten, with wait states of the flash, a word some. 127 KB of flash are gone through in 500 ticks.
const BYTES: usize = 256;
const WORDS: u32 = 64;
const CYCLES: u32 = 5000;

/// The solver of the known answer.
pub type KnownSolver = SpindleSolver<f32, ROWS, BALLS, RacewayControlFree, FREEDOMS, JOINTS>;

/// The checks, and their report.
pub struct SelfCheck<'m> {
    image: Option<ImageCheck>,
    answer: KnownAnswer<'m, ROWS, BALLS, FREEDOMS, JOINTS>,
    /// Checksum that the answer is to have.
    expected: Option<u32>,
    /// Cycles that the longest step of that solve took at the start, and a quarter more.
    answer_cycles: u32,
    stack: Stack,
    /// Bytes of it that were never used, and the figure in the log.
    unused: u32,
    logged: u32,
    /// The stack is a part of the report.
    tells_stack: bool,
    report: BoardReport,
    /// Ticks since the last solve began.
    ticks: u32,
    /// There was a step since the last tick.
    stepped: bool,
}

impl<'m> SelfCheck<'m> {
    /// Makes all checks once. `lock_step` is to give the same report as a host, which has no stack to measure.
    pub fn start<W: Watchdogs>(
        report: BoardReport,
        solver: &'m mut KnownSolver,
        lock_step: bool,
        core_hz: u32,
        counter: &mut impl CycleCounter,
    ) -> Self {
        let (image, expected) = match seal() {
            Seal::Closed { image: sum, answer } => {
                (Some(ImageCheck::new(image(), sum)), Some(answer))
            }
            Seal::Open | Seal::Damaged => (None, None),
        };
        let mut checks = Self {
            image,
            answer: KnownAnswer::new(&SPINDLE, KNOWN_LOAD, solver),
            expected,
            answer_cycles: 0,
            stack: Stack::default(),
            unused: u32::MAX,
            logged: u32::MAX,
            tells_stack: !lock_step,
            report,
            ticks: 0,
            stepped: false,
        };
        checks.report.image = match seal() {
            Seal::Open => Check::Unchecked,
            // Without its seal there is no telling what else is damaged.
            Seal::Damaged => Check::Failed,
            Seal::Closed { .. } => Check::NotYet,
        };
        let us = |from: u32, to: u32| to.wrapping_sub(from) / (core_hz / 1_000_000).max(1);

        let began = counter.cycles();
        while checks.report.image == Check::NotYet {
            feed_at_start::<W>();
            checks.step_image(16 * BYTES);
        }
        let read = counter.cycles();
        while checks.report.known_answer == Check::NotYet {
            feed_at_start::<W>();
            let before = counter.cycles();
            checks.step_answer();
            let took = counter.cycles().wrapping_sub(before);
            checks.answer_cycles = checks.answer_cycles.max(took.saturating_add(took / 4));
        }
        let solved = counter.cycles();
        let length = checks.image.as_ref().map_or(0, ImageCheck::length);
        defmt::info!(
            "self-check: image {=str}, {=usize} bytes in {=u32} us; known answer {=str} in {=u32} us",
            checks.report.image.name(),
            length,
            us(began, read),
            checks.report.known_answer.name(),
            us(read, solved)
        );
        while checks.unused == u32::MAX {
            feed_at_start::<W>();
            checks.step_stack(16 * WORDS);
        }
        checks.tell(BoardReport::NONE);
        checks
    }

    /// Report of the checks so far.
    pub const fn report(&self) -> BoardReport {
        self.report
    }

    /// After a tick.
    pub fn ticked(&mut self) {
        self.ticks = self.ticks.saturating_add(1);
        self.stepped = false;
    }

    /// Between ticks, so many cycles before the next one. One step a tick, so that bytes go in and out meanwhile.
    /// Whether there is something new.
    pub fn step_within(&mut self, left: u32) -> bool {
        if self.stepped {
            return false;
        }
        let before = self.report;
        // A core that never has the time takes it after another minute.
        let is_late = self.ticks >= 2 * MINUTE;
        if self.ticks >= MINUTE && (left > self.answer_cycles || is_late) {
            self.stepped = true;
            self.step_answer();
        } else if left > CYCLES {
            self.stepped = true;
            self.step_image(BYTES);
            self.step_stack(WORDS);
        }
        self.report != before || self.unused != self.logged
    }

    /// Logs checks that have failed since the report `before`, and a new figure of the stack.
    pub fn tell(&mut self, before: BoardReport) {
        if self.unused != self.logged {
            self.logged = self.unused;
            defmt::info!("{=u32} bytes of stack not used so far", self.unused);
        }
        let failed = |now: Check, before: Check| now == Check::Failed && before != now;
        if failed(self.report.image, before.image) {
            defmt::error!("self-check: the image in flash is not the one that was flashed");
        }
        if failed(self.report.known_answer, before.known_answer) {
            defmt::error!("self-check: a solve does not give the answer that is known");
        }
    }

    fn step_image(&mut self, bytes: usize) {
        if let Some(passed) = self.image.as_mut().and_then(|image| image.step(bytes)) {
            self.report.image = self.report.image.and(passed);
        }
    }

    fn step_answer(&mut self) {
        if let Some(sum) = self.answer.step() {
            self.ticks = 0;
            self.report.known_answer = match self.expected {
                None => Check::Unchecked,
                Some(expected) => self.report.known_answer.and(sum == expected),
            };
        }
    }

    fn step_stack(&mut self, words: u32) {
        if let Some(unused) = self.stack.step(words) {
            self.unused = unused;
            if self.tells_stack {
                self.report.unused_stack = Some(unused);
            }
        }
    }
}
