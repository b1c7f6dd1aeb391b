//! A shaft in its rows of balls: turns the shaft's motion into the rows' motions, and adds up the rows' forces.
//!
//! A bearing is a shaft with one row, in the frame and the units of that row. `SET` says whether rows have mounts of their own;
//! a bearing alone has [`Mount::PLAIN`], and its loop leaves that arithmetic out.

pub mod axial;
pub mod elastic;
pub mod row;

use crate::ball::contact::Point;
use crate::ball::kinematics::Rule;
use crate::bearing::{Azimuth, Bearing, Constants};
use crate::linalg::{moved, vector};
use crate::real::Real;
use crate::shaft::elastic::{Bend, Joint};
use crate::shaft::row::{Changes, Row, Sum, sum_up};

/// How a row sits on the shaft.
///
/// Shaft and row have frames and units of their own; the shaft has the units of its first row. A row that faces
/// against the axis is mirrored. Its motion is `r P v` with the shaft's motion `v` of the groove plane, the force on the shaft
/// `phi P^T F`:
///
/// `P v = (s vx + e, vy + l vtz, vz - l vty, s m vty, s m vtz)`
///
/// with the motion `e` of the row's sleeve towards its balls, if that slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount<T> {
    /// `s`: 1, or -1 for a row that faces against the axis.
    pub facing: T,
    /// `r` and `phi`: the shaft's unit of length over the row's, the row's unit of force over the shaft's.
    pub length: T,
    pub force: T,
    /// `l`: the row's groove plane beyond the shaft's, over the shaft's `Rp`.
    pub lever: T,
    /// The row's groove plane beyond the shaft's centre, on an elastic shaft beyond the row's own, in the row's own direction and
    /// over its own `Rp`.
    pub reach: T,
    /// `m`: `Rp` of the row over the shaft's.
    pub arm: T,
    /// Inertia `m dm omega^2 / 2` of a ball over a ball's in the first row, each in its row's unit of force.
    pub inertia: T,
    /// Closure, in the row's unit of length.
    pub closure: T,
    /// The row's sleeve slides under a spring.
    pub sliding: bool,
}

impl<T: Real> Mount<T> {
    /// Of a bearing alone.
    pub const PLAIN: Self = Self {
        facing: T::ONE,
        length: T::ONE,
        force: T::ONE,
        lever: T::ZERO,
        reach: T::ZERO,
        arm: T::ONE,
        inertia: T::ONE,
        closure: T::ZERO,
        sliding: false,
    };

    /// The row's motion when the shaft makes the motion `v`.
    #[inline(always)]
    pub fn motion<const D: usize, const SET: bool>(&self, v: &[T; D]) -> [T; 5] {
        if SET { self.turned(v) } else { in_full(v) }
    }

    #[inline(never)]
    fn turned<const D: usize>(&self, v: &[T; D]) -> [T; 5] {
        let mut own = in_full(v);
        if D == 6 && self.sliding {
            own[0] += self.facing * v[5];
        }
        if D >= 5 {
            own[1] += self.lever * own[4];
            own[2] -= self.lever * own[3];
        }
        self.own(own)
    }

    /// A motion of the row's groove plane in its own direction and units.
    #[inline(always)]
    fn own(&self, mut u: [T; 5]) -> [T; 5] {
        let r = self.length;
        u[0] = r * (self.facing * u[0]);
        u[1] = r * u[1];
        u[2] = r * u[2];
        let turn = r * (self.facing * self.arm);
        u[3] = turn * u[3];
        u[4] = turn * u[4];
        u
    }

    /// The row's motion when its centre makes the motion `u` on an elastic shaft.
    #[inline(never)]
    pub fn of_centre(&self, u: &[T; 5]) -> [T; 5] {
        self.own(moved(self.facing * self.arm * self.reach, u))
    }

    /// Adds the row's forces and slopes, at its groove plane, to the shaft's about its centre.
    #[inline(never)]
    pub fn assemble<const D: usize>(&self, own: &mut Sum<T, 5>, sum: &mut Sum<T, D>) {
        let turn = self.facing * self.arm;
        let mirror = [self.facing, T::ONE, T::ONE, turn, turn];
        let slides = D == 6 && self.sliding;
        own.refer(self.reach);
        let forces = [
            (&own.force, &mut sum.force),
            (&own.by_speed, &mut sum.by_speed),
        ];
        for (own, sum) in forces {
            for i in 0..5 {
                sum[i] += self.force * (mirror[i] * own[i]);
            }
            if slides {
                sum[5] += self.force * own[0];
            }
        }
        let (own, k) = (&own.k, &mut sum.k);
        let unit = self.force * self.length;
        for i in 0..5 {
            for j in 0..5 {
                k[i][j] += unit * (mirror[i] * mirror[j] * own[i][j]);
            }
        }
        if slides {
            for i in 0..5 {
                k[i][5] += unit * (mirror[i] * own[i][0]);
                k[5][i] += unit * (mirror[i] * own[0][i]);
            }
            k[5][5] += unit * own[0][0];
        }
    }
}

/// A displacement with all five freedoms; the others are 0.
#[inline(always)]
fn in_full<T: Real, const D: usize>(v: &[T; D]) -> [T; 5] {
    let mut full = [T::ZERO; 5];
    for (full, v) in full.iter_mut().zip(v) {
        *full = *v;
    }
    full
}

/// Rows that hold the shaft together, or slide together.
#[derive(Debug, Clone, Copy)]
pub struct Group<T> {
    /// The first of its rows.
    pub first: usize,
    /// Number of its balls.
    pub balls: T,
    /// Its rows face both ways.
    pub opposed: bool,
}

/// A bearing of any ball count.
#[derive(Debug, Clone, Copy)]
pub struct BearingRef<'b, T> {
    pub c: &'b Constants<T>,
    pub azimuths: &'b [Azimuth<T>],
}

/// Bearings and how they sit on the shaft: all that no solve changes.
#[derive(Debug, Clone, Copy)]
pub struct Layout<'b, T, const R: usize, const SET: bool, const E: usize> {
    pub bearings: [BearingRef<'b, T>; R],
    pub mounts: [Mount<T>; R],
    /// Rows that are fixed, and rows that slide.
    pub fixed: Group<T>,
    pub sliding: Option<Group<T>>,
    /// Axial position of the groove plane from the shaft's centre, over `Rp`.
    pub plane: T,
    /// Number of balls, weighted with their inertia in units of the first row.
    pub ball_count: T,
    /// Estimate of the preload at rest, in the shaft's unit of force; load scales are at least this.
    pub preload_at_rest: T,
    /// The chain of an elastic shaft, `E = R`; a rigid one has none, `E = 0`.
    pub joints: [Joint<T>; E],
    /// Fingerprint of bearings and shaft: a solver that has solved others starts cold.
    pub fingerprint: u32,
}

impl<'b, T: Real> Layout<'b, T, 1, false, 0> {
    /// A bearing alone.
    #[inline(always)]
    pub fn alone(c: &'b Constants<T>, azimuths: &'b [Azimuth<T>]) -> Self {
        Self {
            bearings: [BearingRef { c, azimuths }],
            mounts: [Mount::PLAIN],
            fixed: Group {
                first: 0,
                balls: c.balls,
                opposed: false,
            },
            sliding: None,
            plane: c.plane,
            ball_count: c.balls,
            preload_at_rest: c.preload,
            joints: [],
            fingerprint: c.fingerprint,
        }
    }
}

impl<'b, T: Real, const R: usize> Layout<'b, T, R, true, 0> {
    /// These rows on an elastic shaft.
    pub const fn with_joints(self, joints: [Joint<T>; R]) -> Layout<'b, T, R, true, R> {
        let Self {
            bearings,
            mounts,
            fixed,
            sliding,
            plane,
            ball_count,
            preload_at_rest,
            joints: [],
            fingerprint,
        } = self;
        Layout {
            bearings,
            mounts,
            fixed,
            sliding,
            plane,
            ball_count,
            preload_at_rest,
            joints,
            fingerprint,
        }
    }
}

impl<T: Real, const N: usize> Bearing<T, N> {
    /// The bearing alone.
    #[inline(always)]
    pub(crate) fn layout(&self) -> Layout<'_, T, 1, false, 0> {
        Layout::alone(&self.constants, &self.azimuths)
    }
}

/// A group of rows, as a start sees it by its first row.
#[derive(Debug, Clone, Copy)]
pub struct GroupRow<'a, T> {
    pub c: &'a Constants<T>,
    pub p: &'a Point<T>,
    pub mount: &'a Mount<T>,
    /// Number of its balls.
    pub balls: T,
}

/// How long a solve may go on.
pub struct Time<'a> {
    /// Most iterations; at least one is taken.
    pub max_iterations: u16,
    /// Iterations taken in this call.
    pub taken: u16,
    /// Asked after every row of balls.
    pub more: &'a mut dyn FnMut() -> bool,
    /// The time is used up.
    pub is_up: bool,
}

/// A pass over the rows: it may be left between two of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass<T> {
    /// Relative change of `omega^2` that it follows.
    pub ds: T,
    /// Rows that it has condensed, and whether one of them is far from its balance.
    pub rows: usize,
    pub far: bool,
    /// It is the first one of a start: it puts the balls to where they start.
    pub starts: bool,
}

impl<T: Real> Pass<T> {
    /// From the first row on, at the speed of the last pass.
    pub const NONE: Self = Self {
        ds: T::ZERO,
        rows: 0,
        far: false,
        starts: false,
    };

    /// It has begun, or has to be the next one.
    pub const fn is_open(&self) -> bool {
        self.rows > 0 || self.starts
    }
}

/// The rows of a shaft in one solve. Displacements and offsets are the groove plane's; forces are referred to the shaft's
/// centre.
pub struct Shaft<'a, T, const R: usize, const SET: bool, const E: usize, const D: usize> {
    pub rows: [Row<'a, T>; R],
    pub layout: &'a Layout<'a, T, R, SET, E>,
    /// Inertia `m dm omega^2 / 2` of a ball of the first row.
    pub s: T,
    /// Axial force by which rows of either facing hold each other, besides the load.
    pub preload: &'a mut T,
    /// Elastic state of each row: forces and deflection.
    pub bends: &'a mut [Bend<T, D>; E],
}

impl<T: Real, const R: usize, const SET: bool, const E: usize, const D: usize>
    Shaft<'_, T, R, SET, E, D>
{
    /// Every row, how it sits, and its motion when the shaft has the motion `v`.
    #[inline(always)]
    pub fn each(&mut self, v: &[T; D], mut f: impl FnMut(&mut Row<'_, T>, &Mount<T>, &[T; 5])) {
        // Not `zip`, which the compiler unrolls.
        let (mut mounts, mut bends) = (self.layout.mounts.iter(), self.bends.iter());
        for row in self.rows.iter_mut() {
            let Some(mount) = mounts.next() else { return };
            let mut own = mount.motion::<D, SET>(v);
            if let Some(bend) = bends.next() {
                elastic::add(&mut own, T::ONE, &mount.of_centre(&bend.deflection));
            }
            f(row, mount, &own);
        }
    }

    /// A group of rows by its first row, if there is such a group.
    pub fn group(&self, group: Option<Group<T>>) -> Option<GroupRow<'_, T>> {
        let group = group?;
        let row = self.rows.get(group.first)?;
        Some(GroupRow {
            c: row.c,
            p: row.p,
            mount: self.layout.mounts.get(group.first)?,
            balls: group.balls,
        })
    }

    /// Has the balls of every row that the pass has not condensed yet follow to `v`, and condenses them there; whether it has come to
    /// the end.
    #[inline(never)]
    pub fn condense<A: Rule>(
        &mut self,
        v: &[T; D],
        pass: &mut Pass<T>,
        time: &mut Time<'_>,
    ) -> bool {
        let mut number = 0;
        self.each(v, |row, _, v| {
            number += 1;
            if number <= pass.rows || time.is_up {
                return;
            }
            if pass.starts {
                row.start::<A>(v);
            }
            pass.far |= !row.follow::<A>(v, pass.ds);
            pass.rows = number;
            if number < R {
                time.is_up = !(time.more)();
            }
        });
        pass.rows >= R
    }

    /// Sums the forces and slopes that the balls hand over.
    #[inline(never)]
    pub fn sum<A: Rule>(&mut self, sum: &mut Sum<T, D>) {
        if !SET {
            let row = &self.rows[0];
            sum_up::<T, A, D>(row.balls, row.azimuths, sum);
            sum.refer(row.c.plane);
            return;
        }
        let mut sides = [T::ZERO; 2];
        let mut add = |row: &Row<'_, T>, mount: &Mount<T>, sum: &mut Sum<T, D>| {
            let mut own = Sum::<T, 5>::NONE;
            sum_up::<T, A, 5>(row.balls, row.azimuths, &mut own);
            sides[usize::from(mount.facing < T::ZERO)] += mount.force * own.force[0];
            mount.assemble(&mut own, sum);
        };
        let (rows, mounts) = (&self.rows, &self.layout.mounts);
        if E > 0 {
            let mut add_row = |joint: &Joint<T>, sum: &mut Sum<T, D>| {
                if let (Some(row), Some(mount)) = (rows.get(joint.row), mounts.get(joint.row)) {
                    add(row, mount, sum);
                }
            };
            elastic::fold(&self.layout.joints, self.bends, &mut add_row, sum);
        } else {
            *sum = Sum::NONE;
            let mut mounts = mounts.iter();
            for row in rows {
                let Some(mount) = mounts.next() else { break };
                add(row, mount, sum);
            }
        }
        *self.preload = sides[0].at_most(sides[1]).at_least(T::ZERO);
    }

    /// Changes of the rows along a step `du`.
    #[inline(never)]
    pub fn changes<A: Rule>(&self, du: &[T; D]) -> Changes<T, D> {
        let mut all = Changes {
            k: [T::ZERO; D],
            relative: T::ZERO,
            force_error: T::ZERO,
            largest: T::TINY,
            cos: T::ONE,
        };
        if !SET {
            let own = self.rows[0].changes::<A>(&self.layout.mounts[0].motion::<D, SET>(du));
            return Changes {
                k: vector(|i| own.k[i]),
                relative: own.relative,
                force_error: own.force_error,
                largest: own.largest,
                cos: own.cos,
            };
        }
        let (mut mounts, mut bends) = (self.layout.mounts.iter(), self.bends.iter());
        let mut of_rows = [[T::ZERO; D]; E];
        let mut rows = of_rows.iter_mut();
        for row in self.rows.iter() {
            let Some(mount) = mounts.next() else { break };
            let (bend, of_row) = (bends.next(), rows.next());
            let step = match bend {
                Some(bend) => mount.of_centre(&bend.moved),
                None => mount.motion::<D, SET>(du),
            };
            let own = row.changes::<A>(&step);
            let k = mount.force * mount.length;
            // From the row's groove plane to the shaft's, or to the row's centre.
            let lever = match bend {
                Some(_) => mount.arm * mount.reach,
                None => mount.lever,
            };
            let (arm, lever) = (mount.arm * mount.arm, lever * lever);
            let to = of_row.unwrap_or(&mut all.k);
            to[0] += k * own.k[0];
            to[1] += k * own.k[1];
            to[2] += k * own.k[2];
            to[3] += k * (arm * own.k[3] + lever * own.k[2]);
            to[4] += k * (arm * own.k[4] + lever * own.k[1]);
            if D == 6 && mount.sliding {
                to[5] += k * own.k[0];
            }
            all.relative = all.relative.at_least(own.relative);
            all.force_error = all.force_error.at_least(mount.force * own.force_error);
            all.largest = all.largest.at_least(mount.force * own.largest);
            all.cos = all.cos.at_most(own.cos);
        }
        if E > 0 {
            all.k = elastic::diagonal(&self.layout.joints, self.bends, &of_rows);
        }
        all
    }

    /// Bends an elastic shaft by the step `du` of its section at its centre, and a relative change `ds` of `omega^2`.
    #[inline(always)]
    pub fn bend(&mut self, du: &[T; D], ds: T) {
        if E > 0 {
            let mounts = &self.layout.mounts;
            let slide = |row: usize| match mounts.get(row) {
                Some(mount) if D == 6 && mount.sliding => mount.facing * du[5],
                _ => T::ZERO,
            };
            elastic::unfold(&self.layout.joints, self.bends, &slide, du, ds);
        }
    }

    /// Number of balls that carry.
    #[cold]
    #[inline(never)]
    pub fn loaded(&self) -> u16 {
        self.rows.iter().map(Row::loaded).sum()
    }

    /// The ball whose contacts are furthest apart, counted on from row to row, and that angle, if its cosine is below
    /// `limit`: see [`Row::furthest`].
    pub fn furthest_apart<A: Rule>(&self, limit: T) -> Option<(u16, T)> {
        let (mut furthest, mut before) = (None::<(u16, T)>, 0);
        for row in self.rows.iter() {
            if let Some((ball, apart)) = row.furthest::<A>(limit)
                && furthest.is_none_or(|(_, most)| apart > most)
            {
                furthest = Some((before + ball, apart));
            }
            before += row.balls.len() as u16;
        }
        furthest
    }
}
