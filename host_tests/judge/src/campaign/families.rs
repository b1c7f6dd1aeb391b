//! The families of cases, and how a case of each is drawn.
//!
//! A family, an index and the campaign's seed give one case for ever, whatever the solver does. Where a load has to be that
//! of a known displacement, the reference build's law gives it.

use super::sets::Set;
use crate::cases::{Case, rad_per_s};
use crate::reference::Reference;
use cli::random::Random;
use solvers::dispatch::Attitude;
use spindle_bearing::{Design, FreeContact, Material};
use std::array::from_fn;
use std::cmp::Ordering;
use std::f64::consts::{PI, TAU};
use std::iter::repeat_with;

/// The families, each with its name in tables and on the command line, and with what is in it.
macro_rules! families {
    ($($family:ident $name:literal $about:literal)*) => {
        /// A kind of cases.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Family {
            $(#[doc = $about] $family,)*
        }

        impl Family {
            /// All of them.
            pub const ALL: [Self; 15] = [$(Self::$family),*];

            /// Its name in tables and on the command line.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$family => $name,)* }
            }

            /// Its cases in a few words.
            pub const fn about(self) -> &'static str {
                match self { $(Self::$family => $about,)* }
            }
        }
    };
}

families! {
    Random "random" "any bearing (3 to 64 balls of 1 to 100 mm, free angles of 0 to 45 degrees), loads of 1e-6 to 3 times \
        the static capacity in any direction, up to n dm = 4 million (rpm mm)"
    Moderate "moderate" "axial load of 0.001 to 0.3 of the static capacity, radial load and moment below it, n dm up to 1.5 \
        million"
    Radial "radial" "radial load with 0.01 to 0.3 of it axial: most balls are unloaded"
    FewBalls "few-balls" "the load of a displacement that loads two or three balls"
    Opening "opening" "the load of a displacement with one ball within 1e-9 m of leaving the inner race"
    ExtremeAngles "extreme-angles" "free angles of 0 to 2 degrees; contact angles of 50 to 67 degrees"
    Reversed "reversed" "moderate loads with the axial load reversed"
    DeepGroove "deep-groove" "a small clearance or hardly any free angle, at rest, some loads purely radial"
    Moduli "moduli" "ceramic balls on steel, and moduli of balls and rings times 0.1 to 10"
    InnerControl "inner-control" "inner race control under moderate loads that keep balls loaded"
    ZeroLoads "zero-loads" "moderate loads with some components exactly zero, or all"
    WarmDrift "warm-drift" "ten warm solves: loads within 1 % and speed within 0.5 % of the solve before"
    WarmJumps "warm-jumps" "ten warm solves: loads times 0.01 to 100, reversed or turned; speed to 0, to full or between"
    AnyBits "any-bits" "inputs replaced by not-a-number, infinities, subnormals, largest numbers, random bits"
    Typed "typed" "round numbers: 4 to 32 balls, free angles or clearances, one or a few load components, round speeds"
}

impl Family {
    /// Families of which sets of bearings are drawn, too.
    pub const OF_SETS: [Self; 4] = [
        Self::Moderate,
        Self::Random,
        Self::ZeroLoads,
        Self::WarmJumps,
    ];

    /// Solves of a case that are counted.
    pub const fn ticks(self) -> usize {
        match self {
            Self::WarmDrift | Self::WarmJumps => 10,
            _ => 1,
        }
    }

    /// Whether only warm solves are counted.
    pub const fn is_warm(self) -> bool {
        self.ticks() > 1
    }
}

/// Load and speed of one solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tick {
    /// `Fx, Fy, Fz, My, Mz`, N and N m.
    pub load: [f64; 5],
    /// Shaft speed, rad/s.
    pub omega: f64,
}

/// A case of the campaign.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Its family.
    pub family: Family,
    /// Its number in the family.
    pub index: usize,
    /// The bearing, and the first tick.
    pub case: Case,
    /// The bearing, prepared by the reference build.
    pub reference: Reference,
    /// The set of bearings that is solved in the place of this bearing.
    pub set: Option<Set>,
    /// Solved by the solver for bearings at rest, in closed form for every ball.
    pub at_rest: bool,
    /// Loads and speeds, one after the other; only the last [`Family::ticks`] count.
    pub ticks: Vec<Tick>,
    /// A displacement that belongs to the load, before that was rounded to single precision.
    pub known: Option<[f64; 5]>,
}

/// A bearing being drawn.
struct Draft {
    r: Random,
    balls: usize,
    design: Design,
    /// Free contact angle as it was drawn, rad.
    angle: f64,
    attitude: Attitude,
}

/// A load and a speed, with a displacement that belongs to them if that is where they come from.
type Drawn = (Tick, Option<[f64; 5]>);

impl Draft {
    /// Any bearing, its free contact angle between these, in degrees.
    fn new(mut r: Random, angles: [f64; 2]) -> Self {
        let balls = 3 + r.below(62);
        let d = r.log_between(1e-3, 100e-3);
        let least = (1.02 * d / (PI / balls as f64).sin()).max(2.2 * d);
        let pitch_diameter = least * r.between(1.0, 1.5);
        let [inner_groove_factor, outer_groove_factor] = from_fn(|_| r.between(0.505, 0.56));
        let angle = r.between(angles[0], angles[1]).to_radians();
        let design = Design {
            inner_groove_factor,
            outer_groove_factor,
            free_contact: FreeContact::Angle(angle),
            first_ball: r.zero_or(0.5, -PI, PI),
            ball: match r.chance(0.6) {
                true => Material::STEEL,
                false => Material::SILICON_NITRIDE,
            },
            ..Design::angular_contact(d, pitch_diameter, 0.0)
        };
        let attitude = match r.chance(0.25) {
            true => Attitude::Outer,
            false => Attitude::Raceless,
        };
        Self {
            r,
            balls,
            design,
            angle,
            attitude,
        }
    }

    /// Largest static load, N: roughly ISO 76's.
    fn capacity(&self) -> f64 {
        let d = self.design.ball_diameter;
        12e6 * self.balls as f64 * d * d
    }

    fn pitch_radius(&self) -> f64 {
        0.5 * self.design.pitch_diameter
    }

    /// Distance of the groove centres, and sine and cosine of the free contact angle.
    fn grooves(&self) -> (f64, f64, f64) {
        let (sin, cos) = self.angle.sin_cos();
        (self.design.centre_distance(), sin, cos)
    }

    /// Speed in rad/s of `n dm` in rpm mm.
    fn speed(&self, n_dm: f64) -> f64 {
        rad_per_s(n_dm / (1e3 * self.design.pitch_diameter))
    }

    /// At rest with this probability, else up to `most` in `n dm`.
    fn rest_or_speed(&mut self, rest: f64, most: f64) -> f64 {
        let n_dm = self.r.zero_or(rest, 0.0, most);
        self.speed(n_dm)
    }

    /// Two components of this size together, in any direction.
    fn across(&mut self, size: f64) -> [f64; 2] {
        let (sin, cos) = self.r.between(0.0, TAU).sin_cos();
        [size * cos, size * sin]
    }

    /// A load with these axial, radial and moment sizes; the moment over the pitch radius.
    fn load(&mut self, axial: f64, radial: f64, moment: f64) -> [f64; 5] {
        let [fy, fz] = self.across(radial);
        let [my, mz] = self.across(moment * self.pitch_radius());
        [axial, fy, fz, my, mz]
    }

    /// A load and a speed of this family; `None` if this bearing has no displacement as it is wanted.
    fn of(&mut self, family: Family) -> Option<Drawn> {
        let tick = match family {
            Family::Random => self.any(),
            Family::Moderate | Family::WarmDrift | Family::WarmJumps => self.moderate(),
            Family::Radial => self.radial(),
            Family::FewBalls => return self.few_balls(),
            Family::Opening => return self.opening(),
            Family::ExtremeAngles => return self.extreme_angles(),
            Family::Reversed => {
                let Tick { mut load, omega } = self.moderate();
                load[0] = -load[0];
                Tick { load, omega }
            }
            Family::DeepGroove => self.deep_groove(),
            Family::Moduli => self.moduli(),
            Family::InnerControl => {
                self.attitude = Attitude::Inner;
                self.mixed([1e-2, 0.3], 0.3, 0.05, 1e6)
            }
            Family::ZeroLoads => self.zero_loads(),
            Family::AnyBits => self.any_bits(),
            Family::Typed => self.typed(),
        };
        Some((tick, None))
    }

    /// Any load and any speed.
    fn any(&mut self) -> Tick {
        let size = self.capacity() * self.r.log_between(1e-6, 3.0);
        let axial = match self.r.below(10) {
            0 => 1.0,
            1 => 0.0,
            _ => self.r.between(-1.0, 1.0),
        };
        let moment = self.r.zero_or(0.5, 0.0, 0.5);
        let radial = (1.0 - axial * axial).sqrt();
        let load = self.load(size * axial, size * radial, size * moment);
        let omega = match self.r.below(20) {
            0..5 => 0.0,
            5..8 => self.r.log_between(1e-6, 1.0),
            8 => -self.rest_or_speed(0.0, 4e6),
            _ => self.rest_or_speed(0.0, 4e6),
        };
        Tick { load, omega }
    }

    /// An axial load of this share of the capacity with a smaller radial one and a moment.
    fn mixed(&mut self, shares: [f64; 2], radial: f64, moment: f64, n_dm: f64) -> Tick {
        let size = self.capacity() * self.r.log_between(shares[0], shares[1]);
        let radial = size * self.r.between(0.0, radial);
        let moment = size * self.r.between(0.0, moment);
        Tick {
            load: self.load(size, radial, moment),
            omega: self.rest_or_speed(0.1, n_dm),
        }
    }

    fn moderate(&mut self) -> Tick {
        self.mixed([1e-3, 0.3], 0.6, 0.1, 1.5e6)
    }

    fn radial(&mut self) -> Tick {
        let size = self.capacity() * self.r.log_between(1e-5, 1.0);
        let axial = size * self.r.log_between(0.01, 0.3);
        let moment = size * self.r.zero_or(0.5, 0.0, 0.05);
        Tick {
            load: self.load(axial, size, moment),
            omega: self.rest_or_speed(0.5, 1.5e6),
        }
    }

    fn deep_groove(&mut self) -> Tick {
        let d = self.design.ball_diameter;
        self.design.free_contact = match self.r.below(10) {
            0 => FreeContact::Angle(0.0),
            1..3 => FreeContact::Angle(self.r.log_between(1e-6, 1e-2)),
            _ => FreeContact::DiametralClearance(d * self.r.log_between(1e-6, 2e-3)),
        };
        let size = self.capacity() * self.r.log_between(1e-6, 3.0);
        let [axial, radial] = match self.r.below(10) {
            0..4 => [0.0, 1.0],
            4..6 => [1.0, 0.0],
            _ => [self.r.log_between(1e-3, 1.0), 1.0],
        };
        Tick {
            load: self.load(size * axial, size * radial, 0.0),
            omega: 0.0,
        }
    }

    fn moduli(&mut self) -> Tick {
        self.design.ball = Material::SILICON_NITRIDE;
        if self.r.chance(0.7) {
            self.design.ball.youngs_modulus *= self.r.log_between(0.1, 10.0);
            self.design.ring.youngs_modulus *= self.r.log_between(0.1, 10.0);
        }
        self.mixed([1e-4, 0.3], 0.6, 0.1, 1.5e6)
    }

    fn zero_loads(&mut self) -> Tick {
        let mut tick = self.moderate();
        let zero = if self.r.chance(0.5) { 0.0 } else { -0.0 };
        if self.r.chance(0.1) {
            tick.load = [zero; 5];
            return tick;
        }
        let sets = repeat_with(|| from_fn(|_| self.r.chance(0.5)));
        let mut mixed = sets.filter(|set: &[bool; 5]| set.contains(&true) && set.contains(&false));
        let set = mixed.next().unwrap_or_default();
        tick.load = from_fn(|i| if set[i] { zero } else { tick.load[i] });
        tick
    }

    /// The next tick of a drift.
    fn drift(&mut self, last: &Tick) -> Tick {
        Tick {
            load: last.load.map(|f| f * self.r.between(0.99, 1.01)),
            omega: last.omega * self.r.between(0.995, 1.005),
        }
    }

    /// The next tick of a sequence of jumps.
    fn jump(&mut self, last: &Tick, full: f64) -> Tick {
        let mut tick = *last;
        let [fx, fy, fz, my, mz] = tick.load;
        match self.r.below(6) {
            0 => tick.load = tick.load.map(|f| -f),
            1 => {
                let (sin, cos) = self.r.between(0.0, TAU).sin_cos();
                let turn = |y: f64, z: f64| [y * cos - z * sin, y * sin + z * cos];
                let ([fy, fz], [my, mz]) = (turn(fy, fz), turn(my, mz));
                tick.load = [fx, fy, fz, my, mz];
            }
            2 => tick.load = self.moderate().load,
            // As of a spindle that starts, or stops.
            3 => {}
            _ => {
                let factor = self.r.log_between(0.01, 100.0);
                tick.load = tick.load.map(|f| f * factor);
            }
        }
        // Sequences would wander off otherwise.
        let size = tick.load[0].abs() + tick.load[1].hypot(tick.load[2]);
        let (least, most) = (1e-5 * self.capacity(), 3.0 * self.capacity());
        let factor = size.clamp(least, most) / size;
        tick.load = tick.load.map(|f| f * factor);
        tick.omega = match self.r.below(6) {
            0 => 0.0,
            1 => full,
            2 => full * self.r.between(0.0, 1.0),
            _ => tick.omega,
        };
        tick
    }

    fn bits(&mut self) -> f64 {
        match self.r.below(12) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::NEG_INFINITY,
            3 => f64::from(f32::from_bits((self.r.bits() >> 41) as u32)),
            4 => f64::from_bits(self.r.bits() >> 12),
            5 => f64::from(f32::MAX),
            6 => f64::MAX,
            7 => -f64::from(f32::MAX),
            8 => f64::from_bits(self.r.bits()),
            9 => f64::from(f32::MIN_POSITIVE),
            _ => f64::from(f32::from_bits(self.r.bits() as u32)),
        }
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.r.below(of.len())]
    }

    /// A bearing, a load and a speed as people type them.
    fn typed(&mut self) -> Tick {
        self.balls = 4 + self.r.below(29);
        let d = self.pick(&[5.0, 6.35, 8.0, 10.0, 12.0, 15.0, 20.0, 25.0, 30.0]);
        // To the next 5 mm in which the balls have room.
        let room = (1.1 * d / (PI / self.balls as f64).sin()).max(2.5 * d);
        let [inner, outer] = self.pick(&[[0.515, 0.525], [0.52, 0.52], [0.52, 0.53]]);
        self.design = Design {
            inner_groove_factor: inner,
            outer_groove_factor: outer,
            ..Design::angular_contact(1e-3 * d, 5e-3 * (room / 5.0).ceil(), 0.0)
        };
        self.design.free_contact = match self.r.below(3) {
            0 => FreeContact::Angle(0.0),
            1 => FreeContact::Angle(self.pick(&[15f64, 25.0, 30.0, 40.0]).to_radians()),
            _ => FreeContact::DiametralClearance(1e-6 * self.pick(&[0.0, 10.0, 20.0, -5.0])),
        };
        let tenths = self.pick(&[1.0, 2.0, 5.0]) * self.pick(&[1e-4, 1e-3, 1e-2, 1e-1]);
        // A round number of newtons next to so much of the capacity.
        let size = tenths * 10f64.powf(self.capacity().log10().floor());
        let moment = 1e-3 * size * self.pick(&[1.0, 10.0]);
        let sign = self.pick(&[1.0, -1.0]);
        let load = match self.r.below(9) {
            0 => [sign, 0.0, 0.0, 0.0, 0.0],
            1 => [0.0, sign, 0.0, 0.0, 0.0],
            2 => [0.0, 0.0, sign, 0.0, 0.0],
            3 => [0.0, 1.0, sign, 0.0, 0.0],
            4 => [1.0, sign, 0.0, 0.0, 0.0],
            5 => [1.0, 0.0, 0.5 * sign, 0.0, 0.0],
            6 => [0.0, 0.0, 0.0, 0.0, sign],
            7 => [0.0, 0.0, 0.0, 1.0, sign],
            _ => [1.0, 0.2, 0.0, 0.0, sign],
        };
        let rpm = self.pick(&[
            0.0, 0.0, 0.0, 100.0, 500.0, 1000.0, 3000.0, 6000.0, 10_000.0,
        ]);
        let fastest = 1.5e6 / (1e3 * self.design.pitch_diameter);
        Tick {
            load: from_fn(|i| load[i] * if i < 3 { size } else { moment }),
            omega: if rpm > fastest { 0.0 } else { rad_per_s(rpm) },
        }
    }

    fn any_bits(&mut self) -> Tick {
        let mut tick = self.moderate();
        let mut sets = repeat_with(|| from_fn(|_| self.r.chance(0.35)));
        let some = sets.find(|set: &[bool; 6]| set.contains(&true));
        let set = some.unwrap_or_default();
        let inputs = tick.load.iter_mut().chain([&mut tick.omega]);
        for (input, _) in inputs.zip(set).filter(|(_, set)| *set) {
            *input = self.bits();
        }
        tick
    }

    /// The bearing, prepared by the reference build.
    fn reference(&self) -> Reference {
        crate::cases::reference(&self.design, self.balls)
    }

    /// A displacement that loads two or three balls, found by moving the ring along the axis.
    fn few_balls(&mut self) -> Option<Drawn> {
        let reference = self.reference();
        let omega = self.rest_or_speed(0.6, 1.2e6);
        let wanted = 2 + self.r.below(2);
        let (l0, sin, cos) = self.grooves();
        // Beyond, a ball would be loaded wherever the ring is along the axis.
        let room = l0 * (1.0 - cos);
        let radial = room.min(l0 * self.r.log_between(1e-4, 0.05)) * self.r.between(0.3, 0.95);
        let [dy, dz] = self.across(radial);
        let tilt = self.r.zero_or(0.5, 0.0, 0.3) * radial / self.pitch_radius();
        let [ty, tz] = self.across(tilt);
        let mut centres = Vec::new();
        let mut low = -l0 * sin;
        let mut high = 2.0 * l0 * ((1.0 - (cos - radial / l0).powi(2)).sqrt() - sin) + radial;
        for _ in 0..40 {
            let u = [0.5 * (low + high), dy, dz, ty, tz];
            let (load, depths) = reference
                .rough_law(u, omega, self.attitude, &mut centres)
                .ok()?;
            let loaded = depths.iter().filter(|depth| **depth > 0.0).count();
            match loaded.cmp(&wanted) {
                Ordering::Equal => return Some((Tick { load, omega }, Some(u))),
                Ordering::Less => low = u[0],
                Ordering::Greater => high = u[0],
            }
        }
        None
    }

    /// A displacement that has the least loaded ball within 1e-9 m of opening.
    fn opening(&mut self) -> Option<Drawn> {
        let reference = self.reference();
        let omega = self.rest_or_speed(0.5, 1.5e6);
        let attitude = self.attitude;
        let (l0, sin, cos) = self.grooves();
        let depth = l0 * self.r.log_between(1e-5, 3e-2);
        let radial = depth * self.r.between(0.1, 1.5);
        let [dy, dz] = self.across(radial);
        let tilt = depth * self.r.between(0.0, 0.5) / self.pitch_radius();
        let [ty, tz] = self.across(tilt);
        // At this axial displacement the least loaded ball is as deep as was drawn, about.
        let reach = (l0 + 3.0 * depth).powi(2) - (l0 * cos).powi(2);
        let at = |dx: f64| [dx, dy, dz, ty, tz];
        let (mut low, mut high) = (-l0 * sin, reach.sqrt() - l0 * sin);
        let (_, depths) = reference
            .rough_law(at(high), omega, attitude, &mut Vec::new())
            .ok()?;
        let ball = (0..self.balls).min_by(|&a, &b| depths[a].total_cmp(&depths[b]))?;
        let target = self.r.between(-0.8e-9, 0.8e-9);
        let off = |dx: f64| Some(reference.depth(ball, at(dx), omega, attitude).ok()? - target);
        let (mut below, mut above) = (off(low)?, depths[ball] - target);
        if below >= 0.0 || above <= 0.0 {
            return None;
        }
        // Illinois: the secant rule, with the end that stays put halved.
        for _ in 0..60 {
            let dx = (low * above - high * below) / (above - below);
            let there = off(dx)?;
            if there.abs() < 1e-10 {
                return self.at(at(dx), omega);
            }
            if there < 0.0 {
                (low, below) = (dx, there);
                above *= 0.5;
            } else {
                (high, above) = (dx, there);
                below *= 0.5;
            }
        }
        None
    }

    /// Contact angles near 0, or near the shoulder.
    fn extreme_angles(&mut self) -> Option<Drawn> {
        if self.angle < 0.1 {
            let axial = self.capacity() * self.r.log_between(1e-6, 1e-2);
            let radial = self.capacity() * self.r.log_between(1e-6, 1e-2);
            let load = self.load(axial, radial, 0.0);
            let omega = self.rest_or_speed(0.5, 1e6);
            return Some((Tick { load, omega }, None));
        }
        let omega = self.rest_or_speed(0.3, 1e6);
        let (l0, sin, cos) = self.grooves();
        // Deeper than the grooves' centres are apart nothing in the model holds.
        let steepest = (cos / 1.8).acos();
        let angle = self.r.between(50f64.to_radians(), steepest);
        let dx = l0 * (cos * angle.tan() - sin);
        let size = dx * self.r.between(0.0, 0.1);
        let [dy, dz] = self.across(size);
        let u = [dx, dy, dz, 0.0, 0.0];
        self.at(u, omega)
    }

    /// The load that belongs to a displacement.
    fn at(&self, u: [f64; 5], omega: f64) -> Option<Drawn> {
        let law = self
            .reference()
            .rough_law(u, omega, self.attitude, &mut Vec::new());
        let (load, _) = law.ok()?;
        Some((Tick { load, omega }, Some(u)))
    }
}

impl Tick {
    /// Rounded to single precision.
    pub fn rounded(&self) -> Self {
        let round = |x: f64| f64::from(x as f32);
        Self {
            load: self.load.map(round),
            omega: round(self.omega),
        }
    }
}

impl Trial {
    /// The bearing of this family and number, in the campaign of this seed.
    pub fn new(seed: u64, family: Family, index: usize) -> Self {
        Self::draw(seed, family, index).0
    }

    /// The set of this family and number: of its bearing, under its loads.
    pub fn of_set(seed: u64, family: Family, index: usize) -> Self {
        let (mut trial, mut draft) = Self::draw(seed, family, index);
        let capacity = draft.capacity();
        let set = Set::draw(&mut draft.r, &draft.design, draft.balls, capacity);
        trial.case.name.insert_str(0, "set of ");
        trial.set = Some(set);
        trial
    }

    fn draw(seed: u64, family: Family, index: usize) -> (Self, Draft) {
        // One draw scrambles what would otherwise be overlapping sequences.
        let place = ((family as u64) << 56) ^ index as u64;
        let mut r = Random::seeded(Random::seeded(seed).bits() ^ place);
        let mut start = Random::seeded(r.bits());
        let angles = match family {
            Family::Random | Family::AnyBits | Family::Radial => [0.0, 45.0],
            Family::FewBalls | Family::Opening => [2.0, 45.0],
            Family::ExtremeAngles if start.chance(0.5) => [0.0, 2.0],
            Family::ExtremeAngles => [40.0, 45.0],
            _ => [10.0, 45.0],
        };
        // A few draws have no displacement as it is wanted.
        let draw = || {
            let mut draft = Draft::new(start.clone(), angles);
            start = Random::seeded(r.bits());
            let (first, known) = draft.of(family)?;
            Some((draft, first, known))
        };
        let drawn = repeat_with(draw).take(100).flatten().next();
        let (mut draft, first, known) = drawn.expect("a draw with the displacement that is wanted");
        let full = draft.speed(1.5e6);
        let mut ticks = vec![first];
        while family.is_warm() && ticks.len() <= family.ticks() {
            let last = ticks[ticks.len() - 1];
            ticks.push(match family {
                Family::WarmDrift => draft.drift(&last),
                _ => draft.jump(&last, full),
            });
        }
        // One truth serves both precisions, but where the point is what single precision cannot hold.
        if family != Family::AnyBits {
            ticks = ticks.iter().map(Tick::rounded).collect();
        }
        let at_rest = ticks.iter().all(|tick| tick.omega == 0.0) && draft.r.chance(0.5);
        let trial = Self {
            family,
            index,
            reference: draft.reference(),
            set: None,
            case: Case {
                name: format!("{} {index}", family.name()),
                balls: draft.balls,
                design: draft.design,
                attitude: draft.attitude,
                load: ticks[0].load,
                omega: ticks[0].omega,
            },
            at_rest,
            ticks,
            known,
        };
        (trial, draft)
    }
}
