//! Load steps: means of measured and computed motion over whole revolutions, and their differences where the loads change.
//!
//! A mean over a block of whole revolutions leaves out runout; a difference of two leaves out temperature and offset. Blocks between which
//! the loads go on changing in one direction are one step, from the last block before to the last one of them. No block is part of two
//! steps, so that the errors of steps are independent.

use crate::estimator::{Motion, Step};
use crate::revolutions::{LONGEST, is_aliased, length, shortest};
use crate::settings::ResponseSettings;

/// Change of speed from block to block that is steady, part of 1.
const STEADY: f32 = 0.01;
/// A load step moves the shaft by more than so many standard deviations of a difference.
const STEP: f32 = 5.0;
/// Differences that the median of the noise is followed over.
const QUIET: f32 = 32.0;
/// Square of the median of a normal number's amount.
const MEDIAN: f32 = 0.455;
/// Variance of the readings of a block, over the median of all blocks, beyond which it is not runout: coolant, a chip.
const HIT: f32 = 4.0;
/// Twice the pairs for which a value has repeated although it should have moved, until the probe is at fault.
const STUCK: u8 = 100;
/// Least variance of the noise, um^2.
const LEAST: f32 = 1e-6;
/// Differences that a probe's accuracy counts as, where the variance begins.
const PRIOR: f32 = 4.0;
/// A moment counts as a force so far away, 1/m: 50 mm, as at a tool.
pub const PER_ARM: f32 = 20.0;
/// No probe measures so far, um: sums of such numbers would not be finite.
const FARTHEST: f32 = 1e6;

/// Figures of a probe that are taken at some solves of a block: their sums, or their means.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Look {
    /// Motion across the probe, um.
    pub across: f32,
    /// Change of the computed motion per change of ln preload, um.
    pub by_preload: f32,
}

/// Means of a block at a probe, um.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Mean {
    /// Not a number where too few readings came, or coolant.
    measured: f32,
    computed: f32,
    look: Look,
}

/// Means of a block: at the probes, and of the loads.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Block<const P: usize> {
    probes: [Mean; P],
    load: [f32; 5],
}

/// A probe, and its part of the block that runs.
#[derive(Debug, Clone, Copy)]
struct Probe {
    accuracy: f32,
    /// The first pair, measured and computed; sums less that; sums of squares, of measured less computed and of computed; count.
    first: [f32; 2],
    sum: [f32; 2],
    squares: [f32; 2],
    pairs: u32,
    look: Look,
    /// The last measured value, computed displacement when it came, and evidence that it should have changed since.
    value: f32,
    since: f32,
    stuck: u8,
    /// Medians, and of how many: variance of differences without a step, and of the readings of a block.
    quiet: f32,
    quiets: f32,
    within: f32,
    blocks: f32,
}

impl Probe {
    const fn new(accuracy: f32) -> Self {
        Self {
            accuracy,
            first: [0.0; 2],
            sum: [0.0; 2],
            squares: [0.0; 2],
            pairs: 0,
            look: Look {
                across: 0.0,
                by_preload: 0.0,
            },
            value: f32::NAN,
            since: f32::NAN,
            stuck: 0,
            quiet: accuracy * accuracy,
            quiets: PRIOR,
            within: 0.0,
            blocks: 0.0,
        }
    }

    /// Least computed motion, squared, that can be told from noise: a tenth of a reading's accuracy at least.
    fn least(&self) -> f32 {
        let resolved = 0.1 * self.accuracy;
        (STEP * STEP * self.quiet).max(resolved * resolved)
    }

    /// Takes a measured displacement, which may be no number, beside the computed one.
    fn add(&mut self, m: f32, p: f32) {
        let is_there = m.abs() < FARTHEST;
        if (is_there && m != self.value) || self.since.is_nan() {
            (self.value, self.since, self.stuck) = (m, p, 0);
        } else {
            let moved = (p - self.since) * (p - self.since);
            let far = moved > self.least().max(self.accuracy * self.accuracy);
            self.stuck = match far {
                _ if self.stuck >= STUCK => STUCK,
                true => self.stuck + 2,
                false => self.stuck.saturating_sub(1),
            };
        }
        if !is_there {
            return;
        }
        if self.pairs == 0 {
            (self.first, self.sum, self.squares) = ([m, p], [0.0; 2], [0.0; 2]);
        }
        let [m, p] = [m - self.first[0], p - self.first[1]];
        self.sum[0] += m;
        self.sum[1] += p;
        self.squares[0] += (m - p) * (m - p);
        self.squares[1] += p * p;
        self.pairs += 1;
    }

    /// Means of the block of so many pairs, in which there were so many looks.
    fn mean(&mut self, pairs: u32, looks: f32) -> Mean {
        let count = self.pairs as f32;
        let is_whole = 2 * self.pairs > pairs && self.stuck < STUCK / 10;
        let [m, p] = self.sum.map(|sum| sum / count);
        let [off, moved] = self.squares.map(|square| square / count);
        let [off, moved] = [off - (m - p) * (m - p), moved - p * p];
        // A probe follows the loads of a block to within half of their motion.
        let least = self.accuracy * self.accuracy;
        let is_hit = off > HIT * (self.within + least) + 0.25 * moved;
        if self.blocks == 0.0 && off.is_finite() {
            (self.within, self.blocks) = (off.clamp(LEAST, FARTHEST), PRIOR);
        }
        follow(&mut self.within, &mut self.blocks, off);
        let [m, p] = [m + self.first[0], p + self.first[1]];
        self.pairs = 0;
        let Look { across, by_preload } = core::mem::take(&mut self.look);
        Mean {
            measured: if is_whole && !is_hit { m } else { f32::NAN },
            computed: if is_whole { p } else { f32::NAN },
            look: Look {
                across: across / looks,
                by_preload: by_preload / looks,
            },
        }
    }
}

/// Follows the median of numbers: half of all are larger than it, however far blows go.
fn follow(median: &mut f32, counted: &mut f32, number: f32) {
    if number.is_finite() {
        *counted = (*counted + 1.0).min(QUIET);
        let part = if number > *median { 1.0 } else { -1.0 } / *counted;
        *median = (*median * (1.0 + part)).clamp(LEAST, FARTHEST);
    }
}

/// Blocks of `P` probes.
#[derive(Debug, Clone)]
pub struct Blocks<const P: usize> {
    /// Pairs in a second.
    rate: f32,
    /// Speed of the last block, rpm; sum over this block, its ticks so far and its length: 0 if it does not count.
    speed: f32,
    speeds: f32,
    ticks: u32,
    length: u32,
    /// Sum of the loads, and their count; count of looks.
    load: [f32; 5],
    loads: f32,
    looks: f32,
    probes: [Probe; P],
    /// The block from which the loads change, the last one, and the ticks in between.
    from: Option<Block<P>>,
    last: Option<Block<P>>,
    age: u32,
}

impl<const P: usize> Blocks<P> {
    /// Of probes that give a pair `rate` times a second (Hz).
    pub fn new(settings: &'static ResponseSettings<P>, rate: f32) -> Self {
        Self {
            rate,
            speed: 0.0,
            speeds: 0.0,
            ticks: 0,
            length: 0,
            load: [0.0; 5],
            loads: 0.0,
            looks: 0.0,
            probes: settings
                .probes
                .each_ref()
                .map(|probe| Probe::new(probe.accuracy)),
            from: None,
            last: None,
            age: 0,
        }
    }

    /// Takes a look at a solve of the block that runs.
    pub fn look(&mut self, looks: &[Look; P]) {
        self.looks += 1.0;
        for (probe, look) in self.probes.iter_mut().zip(looks) {
            probe.look.across += look.across;
            probe.look.by_preload += look.by_preload;
        }
    }

    /// Takes a tick: its speed (rpm), its loads with the computed displacements (um), and the measured ones. Returns whether it ends a block,
    /// and the load step that is complete then.
    ///
    /// A speed that is not believed is no number, nor is a measured value that a probe did not give. Nothing is computed without a fresh
    /// solution, or under loads that are none.
    pub fn tick(
        &mut self,
        rpm: f32,
        computed: Option<(&[f32; 5], [f32; P])>,
        measured: &[f32; P],
    ) -> Option<Option<Step<P>>> {
        if !rpm.is_finite() {
            self.restart(0.0);
            return None;
        }
        if !((rpm - self.speed).abs() <= STEADY * self.speed.abs()) {
            self.restart(rpm);
        }
        self.speeds += rpm - self.speed;
        self.ticks += 1;
        if let Some((load, computed)) =
            computed.filter(|(_, all)| all.iter().all(|p| p.is_finite()))
        {
            for ((probe, p), m) in self.probes.iter_mut().zip(computed).zip(measured) {
                probe.add(*m, p);
            }
            self.loads += 1.0;
            self.load
                .iter_mut()
                .zip(load)
                .for_each(|(sum, load)| *sum += load);
        }
        if self.ticks == self.length {
            let step = self.end();
            self.begin(self.speed + self.speeds / self.ticks as f32);
            return Some(step);
        }
        if self.length == 0 && self.ticks as f32 > shortest(self.rate) {
            self.restart(rpm);
        }
        None
    }

    /// Whether a probe repeats a value that should have changed.
    pub fn is_stuck(&self, probe: usize) -> bool {
        let probe = self.probes.get(probe);
        probe.is_some_and(|probe| probe.stuck >= STUCK)
    }

    /// Whether blocks do not count at the speed of now ([`is_aliased`]).
    pub fn is_aliased(&self) -> bool {
        is_aliased(self.speed, self.rate)
    }

    /// Forgets the blocks so far: the solves have learnt another preload.
    pub fn forget(&mut self) {
        self.restart(self.speed);
    }

    /// Begins a block at a speed.
    fn begin(&mut self, rpm: f32) {
        self.length = length(rpm, self.rate).unwrap_or(0);
        (self.speed, self.speeds, self.ticks) = (rpm, 0.0, 0);
        (self.load, self.loads, self.looks) = ([0.0; 5], 0.0, 0.0);
    }

    /// Begins a block that does not follow another one.
    fn restart(&mut self, rpm: f32) {
        self.begin(rpm);
        (self.from, self.last, self.age) = (None, None, 0);
        for probe in &mut self.probes {
            (probe.pairs, probe.look) = (0, Look::default());
        }
    }

    /// Ends a block; the step that is complete, if one is.
    #[inline(never)]
    fn end(&mut self) -> Option<Step<P>> {
        let (ticks, looks) = (self.ticks, self.looks);
        let block = Block {
            probes: self.probes.each_mut().map(|probe| probe.mean(ticks, looks)),
            load: self.load.map(|sum| sum / self.loads),
        };
        self.age += ticks;
        let goes_on = self.goes_on(&block);
        let (from, last) = (self.from, self.last.replace(block));
        if goes_on && self.age as f32 <= LONGEST * self.rate {
            return None;
        }
        (self.from, self.age) = (Some(block), 0);
        self.step(&from?, &last?)
    }

    /// Whether the loads go on changing as they did up to the last block. Differences without a change are noise.
    fn goes_on(&mut self, block: &Block<P>) -> bool {
        let (Some(from), Some(last)) = (&self.from, &self.last) else {
            return false;
        };
        let (mut moves, mut along) = (false, 0.0);
        let means = block.probes.iter().zip(&last.probes).zip(&from.probes);
        for (probe, ((now, last), from)) in self.probes.iter_mut().zip(means) {
            let (change, least) = (now.computed - last.computed, probe.least());
            if change * change > least {
                moves = true;
                along += change * (last.computed - from.computed) / least;
            } else if change * change <= probe.quiet {
                let residual = now.measured - last.measured - change;
                follow(
                    &mut probe.quiet,
                    &mut probe.quiets,
                    residual * residual / MEDIAN,
                );
            }
        }
        moves && along >= 0.0
    }

    /// The load step from one block to another; none if it moves no probe.
    #[inline(never)]
    fn step(&mut self, from: &Block<P>, to: &Block<P>) -> Option<Step<P>> {
        let change: [f32; 5] = core::array::from_fn(|i| to.load[i] - from.load[i]);
        let motions = core::array::from_fn(|i| {
            let probe = &self.probes[i];
            let (to, from) = (&to.probes[i], &from.probes[i]);
            let computed = to.computed - from.computed;
            let motion = Motion {
                measured: to.measured - from.measured,
                computed,
                across: to.look.across - from.look.across,
                by_preload: to.look.by_preload - from.look.by_preload,
                noise: probe.quiet,
            };
            let is_whole = (motion.measured + motion.across + motion.by_preload).is_finite();
            (computed * computed > probe.least() && is_whole && probe.stuck < STUCK)
                .then_some(motion)
        });
        if !motions.iter().any(Option::is_some) {
            return None;
        }
        Some(Step {
            motions,
            load: forces(&change),
        })
    }
}

/// Loads with their moments as forces.
pub(crate) fn forces([x, y, z, my, mz]: &[f32; 5]) -> [f32; 5] {
    [*x, *y, *z, PER_ARM * my, PER_ARM * mz]
}
