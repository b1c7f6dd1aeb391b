//! The preload that the spindle really has, and the gain of each probe: an extended Kalman filter over load steps.
//!
//! | state | meaning | before the first step | from step to step |
//! | --- | --- | --- | --- |
//! | `l` | ln of the preload over the file's, at commissioning | 0 +- 0.3 | constant |
//! | `d` | its change since | 0 +- 0 | +- 0.004, once commissioned |
//! | `g` | gain of a probe: measured over computed motion | 1 +- 0.1 | constant |
//! | `h` | its change since commissioning | 0 +- 0 | +- 0.0007, once commissioned |
//! | `a` | angle of a radial probe less the file's, rad | 0 +- 0.2 | constant |
//! | `c` | five of each probe: error of its motion by each load, in standard errors | 0 +- 1 | constant |
//!
//! Here a step is a difference of two blocks ([`blocks`](crate::blocks)) between which the loads have changed. Its residual at a probe is
//! `r = y - (g + h) (u + s F c)`. There `y` is the measured motion, `u` the computed one, `F` the loads and `s` the motion by a newton of their
//! error. Its slopes are
//!
//! - by `l` and `d`: `(g + h) du/dl`,
//! - by `g` and `h`: `u`,
//! - by `a`: `(g + h)` times the motion across the probe,
//! - by `c`: `(g + h) s F`.
//!
//! Its variance is that of the blocks, and of a model that is not the spindle.
//!
//! Load cells have gains, and each sees some of the other loads: 2 % of a load, in any direction. That makes the same error in each step of a
//! cut, and again when its tool comes back. As noise it would seem smaller with each step. It is linear in the loads: so many states know all
//! of it.
//!
//! `l` and `d` act alike, and so do `g` and `h`: they differ by what may change when. That makes the change honest where commissioning has
//! left `l` uncertain.
//!
//! All numbers that were chosen stand in [`Constants`].

use crate::command::MOST_PROBES;
use crate::preload::PreloadLaw;
use crate::settings::ResponseSettings;
use serde::{Deserialize, Serialize};
use spindle_bearing::sqrt_f32;

/// How a spindle with probes stands, or one of its probes: the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// The probe does not follow the loads; of a spindle, none of its probes does.
    Probe,
    /// Preload has been lost since commissioning: the alarm `preload-change` stands.
    PreloadLoss,
    /// Preload has grown since commissioning.
    PreloadGrowth,
    /// A probe sees more motion than at commissioning, and preload does not explain it: a support, the probe, its mount or the load cells.
    StiffnessLoss,
    /// A probe sees less motion.
    StiffnessGain,
    /// The model does not explain the load steps.
    Unexplained,
    /// It is not commissioned.
    #[default]
    Learning,
    /// The change of preload is not known well enough to tell one beyond the limit.
    Unknown,
    /// As at commissioning.
    Ok,
}

impl State {
    /// All of them, in the order of the format.
    pub const ALL: [Self; 9] = [
        Self::Probe,
        Self::PreloadLoss,
        Self::PreloadGrowth,
        Self::StiffnessLoss,
        Self::StiffnessGain,
        Self::Unexplained,
        Self::Learning,
        Self::Unknown,
        Self::Ok,
    ];

    /// Short name in lower case, as tables print it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Probe => "probe",
            Self::PreloadLoss => "preload-loss",
            Self::PreloadGrowth => "preload-growth",
            Self::StiffnessLoss => "stiffness-loss",
            Self::StiffnessGain => "stiffness-gain",
            Self::Unexplained => "unexplained",
            Self::Learning => "learning",
            Self::Unknown => "unknown",
            Self::Ok => "ok",
        }
    }
}

/// All constants of the estimator that were chosen. The page `docs/campaign_preload.md` has what doubling each does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// Standard error of `l` before the first step: spacers are ground to some um.
    pub preload: f32,
    /// Standard error of a probe's angle before the first step, rad: of a mount that was turned by eye.
    pub angle: f32,
    /// Walk of `d` from step to step, once commissioned: 13 % in a thousand steps.
    pub preload_walk: f32,
    /// Walk of `h`: 2 % in a thousand steps.
    pub gain_walk: f32,
    /// Error of the model, part of the motion by the loads: of supports and contacts that are not the file's.
    pub model: f32,
    /// Error of the preload that stays, however many steps there are: no model is the spindle.
    pub least: f32,
    /// Least standard error of `c`: compliances are not the same at all speeds and loads.
    pub least_load: f32,
    /// Squared residual of a step, per probe, beyond which it is surplus: noise is not the same at all speeds.
    pub expected: f32,
    /// Part of the sum of surplus residuals that a step leaves of it.
    pub kept: f32,
    /// That sum, per probe, which is a surprise: something has changed at once.
    pub surprise: f32,
    /// Standard errors by which a surprise opens `d`, and each `h`.
    pub opens: [f32; 2],
    /// Normalised residual, squared, per probe, beyond which a step is left out beside calm ones: coolant, a blow.
    pub outlier: f32,
    /// So many of them in a row are a change, and count.
    pub outliers: u8,
    /// Mean of the squared residuals, per probe, at which the model explains the steps no more, and at which it does again.
    pub unexplained: [f32; 2],
    /// Steps of that mean.
    pub mean_of: f32,
    /// Least steps of commissioning.
    pub steps: u32,
    /// Standard error of `l` that commissioning needs; of each `g`, without opposed rows.
    pub known: [f32; 2],
    /// Steps after which a probe enters.
    pub enters: u8,
    /// Measured over computed motion of a probe that follows the loads: least and largest.
    pub ratio: [f32; 2],
    /// Part of the sums of a probe's raw ratio that a step leaves of them.
    pub ratio_kept: f32,
    /// Steps that a probe does not follow, until it is at fault; one that it follows takes back one.
    pub wrong: u8,
    /// Standard errors of a change of preload, and of a gain, that an alarm needs.
    pub errors: [f32; 2],
    /// Change of the estimate, of ln preload and rad, that the solves are told.
    pub fed: f32,
    /// Angle by which a probe turns out to be off its slopes, rad, so that learning begins again from there.
    pub turned: f32,
}

impl Constants {
    /// Those in use.
    pub const USUAL: Self = Self {
        preload: 0.3,
        angle: 0.2,
        preload_walk: 0.004,
        gain_walk: 0.0007,
        model: 0.01,
        least: 0.01,
        least_load: 0.3,
        expected: 2.0,
        kept: 0.9,
        surprise: 5.0,
        opens: [0.15, 0.03],
        outlier: 25.0,
        outliers: 2,
        unexplained: [3.0, 2.0],
        mean_of: 20.0,
        steps: 200,
        known: [0.03, 0.02],
        enters: 6,
        ratio: [0.2, 5.0],
        ratio_kept: 0.95,
        wrong: 3,
        errors: [3.0, 4.0],
        fed: 0.01,
        turned: 0.1,
    };
}

/// Motion of the shaft at a probe over a load step, um.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Along the probe as it was measured.
    pub measured: f32,
    /// Along the probe as it was computed, at the preload and the angle that the solves were told.
    pub computed: f32,
    /// Across the probe, where its angle grows; 0 of an axial one.
    pub across: f32,
    /// Change of the computed motion per change of ln preload.
    pub by_preload: f32,
    /// Variance of the measured motion, um^2.
    pub noise: f32,
}

/// A load step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step<const P: usize> {
    /// The motion at each probe that has readings.
    pub motions: [Option<Motion>; P],
    /// Change of the loads, N; moments as forces at 50 mm.
    pub load: [f32; LOADS],
}

/// A number with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// The number.
    pub value: f32,
    /// Its standard error.
    pub error: f32,
}

/// Loads.
const LOADS: usize = 5;
/// Variance of a state that single precision tells from 0.
const ROUNDING: f32 = 1e-6;
/// States of a probe: `g`, `h`, `a`, and `c` of each load.
const OF_PROBE: usize = 3 + LOADS;

/// A number for each state.
#[derive(Debug, Clone, Copy, PartialEq)]
struct States<const P: usize> {
    /// Of `l` and `d`.
    preload: [f32; 2],
    /// Of `g`, `h`, `a` and the five `c` of each probe.
    probes: [[f32; OF_PROBE]; P],
}

impl<const P: usize> States<P> {
    const ZERO: Self = Self {
        preload: [0.0; 2],
        probes: [[0.0; OF_PROBE]; P],
    };

    /// Those of a probe. Here and below, a probe that is not there has zeros in the place of a panic.
    fn of(&self, probe: usize) -> [f32; OF_PROBE] {
        self.probes.get(probe).copied().unwrap_or_default()
    }

    /// Adds a multiple of others.
    fn add(&mut self, factor: f32, others: &Self) {
        add(&mut self.preload, factor, &others.preload);
        add(
            self.probes.as_flattened_mut(),
            factor,
            others.probes.as_flattened(),
        );
    }
}

// Once, for all lengths: it is short.
#[inline(never)]
fn add(to: &mut [f32], factor: f32, of: &[f32]) {
    for (to, of) in to.iter_mut().zip(of) {
        *to += factor * of;
    }
}

pub(crate) fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Slopes of a residual: by `l` and `d`, and by the states of its probe.
struct Slopes {
    preload: f32,
    probe: [f32; OF_PROBE],
}

impl Slopes {
    /// The sum of slopes times states.
    #[inline(never)]
    fn of<const P: usize>(&self, probe: usize, states: &States<P>) -> f32 {
        let [l, d] = states.preload;
        self.preload * (l + d) + dot(&self.probe, &states.of(probe))
    }
}

/// Means of the states, and the covariance of each with all.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Filter<const P: usize> {
    mean: States<P>,
    preload: [States<P>; 2],
    probes: [[States<P>; OF_PROBE]; P],
}

impl<const P: usize> Filter<P> {
    fn new(preload: f32, gain: f32, angle: f32) -> Self {
        let mut filter = Self {
            mean: States::ZERO,
            preload: [States::ZERO; 2],
            probes: [[States::ZERO; OF_PROBE]; P],
        };
        filter.preload[0].preload[0] = preload * preload;
        for probe in 0..P {
            filter.mean.probes[probe][0] = 1.0;
            filter.probes[probe][0].probes[probe][0] = gain * gain;
            filter.probes[probe][2].probes[probe][2] = angle * angle;
            for c in 3..OF_PROBE {
                filter.probes[probe][c].probes[probe][c] = 1.0;
            }
        }
        filter
    }

    /// Covariance of two states of a probe.
    fn covariance(&self, probe: usize, [i, j]: [usize; 2]) -> f32 {
        let row = self.probes.get(probe).and_then(|rows| rows.get(i));
        row.map_or(0.0, |row| row.of(probe).get(j).copied().unwrap_or_default())
    }

    /// Adds variance to `d` and to each `h`.
    fn open(&mut self, preload: f32, gain: f32) {
        self.preload[1].preload[1] += preload * preload;
        for (i, rows) in self.probes.iter_mut().enumerate() {
            rows[1].probes[i][1] += gain * gain;
        }
    }

    /// Takes the residual of a probe, of this variance by itself. Returns its square over its variance.
    ///
    /// Products of `c = P H / S^(1/2)` with itself are symmetric to the bit.
    #[inline(never)]
    fn update(&mut self, probe: usize, slopes: &Slopes, residual: f32, variance: f32) -> f32 {
        let mut c = States {
            preload: self.preload.each_ref().map(|row| slopes.of(probe, row)),
            probes: self
                .probes
                .each_ref()
                .map(|rows| rows.each_ref().map(|row| slopes.of(probe, row))),
        };
        let total = slopes.of(probe, &c).max(0.0) + variance;
        let root = sqrt_f32(total);
        let all = c.preload.iter_mut().chain(c.probes.as_flattened_mut());
        all.for_each(|c| *c /= root);
        let rows = self
            .preload
            .iter_mut()
            .chain(self.probes.as_flattened_mut());
        for (row, by) in rows.zip(c.preload.iter().chain(c.probes.as_flattened())) {
            row.add(-by, &c);
        }
        self.mean.add(residual / root, &c);
        residual * residual / total
    }

    /// Keeps the variances of states that are known in part, but for changes, from falling below that of single precision, those of `c` below
    /// the least one, and all from below 0.
    fn hold(&mut self, least_load: f32) {
        let hold = |state: usize, variance: &mut f32| {
            let least = match state {
                1 => 0.0,
                _ if *variance == 0.0 => 0.0,
                3.. => least_load * least_load,
                _ => ROUNDING,
            };
            *variance = variance.max(least);
        };
        for (i, row) in self.preload.iter_mut().enumerate() {
            hold(i, &mut row.preload[i]);
        }
        for (i, rows) in self.probes.iter_mut().enumerate() {
            for (j, row) in rows.iter_mut().enumerate() {
                hold(j, &mut row.probes[i][j]);
            }
        }
    }

    /// Takes `d` into `l`, and each `h` into its `g`.
    fn settle(&mut self) {
        let [l, d] = &mut self.preload;
        l.add(1.0, d);
        *d = States::ZERO;
        for [g, h, ..] in &mut self.probes {
            g.add(1.0, h);
            *h = States::ZERO;
        }
        let rows = self.probes.as_flattened_mut();
        for row in self.preload.iter_mut().chain(rows).chain([&mut self.mean]) {
            let [l, d] = &mut row.preload;
            *l += core::mem::take(d);
            for [g, h, ..] in &mut row.probes {
                *g += core::mem::take(h);
            }
        }
    }
}

/// How well a probe follows the loads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Follows {
    /// Steps that it has followed, as far as they are counted.
    good: u8,
    wrong: u8,
    /// Sums of measured times computed motion, and of the square of that, of the last steps.
    mp: f32,
    pp: f32,
}

/// The estimator of a spindle with `P` probes.
#[derive(Debug, Clone)]
pub struct Estimator<const P: usize> {
    settings: &'static ResponseSettings<P>,
    constants: &'static Constants,
    filter: Filter<P>,
    follows: [Follows; P],
    /// Steps since the prior, and whether it is commissioned.
    steps: u32,
    commissioned: bool,
    /// Sum of surplus residuals, outliers in a row, mean of the residuals and whether that is too large.
    surplus: f32,
    outliers: u8,
    mean: f32,
    unexplained: bool,
    /// ln preload and angles that the solves were told.
    fed: f32,
    fed_angles: [f32; P],
}

impl<const P: usize> Estimator<P> {
    /// Before the first step.
    pub fn new(settings: &'static ResponseSettings<P>, constants: &'static Constants) -> Self {
        Self {
            settings,
            constants,
            filter: Self::prior(settings, constants),
            follows: [Follows::default(); P],
            steps: 0,
            commissioned: false,
            surplus: 0.0,
            outliers: 0,
            mean: 1.0,
            unexplained: false,
            fed: 0.0,
            fed_angles: [0.0; P],
        }
    }

    fn prior(settings: &ResponseSettings<P>, constants: &Constants) -> Filter<P> {
        let preload = settings.preload.map_or(0.0, |_| constants.preload);
        let mut filter = Filter::new(preload, settings.gain, constants.angle);
        for (probe, [_, _, angle, ..]) in settings.probes.iter().zip(&mut filter.probes) {
            if probe.is_axial() {
                *angle = States::ZERO;
            }
        }
        filter
    }

    /// Its constants.
    pub const fn constants(&self) -> &'static Constants {
        self.constants
    }

    /// Takes a load step. Only where it `may_commission` can it be the last one of commissioning.
    #[inline(never)]
    pub fn take(&mut self, step: &Step<P>, may_commission: bool) {
        let mut step = *step;
        for (probe, motion) in step.motions.iter_mut().enumerate() {
            *motion = motion.filter(|motion| self.admits(probe, motion, &step.load));
        }
        let count = step.motions.iter().flatten().count() as f32;
        if count == 0.0 {
            return;
        }
        self.steps = self.steps.saturating_add(1);
        let c = self.constants;
        if self.commissioned {
            self.open([c.preload_walk, c.gain_walk]);
        }
        let (filter, square) = self.updated(&step);
        if !square.is_finite() {
            return;
        }
        if square <= c.outlier * count {
            self.outliers = 0;
        } else {
            self.outliers = (self.outliers + 1).min(c.outliers);
            if self.outliers < c.outliers {
                return;
            }
        }
        self.filter = filter;
        self.filter.hold(c.least_load);
        self.limit();
        if self.commissioned {
            self.surplus = (c.kept * self.surplus + square / count - c.expected).max(0.0);
            if self.surplus > c.surprise {
                self.surplus = 0.0;
                self.open(c.opens);
            }
        }
        self.mean += ((square / count).min(c.outlier) - self.mean) / c.mean_of;
        let [begins, ends] = c.unexplained;
        let limit = if self.unexplained { ends } else { begins };
        self.unexplained = self.mean > limit;
        if may_commission && self.steps >= c.steps {
            self.commissioned |= self.is_known();
        }
    }

    /// Whether a probe follows the loads, by this step too: then it may count.
    #[inline(never)]
    fn admits(&mut self, probe: usize, motion: &Motion, load: &[f32; LOADS]) -> bool {
        let (c, gain) = (self.constants, self.gain(probe).value);
        // Before commissioning the ratio is that of the file.
        let by_preload = match self.commissioned {
            true => motion.by_preload * self.preload().error,
            false => 0.0,
        };
        let by_load = self.settings.load_error * self.compliance(probe);
        let by_load = by_load * by_load * dot(load, load);
        let by_angle = self.filter.covariance(probe, [2, 2]) * motion.across * motion.across;
        let Some(follows) = self.follows.get_mut(probe) else {
            return false;
        };
        let (m, p) = (
            motion.measured * motion.computed.signum(),
            motion.computed.abs(),
        );
        (follows.mp, follows.pp) = (
            c.ratio_kept * follows.mp + m * p,
            c.ratio_kept * follows.pp + p * p,
        );
        let noise =
            c.errors[0] * sqrt_f32(motion.noise + by_load + by_angle + by_preload * by_preload);
        let [least, most] = c.ratio;
        let (least, most) = match self.commissioned {
            true => (least * gain * p, f32::INFINITY),
            false => (least * p, most * p),
        };
        let [is_off, follows_it] = [
            m + noise < least || m - noise > most,
            m - noise > least && m + noise < most,
        ];
        if is_off {
            follows.wrong = (follows.wrong + 1).min(2 * c.wrong);
        } else if follows_it {
            follows.wrong = follows.wrong.saturating_sub(1);
            follows.good = (follows.good + 1).min(c.enters + 1);
        }
        !is_off && follows.good > c.enters && follows.wrong == 0
    }

    fn compliance(&self, probe: usize) -> f32 {
        let settings = self.settings.probes.get(probe);
        settings.map_or(0.0, |probe| probe.compliance)
    }

    /// The filter after a step, and its squared residual.
    fn updated(&self, step: &Step<P>) -> (Filter<P>, f32) {
        let (mut filter, mut square) = (self.filter, 0.0);
        let [l, d] = self.filter.mean.preload;
        for (probe, motion) in step.motions.iter().enumerate() {
            let Some(motion) = motion else { continue };
            let [g, h, a, of_load @ ..] = self.filter.mean.of(probe);
            // Slopes are those before the step, whichever probe comes first.
            let u = motion.computed
                + motion.by_preload * (l + d - self.fed)
                + motion.across * (a - self.fed_angle(probe));
            let gain = g + h;
            let compliance = self.compliance(probe);
            let by_load = gain * self.settings.load_error * compliance;
            let [x, y, z, my, mz] = step.load.map(|load| by_load * load);
            let slopes = Slopes {
                preload: gain * motion.by_preload,
                probe: [u, u, gain * motion.across, x, y, z, my, mz],
            };
            let [_, _, _, by_load @ ..] = &slopes.probe;
            let of_load = dot(by_load, &of_load);
            // The other probes of this step have moved the states already.
            let moved = slopes.of(probe, &filter.mean) - slopes.of(probe, &self.filter.mean);
            let residual = motion.measured - gain * u - of_load - moved;
            let of_model = self.constants.model * compliance;
            let variance = motion.noise + of_model * of_model * dot(&step.load, &step.load);
            square += filter.update(probe, &slopes, residual, variance);
        }
        (filter, square)
    }

    /// Opens the changes of preload, if there is one, and of gains by these standard errors.
    fn open(&mut self, [preload, gain]: [f32; 2]) {
        let preload = self.settings.preload.map_or(0.0, |_| preload);
        self.filter.open(preload, gain);
    }

    /// Keeps the preload within the range of its law.
    fn limit(&mut self) {
        let Some(law) = &self.settings.preload else {
            return;
        };
        let [l, d] = &mut self.filter.mean.preload;
        let beyond = *l + *d - law.limited(*l + *d);
        *(if self.commissioned { d } else { l }) -= beyond;
    }

    /// Whether commissioning may end: the preload is known well enough, or without one the gain of each probe that follows the loads.
    fn is_known(&self) -> bool {
        let [preload, gain] = self.constants.known;
        if self.settings.preload.is_some() {
            return self.preload().error < preload;
        }
        let follow = |probe: &usize| !self.is_learning(*probe) && !self.is_at_fault(*probe);
        let mut follow = (0..P).filter(follow).peekable();
        follow.peek().is_some() && follow.all(|probe| self.gain(probe).error < gain)
    }

    /// The spindle is as it should be: changes count from now on. Whether it is commissioned.
    pub fn commission(&mut self) -> bool {
        if self.commissioned {
            self.filter.settle();
            self.surplus = 0.0;
        }
        self.commissioned
    }

    /// Tells the solves the preload and the angles of now, if they have moved by enough; whether they have.
    #[inline(never)]
    pub fn feed(&mut self) -> bool {
        let law = self.settings.preload.filter(PreloadLaw::is_told);
        let preload = law.map_or(0.0, |_| self.preload().value);
        let moved = |now: f32, then: f32| (now - then).abs() > self.constants.fed;
        let angles = self.filter.mean.probes.map(|[_, _, a, ..]| a);
        let all = angles.iter().zip(&self.fed_angles);
        let turned = all.fold(0.0, |most: f32, (now, then)| most.max((now - then).abs()));
        let feeds = moved(preload, self.fed) || moved(turned, 0.0);
        // Steps so far were taken at slopes of another angle: they do not bind the states.
        if !self.commissioned && turned > self.constants.turned {
            let mean =
                core::mem::replace(&mut self.filter, Self::prior(self.settings, self.constants))
                    .mean;
            self.filter.mean = mean;
        }
        if feeds {
            (self.fed, self.fed_angles) = (preload, angles);
        }
        feeds
    }

    /// ln preload over the file's that the solves were told.
    pub const fn fed_preload(&self) -> f32 {
        self.fed
    }

    /// Angle of a probe, less the file's, that the solves were told, rad.
    pub fn fed_angle(&self, probe: usize) -> f32 {
        self.fed_angles.get(probe).copied().unwrap_or_default()
    }

    /// Whether it is commissioned.
    pub const fn is_commissioned(&self) -> bool {
        self.commissioned
    }

    /// Whether the model does not explain the steps.
    pub const fn is_unexplained(&self) -> bool {
        self.unexplained
    }

    /// Steps since the first one.
    pub const fn steps(&self) -> u32 {
        self.steps
    }

    fn follows(&self, probe: usize) -> Follows {
        self.follows.get(probe).copied().unwrap_or_default()
    }

    /// Whether a probe has still to follow some steps.
    pub fn is_learning(&self, probe: usize) -> bool {
        self.follows(probe).good <= self.constants.enters
    }

    /// Whether a probe does not follow the loads.
    pub fn is_at_fault(&self, probe: usize) -> bool {
        self.follows(probe).wrong >= self.constants.wrong
    }

    /// Measured over computed motion of the last steps; none before the first.
    pub fn ratio(&self, probe: usize) -> Option<f32> {
        let Follows { mp, pp, .. } = self.follows(probe);
        (pp > 0.0).then(|| mp / pp)
    }

    /// ln preload over the file's.
    pub fn preload(&self) -> Estimate {
        let [l, d] = self.filter.mean.preload;
        let [of_l, of_d] = &self.filter.preload;
        let of_model = self.constants.least * self.constants.least;
        let [ll, dd, ld] = [of_l.preload[0], of_d.preload[1], of_l.preload[1]];
        sum([l, d], [ll + of_model, dd, ld])
    }

    /// Change of ln preload since commissioning.
    pub fn preload_change(&self) -> Estimate {
        Estimate {
            value: self.filter.mean.preload[1],
            error: sqrt_f32(self.filter.preload[1].preload[1]),
        }
    }

    /// Gain of a probe: measured over computed motion.
    #[inline(never)]
    pub fn gain(&self, probe: usize) -> Estimate {
        let [g, h, ..] = self.filter.mean.of(probe);
        let [gg, hh, gh] =
            [[0, 0], [1, 1], [0, 1]].map(|states| self.filter.covariance(probe, states));
        sum([g, h], [gg, hh, gh])
    }

    /// Change of a probe's gain since commissioning, as a part of it.
    pub fn gain_change(&self, probe: usize) -> Estimate {
        let [g, h, ..] = self.filter.mean.of(probe);
        Estimate {
            value: h / g,
            error: sqrt_f32(self.filter.covariance(probe, [1, 1])) / g,
        }
    }
}

/// States of a spindle with the most probes.
const STATES: usize = 2 + 3 * MOST_PROBES;
/// Bytes of [`Kept`]: states of two bytes, errors of half a byte, and the steps.
pub const KEPT: usize = 2 * STATES + STATES / 2 + size_of::<u32>();
/// Unit of the states there; and the least error, of which a code has `2^(code / 2)`.
const UNITS: [f32; 2] = [2e-4, 1e-3];

/// Estimates that are kept over a power cycle: `l`, `d`, then `g`, `h`, `a` of each probe, their standard errors within 20 %, and the
/// steps. Its bytes are those of a record, all 0 for none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Kept(pub [u8; KEPT]);

impl<const P: usize> Filter<P> {
    /// Mean and variance of a state that is kept: `l`, `d`, then `g`, `h`, `a` of each probe.
    // Of a loop over a few states, the compiler makes as many copies.
    #[inline(never)]
    fn kept_mut(&mut self, state: usize) -> Option<(&mut f32, &mut f32)> {
        let Some(of_probes) = state.checked_sub(2) else {
            let row = self.preload.get_mut(state)?;
            let mean = self.mean.preload.get_mut(state)?;
            return Some((mean, row.preload.get_mut(state)?));
        };
        let (probe, of) = (of_probes / 3, of_probes % 3);
        let row = self.probes.get_mut(probe)?.get_mut(of)?;
        let mean = self.mean.probes.get_mut(probe)?.get_mut(of)?;
        Some((mean, row.probes.get_mut(probe)?.get_mut(of)?))
    }
}

impl<const P: usize> Estimator<P> {
    /// The estimates to be kept; none before commissioning.
    pub fn kept(&mut self) -> Option<Kept> {
        let mut kept = Kept([0; KEPT]);
        let (states, errors, steps) = kept.parts_mut()?;
        for (i, kept) in states.iter_mut().enumerate() {
            let Some((mean, variance)) = self.filter.kept_mut(i) else {
                break;
            };
            // A cast stops at the largest number.
            *kept = ((*mean / UNITS[0]) as i16).to_le_bytes();
            let mut code = 0;
            while code < 15 && variance_of(code) < *variance {
                code += 1;
            }
            if let Some(pair) = errors.get_mut(i / 2) {
                *pair |= code << (i % 2 * 4);
            }
        }
        *steps = self.steps.to_le_bytes();
        self.commissioned.then_some(kept)
    }

    /// Goes on with estimates that were kept, opened as by one surprise.
    pub fn restore(&mut self, kept: &Kept) {
        let mut kept = *kept;
        let Some((states, errors, steps)) = kept.parts_mut() else {
            return;
        };
        self.filter = Filter::new(0.0, 0.0, 0.0);
        for (i, kept) in states.iter().enumerate() {
            let Some((mean, variance)) = self.filter.kept_mut(i) else {
                break;
            };
            let code = errors.get(i / 2).map_or(0, |pair| pair >> (i % 2 * 4) & 15);
            *mean = f32::from(i16::from_le_bytes(*kept)) * UNITS[0];
            *variance = variance_of(code);
        }
        (self.steps, self.commissioned) = (u32::from_le_bytes(*steps), true);
        self.limit();
        self.open(self.constants.opens);
        self.feed();
    }
}

/// States, errors, and steps.
type KeptParts<'k> = (&'k mut [[u8; 2]], &'k mut [u8; STATES / 2], &'k mut [u8; 4]);

impl Kept {
    fn parts_mut(&mut self) -> Option<KeptParts<'_>> {
        let (steps, rest) = self.0.split_first_chunk_mut()?;
        let (errors, states) = rest.split_first_chunk_mut()?;
        Some((states.as_chunks_mut().0, errors, steps))
    }
}

/// The variance of a code.
fn variance_of(code: u8) -> f32 {
    UNITS[1] * UNITS[1] * f32::from(1_u16 << code)
}

/// The sum of two numbers, with their variances and their covariance.
fn sum([a, b]: [f32; 2], [aa, bb, ab]: [f32; 3]) -> Estimate {
    Estimate {
        value: a + b,
        error: sqrt_f32((aa + bb + 2.0 * ab).max(0.0)),
    }
}
