//! Measured displacement of the shaft over the computed one, while loads step: the stiffness that the spindle really has.
//!
//! Means of measured and computed displacement over whole revolutions leave out runout. Differences `m`, `p` of following means
//! leave out temperature and offset. Of the differences over load steps,
//!
//! ```text
//! ratio = S(mp) / S(pp)        error^2 = s^2 S(p (p - p')) / S(pp)^2
//! ```
//!
//! with the variance `s^2` of a difference and the difference `p'` before `p`, which shares a mean with it. Two memories forget
//! old steps, some 4 and some 40 steps long. The reference is the ratio at commissioning: constant errors of the model and of gains
//! cancel.
//!
//! A harmonic of the revolution near a multiple of the sampling rate looks like a drift ([`is_aliased`]).

use serde::{Deserialize, Serialize};
use spindle_bearing::sqrt_f32;

/// Harmonics of the revolution that runout has.
const HARMONICS: u16 = 4;
/// Least blocks in a second, and least pairs of a block.
const BLOCKS: f32 = 20.0;
const PAIRS: f32 = 50.0;
/// Longest block, s: below 30 rpm blocks do not count.
const LONGEST: f32 = 2.0;
/// Change of speed from block to block that is steady, part of 1.
const STEADY: f32 = 0.01;
/// A load step moves the shaft by more than so many standard deviations of a difference.
const STEP: f32 = 5.0;
/// A displacement that is computed to move by less than this part of the probe's accuracy is no load step.
const RESOLVED: f32 = 0.1;
/// Differences that the variance is a mean of.
const QUIET: f32 = 64.0;
/// Weight of that variance beside residuals of the steps, in steps.
const PRIOR: f32 = 4.0;
/// Parts of both memories that each step leaves: of two thirds of a change, the short one knows after 2 steps, of 95 % after 6.
const KEEP: [f32; 2] = [0.6, 39.0 / 41.0];
/// Standard errors that a change must have.
const ERRORS: f32 = 3.0;
/// Standard errors where a memory has fewer differences than [`FEW`], so that chance raises no alarm in a day.
const ERRORS_OF_FEW: f32 = 5.0;
/// Weight of differences, each at first 1, below which a memory has few: the short one always, the long one at its beginning.
const FEW: f32 = 12.0;
/// No fault makes a spindle this much stiffer: the probe sees less than this part of the displacement.
const LEAST: f32 = 0.6;
/// Steps that a probe does not follow, until it is at fault; one that it follows takes back one.
const WRONG: u8 = 3;
/// Twice the pairs for which a value has repeated although it should have moved, until the probe is at fault.
const STUCK: u8 = 100;
/// No probe measures so far, um: sums of such numbers would not be finite.
const FARTHEST_READING: f32 = 1e6;
/// Load steps that a reference needs.
pub const LEAST_STEPS: u32 = 6;

/// Result of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// There is no reference, or no load step since.
    #[default]
    Learning,
    /// As at commissioning.
    Ok,
    /// More compliant than at commissioning.
    StiffnessLoss,
    /// Stiffer than at commissioning.
    StiffnessGain,
    /// The probe does not follow the loads.
    Probe,
}

impl State {
    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Learning => "learning",
            Self::Ok => "ok",
            Self::StiffnessLoss => "stiffness-loss",
            Self::StiffnessGain => "stiffness-gain",
            Self::Probe => "probe",
        }
    }
}

/// Ratio with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ratio {
    /// Measured over computed displacement.
    pub value: f32,
    /// Its standard error.
    pub error: f32,
}

impl Ratio {
    fn over(self, reference: Self) -> Self {
        let value = self.value / reference.value;
        let by_reference = value * reference.error;
        let square = self.error * self.error + by_reference * by_reference;
        let error = sqrt_f32(square) / reference.value;
        Self { value, error }
    }

    fn is_off(self, from: f32, errors: f32) -> bool {
        (self.value - from).abs() > errors * self.error
    }
}

/// Report of a probe.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeReport {
    /// Whether the spindle, or the probe, has changed.
    pub state: State,
    /// Ratio over that of the reference, whose error is part of the error; none while it learns.
    pub ratio: Option<Ratio>,
    /// Load steps since the reference, or since the start.
    pub steps: u32,
    /// Pairs since the last load step.
    pub age: u32,
}

/// Whether runout at this speed (rpm) cannot be told from drift at this sampling rate (Hz).
///
/// A harmonic of the revolution is within the inverse of the shortest block of a multiple of the rate.
pub fn is_aliased(rpm: f32, rate: f32) -> bool {
    let turns = rpm.abs() / 60.0 / rate;
    let near = 1.0 / shortest(rate);
    (1..=HARMONICS).any(|harmonic| {
        let turns = f32::from(harmonic) * turns;
        turns > 0.5 && off(turns).abs() < near
    })
}

/// Time of the longest block, us, of probes that are read once in a tick of this period, us.
pub(crate) const fn longest_us(period_us: u32) -> u32 {
    let rate = 1e6 / period_us as f32;
    // A block is a revolution at least, and longer by the shortest one at most.
    (1e6 * (LONGEST + shortest(rate) / rate)) as u32
}

/// Pairs of the shortest block.
const fn shortest(rate: f32) -> f32 {
    (rate / BLOCKS).max(PAIRS)
}

/// Distance from the nearest whole number.
fn off(x: f32) -> f32 {
    x - (x + 0.5) as u32 as f32
}

/// Pairs of the block that comes nearest to whole revolutions.
fn length(rpm: f32, rate: f32) -> Option<u32> {
    let turns = rpm.abs() / 60.0 / rate;
    let least = (1.0 / turns).max(shortest(rate));
    if least > LONGEST * rate || is_aliased(rpm, rate) {
        return None;
    }
    let (mut best, mut nearest) = (0, 1.0);
    for pairs in least as u32..=(least + shortest(rate)) as u32 {
        let off = off(pairs as f32 * turns).abs();
        if off < nearest {
            (best, nearest) = (pairs, off);
        }
    }
    Some(best)
}

/// Sums over load steps, of which old ones are forgotten.
#[derive(Debug, Clone, Copy, Default)]
struct Memory {
    mp: f32,
    pp: f32,
    /// `S(p (p - p'))`, each step with the square of its weight.
    edges: f32,
    /// Squared residuals, and their weight.
    residuals: f32,
    weight: f32,
}

impl Memory {
    // Once, for both memories: -350 B.
    #[inline(never)]
    fn add(&mut self, step: Step, before: f32, keep: f32) {
        let Step { m, p } = step;
        let old = self.mp / self.pp;
        self.mp = keep * self.mp + m * p;
        self.pp = keep * self.pp + p * p;
        self.edges = keep * keep * self.edges + p * (p - before);
        // The residual shrinks with the ratio that it is part of; before, it has the error of that. The product has neither.
        let residual = (m - old * p) * (m - self.mp / self.pp * p);
        if residual >= 0.0 {
            self.residuals = keep * self.residuals + residual;
            self.weight = keep * self.weight + 1.0;
        }
    }

    /// Ratio, with the variance of differences without a load step.
    // Called in seven places: -290 B.
    #[inline(never)]
    fn ratio(&self, quiet: f32) -> Option<Ratio> {
        let value = self.mp / self.pp;
        let variance = (PRIOR * quiet + self.residuals) / (PRIOR + self.weight);
        // A long ramp is told from drift by more than its ends.
        let edges = self.edges.max(0.02 * self.pp);
        let error = sqrt_f32(variance * edges) / self.pp;
        (value.is_finite() && error.is_finite()).then_some(Ratio { value, error })
    }
}

/// Difference of following means, um.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    m: f32,
    p: f32,
}

/// State of a probe.
#[derive(Debug, Clone, Copy)]
struct Probe {
    accuracy: f32,
    /// The block: its first pair, sums less that, count.
    first: Step,
    sum: Step,
    pairs: u32,
    /// Means of the last block.
    mean: Option<Step>,
    /// Computed difference before, if it counted; else 0.
    before: f32,
    /// The last measured value, computed displacement when it came, and evidence that it should have changed since.
    value: f32,
    since: f32,
    stuck: u8,
    /// Variance of differences without a step, and of how many.
    quiet: f32,
    quiets: f32,
    short: Memory,
    long: Memory,
    reference: Option<Ratio>,
    steps: u32,
    age: u32,
    wrong: u8,
}

impl Probe {
    fn new(accuracy: f32) -> Self {
        Self {
            accuracy,
            first: Step::default(),
            sum: Step::default(),
            pairs: 0,
            mean: None,
            before: 0.0,
            value: f32::NAN,
            since: f32::NAN,
            stuck: 0,
            quiet: accuracy * accuracy,
            quiets: PRIOR,
            short: Memory::default(),
            long: Memory::default(),
            reference: None,
            steps: 0,
            age: 0,
            wrong: 0,
        }
    }

    /// Least computed displacement, squared, that can be told from noise.
    fn least(&self) -> f32 {
        let [least, resolved] = [STEP * STEP * self.quiet, RESOLVED * self.accuracy];
        least.max(resolved * resolved)
    }

    /// Takes a measured displacement, if there is one, beside the computed one.
    fn add(&mut self, m: Option<f32>, p: f32) {
        self.age = self.age.saturating_add(1);
        let m = m.filter(|m| m.abs() < FARTHEST_READING);
        if m.is_some_and(|m| m != self.value) || self.since.is_nan() {
            (self.value, self.since, self.stuck) = (m.unwrap_or(f32::NAN), p, 0);
        } else {
            let moved = (p - self.since) * (p - self.since);
            let far = moved > self.least().max(self.accuracy * self.accuracy);
            self.stuck = match far {
                _ if self.stuck >= STUCK => STUCK,
                true => self.stuck + 2,
                false => self.stuck.saturating_sub(1),
            };
        }
        let Some(m) = m else { return };
        if self.pairs == 0 {
            (self.first, self.sum) = (Step { m, p }, Step::default());
        }
        self.sum.m += m - self.first.m;
        self.sum.p += p - self.first.p;
        self.pairs += 1;
    }

    /// Ends a block: the difference from the one before, if both count.
    fn end(&mut self, pairs: u32) -> Option<Step> {
        let count = self.pairs as f32;
        let is_whole = 2 * self.pairs > pairs && self.stuck < STUCK / 10;
        let mean = is_whole.then(|| Step {
            m: self.first.m + self.sum.m / count,
            p: self.first.p + self.sum.p / count,
        });
        let difference = self.mean.zip(mean).map(|(last, mean)| Step {
            m: mean.m - last.m,
            p: mean.p - last.p,
        });
        (self.mean, self.pairs) = (mean, 0);
        difference
    }

    /// The difference, if it is one over a load step; else its residual is noise.
    fn step(&mut self, difference: Option<Step>) -> Option<Step> {
        let step = difference.filter(|step| step.p * step.p > self.least());
        if let (Some(Step { m, p }), None) = (difference, step) {
            let ratio = self.ratio().or(self.reference);
            let ratio = ratio.map_or(1.0, |ratio| ratio.value);
            let residual = m - ratio * p;
            // A blow is no noise.
            let square = (residual * residual).min(STEP * STEP * self.quiet.max(1e-9));
            self.quiets = (self.quiets + 1.0).min(QUIET);
            self.quiet += (square - self.quiet) / self.quiets;
        }
        if step.is_none() {
            self.before = 0.0;
        }
        step
    }

    /// By how much of the expected displacement the probe moved: too little, or much too much.
    fn is_off(&self, Step { m, p }: Step) -> [bool; 2] {
        let learnt = self
            .long
            .ratio(self.quiet)
            .filter(|_| self.steps >= LEAST_STEPS);
        let expected = self
            .reference
            .or(learnt)
            .map_or(1.0 / 3.0, |ratio| ratio.value);
        let [m, p] = [m * p.signum(), expected * p.abs()];
        let noise = ERRORS * sqrt_f32(self.quiet);
        [m + noise < LEAST * p, m - noise > p / LEAST]
    }

    /// The ratio so far, if it may be a reference.
    fn candidate(&self) -> Option<Ratio> {
        let ratio = self.long.ratio(self.quiet)?;
        (self.steps >= LEAST_STEPS && ratio.value > 0.0).then_some(ratio)
    }

    /// Begins to compare with this reference.
    fn set_reference(&mut self, reference: Option<Ratio>) {
        self.reference = reference;
        (self.short, self.long) = (Memory::default(), Memory::default());
        (self.steps, self.before, self.wrong) = (0, 0.0, 0);
    }

    /// Takes a load step.
    fn learn(&mut self, step: Step) {
        let is_same = self.before * step.p > 0.0;
        let [short, long] = match is_same {
            true => [1.0; 2],
            false => [
                KEEP[0],
                if self.reference.is_some() {
                    KEEP[1]
                } else {
                    1.0
                },
            ],
        };
        self.short.add(step, self.before, short);
        self.long.add(step, self.before, long);
        if let (Some(short), Some(long), Some(_)) = (
            self.short.ratio(self.quiet),
            self.long.ratio(self.quiet),
            self.reference,
        ) && short.is_off(long.value, ERRORS_OF_FEW)
        {
            self.long = self.short;
        }
        self.before = step.p;
        self.age = 0;
        self.steps += u32::from(!is_same);
        self.wrong = self.wrong.saturating_sub(u8::from(!is_same));
    }

    /// The more accurate of both ratios.
    fn ratio(&self) -> Option<Ratio> {
        let short = self.short.ratio(self.quiet)?;
        let long = self.long.ratio(self.quiet)?;
        Some(if short.error < long.error {
            short
        } else {
            long
        })
    }

    /// The ratio over that of the reference.
    fn over(&self, ratio: Option<Ratio>) -> Option<Ratio> {
        Some(ratio?.over(self.reference?))
    }

    fn is_at_fault(&self) -> bool {
        self.stuck >= STUCK || self.wrong >= WRONG
    }

    /// Change of the ratio since the reference, of the memory that has the larger one, part of 1; 0 within its errors.
    fn change(&self) -> f32 {
        let mut largest = 0.0_f32;
        for memory in [self.short, self.long] {
            let errors = if memory.weight < FEW {
                ERRORS_OF_FEW
            } else {
                ERRORS
            };
            if let Some(ratio) = self.over(memory.ratio(self.quiet))
                && ratio.is_off(1.0, errors)
                && (ratio.value - 1.0).abs() > largest.abs()
            {
                largest = ratio.value - 1.0;
            }
        }
        largest
    }

    fn report(&self, [loss, gain]: [f32; 2]) -> ProbeReport {
        let ratio = self.over(self.ratio());
        let change = self.change();
        let state = match ratio {
            _ if self.is_at_fault() => State::Probe,
            None => State::Learning,
            Some(_) if change > loss => State::StiffnessLoss,
            Some(_) if change < -gain => State::StiffnessGain,
            Some(_) => State::Ok,
        };
        ProbeReport {
            state,
            ratio,
            steps: self.steps,
            age: self.age,
        }
    }
}

/// Measured over computed displacement at `P` probes.
#[derive(Debug, Clone)]
pub struct Response<const P: usize> {
    /// Pairs in a second.
    rate: f32,
    limits: [f32; 2],
    /// Speed of the last block, rpm; sum over this block, its ticks so far and its length: 0 if it does not count.
    speed: f32,
    speeds: f32,
    ticks: u32,
    length: u32,
    probes: [Probe; P],
}

impl<const P: usize> Response<P> {
    /// Probes with their accuracies (um), which give a pair `rate` times a second (Hz).
    ///
    /// A ratio is one of a changed spindle from these limits on, parts of 1: of more, and of less displacement than before.
    pub fn new(accuracies: [f32; P], rate: f32, limits: [f32; 2]) -> Self {
        Self {
            rate,
            limits,
            speed: 0.0,
            speeds: 0.0,
            ticks: 0,
            length: 0,
            probes: accuracies.map(Probe::new),
        }
    }

    /// Takes a tick: its speed (rpm), computed and measured displacements (um). Returns whether it ends a block.
    ///
    /// There is no speed where it is not believed, nothing computed without a fresh solution of loads of this tick, and nothing
    /// measured where a probe gave no value.
    pub fn tick(
        &mut self,
        rpm: Option<f32>,
        computed: Option<[f32; P]>,
        measured: [Option<f32>; P],
    ) -> bool {
        let Some(rpm) = rpm.filter(|rpm| rpm.is_finite()) else {
            self.restart(0.0);
            return false;
        };
        if !((rpm - self.speed).abs() <= STEADY * self.speed.abs()) {
            self.restart(rpm);
        }
        self.speeds += rpm - self.speed;
        self.ticks += 1;
        let computed = computed.filter(|all| all.iter().all(|p| p.is_finite()));
        if let Some(computed) = computed {
            for ((probe, p), m) in self.probes.iter_mut().zip(computed).zip(measured) {
                probe.add(m, p);
            }
        }
        let is_last = self.ticks == self.length;
        if is_last {
            self.end();
            self.begin(self.speed + self.speeds / self.ticks as f32);
        } else if self.length == 0 && self.ticks as f32 > shortest(self.rate) {
            self.restart(rpm);
        }
        is_last
    }

    /// Ends the reference of a probe: the ratio so far. Returns whether there is one, of [`LEAST_STEPS`] at least.
    pub fn refer(&mut self, probe: usize) -> bool {
        let Some(probe) = self.probes.get_mut(probe) else {
            return false;
        };
        let ratio = probe.candidate();
        if ratio.is_some() {
            probe.set_reference(ratio);
        }
        ratio.is_some()
    }

    /// Ends the references of all probes: the ratios so far. Returns whether each has seen [`LEAST_STEPS`] and follows the loads. If
    /// not, a probe whose steps are at odds with its reference forgets that, so that it can learn another one.
    pub fn commission(&mut self) -> bool {
        let is_ready = |probe: &Probe| probe.candidate().is_some() && !probe.is_at_fault();
        let all = P > 0 && self.probes.iter().all(is_ready);
        for probe in &mut self.probes {
            if all {
                probe.set_reference(probe.candidate());
            } else if probe.wrong >= WRONG {
                probe.set_reference(None);
            }
        }
        all
    }

    /// Takes the references of an earlier start, probe by probe: ratios at commissioning.
    pub fn set_references(&mut self, references: [Option<Ratio>; P]) {
        for (probe, reference) in self.probes.iter_mut().zip(references) {
            probe.set_reference(reference);
        }
    }

    /// The references.
    pub fn references(&self) -> [Option<Ratio>; P] {
        self.probes.each_ref().map(|probe| probe.reference)
    }

    /// Reports of the probes.
    pub fn reports(&self) -> [ProbeReport; P] {
        self.probes
            .each_ref()
            .map(|probe| probe.report(self.limits))
    }

    /// Change of each ratio since the reference, part of 1: 0 within its errors, none of a probe that does not follow the loads.
    pub fn changes(&self) -> [Option<f32>; P] {
        let change = |probe: &Probe| (!probe.is_at_fault()).then(|| probe.change());
        self.probes.each_ref().map(change)
    }

    /// Whether blocks do not count at the speed of now ([`is_aliased`]).
    pub fn is_aliased(&self) -> bool {
        is_aliased(self.speed, self.rate)
    }

    /// Begins a block at a speed.
    fn begin(&mut self, rpm: f32) {
        self.length = length(rpm, self.rate).unwrap_or(0);
        (self.speed, self.speeds, self.ticks) = (rpm, 0.0, 0);
    }

    /// Begins a block that does not follow another one.
    fn restart(&mut self, rpm: f32) {
        self.begin(rpm);
        for probe in &mut self.probes {
            (probe.mean, probe.pairs, probe.before) = (None, 0, 0.0);
        }
    }

    fn end(&mut self) {
        let pairs = self.ticks;
        let steps = self.probes.each_mut().map(|probe| {
            let difference = probe.end(pairs);
            let step = probe.step(difference)?;
            Some((step, probe.is_off(step)))
        });
        // Swapped probes: one sees too little and another one too much.
        let too_little = steps.iter().flatten().any(|(_, off)| off[0]);
        for (probe, step) in self.probes.iter_mut().zip(steps) {
            match step {
                Some((_, off)) if off[0] || (off[1] && too_little) => {
                    probe.wrong = (probe.wrong + 1).min(2 * WRONG);
                    probe.before = 0.0;
                }
                Some((step, _)) => probe.learn(step),
                None => {}
            }
        }
    }
}
