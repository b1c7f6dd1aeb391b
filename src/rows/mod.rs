//! A shaft in its rows of balls: turns the shaft's motion into the rows' motions, and adds up the rows' forces.
//!
//! A bearing is a shaft with one row, in the frame and the units of that row. `SET` says whether rows have mounts of their own;
//! a bearing alone has [`Mount::PLAIN`], and its loop leaves that arithmetic out.

pub mod elastic;
pub mod row;

use crate::ball::kinematics::Rule;
use crate::bearing::{Azimuth, Bearing, Constants};
use crate::linalg::vector;
use crate::real::Real;
use crate::rows::elastic::{Deflection, Joint};
use crate::rows::row::{Estimate, Mount, Row, Sum, in_full, sum_up};

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

/// A bearing at its place on the shaft.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'b, T> {
    pub bearing: BearingRef<'b, T>,
    pub mount: Mount<T>,
    /// Position of its centre, m.
    pub position: T,
}

/// Bearings and how they sit on the shaft: all that no solve changes.
#[derive(Debug, Clone, Copy)]
pub struct Layout<'b, T, const R: usize, const SET: bool, const E: usize> {
    pub rows: [Placed<'b, T>; R],
    /// Rows that are fixed, and rows that slide.
    pub fixed: Group<T>,
    pub sliding: Option<Group<T>>,
    /// Axial position of the groove plane from the shaft's centre, over `Rp`.
    pub plane: T,
    /// Number of balls, weighted with their inertia in units of the first row.
    pub ball_count: T,
    /// Estimate of the preload at rest, in the shaft's unit of force; load scales are at least this.
    pub preload_at_rest: T,
    /// The chain of an elastic shaft, `E = R`; a rigid one has none, `E = 0`. One that may be either has room for more, `E > R`.
    pub joints: [Joint<T>; E],
    /// Fingerprint of bearings and shaft: a solver that has solved others starts cold.
    pub fingerprint: u32,
    /// Number of rows that there are, the first of `rows`. The others are the first one without balls.
    pub count: u16,
    /// A shaft that may be either bends, or a support gives way.
    pub bends: bool,
}

impl<'b, T: Real, const R: usize, const SET: bool, const E: usize> Layout<'b, T, R, SET, E> {
    /// Number of rows. Fewer than `R` are of a type that has room for more joints than rows alone: of others, as of all on a board,
    /// the compiler knows the number, and what is left out.
    #[inline(always)]
    pub const fn count(&self) -> usize {
        if E <= R || self.count as usize > R {
            R
        } else {
            self.count as usize
        }
    }

    /// The rows that there are.
    #[inline(always)]
    pub fn rows(&self) -> &[Placed<'b, T>] {
        self.rows.get(..self.count()).unwrap_or(&self.rows)
    }

    /// Number of joints: one for each row if the shaft bends.
    #[inline(always)]
    const fn bending(&self) -> usize {
        if self.bends() { self.count() } else { 0 }
    }

    /// Whether rows slide in a sleeve, the sixth freedom: a shaft that may be elastic or rigid may have it or not.
    #[inline(always)]
    pub const fn has_sleeve<const D: usize>(&self) -> bool {
        D == 6 && (E <= R || self.sliding.is_some())
    }

    /// Whether the shaft bends.
    #[inline(always)]
    pub const fn bends(&self) -> bool {
        E > 0 && (E == R || self.bends)
    }

    /// The joints, if the shaft bends.
    #[inline(always)]
    pub fn joints(&self) -> &[Joint<T>] {
        self.of_joints(&self.joints)
    }

    /// As many of these, which are one for each joint, as there are joints.
    #[inline(always)]
    pub fn of_joints<'x, X>(&self, all: &'x [X; E]) -> &'x [X] {
        if E == 0 {
            return &[];
        }
        all.get(..self.bending()).unwrap_or_default()
    }

    /// [`Self::of_joints`] to be changed.
    #[inline(always)]
    pub fn of_joints_mut<'x, X>(&self, all: &'x mut [X; E]) -> &'x mut [X] {
        if E == 0 {
            return &mut [];
        }
        all.get_mut(..self.bending()).unwrap_or_default()
    }
}

impl<'b, T: Real> Layout<'b, T, 1, false, 0> {
    /// A bearing alone.
    #[inline(always)]
    pub fn alone(c: &'b Constants<T>, azimuths: &'b [Azimuth<T>]) -> Self {
        Self {
            rows: [Placed {
                bearing: BearingRef { c, azimuths },
                mount: Mount::PLAIN,
                position: T::ZERO,
            }],
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
            count: 1,
            bends: false,
        }
    }
}

impl<'b, T: Real, const R: usize> Layout<'b, T, R, true, 0> {
    /// These rows on a shaft that may bend, and does if it `bends`.
    pub const fn with_joints<const E: usize>(
        self,
        joints: [Joint<T>; E],
        bends: bool,
    ) -> Layout<'b, T, R, true, E> {
        let Self {
            rows,
            fixed,
            sliding,
            plane,
            ball_count,
            preload_at_rest,
            joints: [],
            fingerprint,
            count,
            bends: _,
        } = self;
        Layout {
            rows,
            fixed,
            sliding,
            plane,
            ball_count,
            preload_at_rest,
            joints,
            fingerprint,
            count,
            bends,
        }
    }
}

impl<T: Real, const N: usize> Bearing<T, N> {
    /// The bearing alone.
    #[inline(always)]
    pub(crate) fn layout(&self) -> Layout<'_, T, 1, false, 0> {
        Layout::alone(&self.constants, self.azimuths())
    }
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
pub struct Rows<'a, T, const R: usize, const SET: bool, const E: usize, const D: usize> {
    pub rows: [Row<'a, T>; R],
    pub layout: &'a Layout<'a, T, R, SET, E>,
    /// Inertia `m dm omega^2 / 2` of a ball of the first row.
    pub s: T,
    /// Axial force by which rows of either facing hold each other, besides the load.
    pub preload: &'a mut T,
    /// Elastic state of each row: forces and deflection.
    pub deflections: &'a mut [Deflection<T, D>; E],
}

impl<T: Real, const R: usize, const SET: bool, const E: usize, const D: usize>
    Rows<'_, T, R, SET, E, D>
{
    /// The rows that there are.
    #[inline(always)]
    fn rows(&self) -> &[Row<'_, T>] {
        self.rows.get(..self.layout.count()).unwrap_or_default()
    }

    /// Deflections of the rows, if the shaft bends.
    #[inline(always)]
    pub fn deflections(&mut self) -> &mut [Deflection<T, D>] {
        self.layout.of_joints_mut(self.deflections)
    }

    /// Every row, and its motion when the shaft has the motion `v`.
    #[inline(always)]
    pub fn each(&mut self, v: &[T; D], mut f: impl FnMut(&mut Row<'_, T>, &[T; 5])) {
        // Not `zip`, which the compiler unrolls.
        let mut deflections = self.layout.of_joints(self.deflections).iter();
        let rows = self.rows.get_mut(..self.layout.count());
        for row in rows.unwrap_or_default() {
            let mut own = row.mount.motion::<D, SET>(v);
            if let Some(deflection) = deflections.next() {
                row.mount.deflect(&mut own, &deflection.now);
            }
            f(row, &own);
        }
    }

    /// The first row of a group.
    pub fn first_of(&self, group: &Group<T>) -> Option<&Row<'_, T>> {
        self.rows.get(group.first)
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
        self.each(v, |row, v| {
            number += 1;
            if number <= pass.rows || time.is_up {
                return;
            }
            if pass.starts {
                row.start::<A>(v);
            }
            pass.far |= !row.follow::<A>(v, pass.ds);
            pass.rows = number;
            time.is_up = !(time.more)();
        });
        pass.rows >= self.layout.count()
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
        let mut add = |row: &Row<'_, T>, sum: &mut Sum<T, D>| {
            let mut own = Sum::<T, 5>::NONE;
            sum_up::<T, A, 5>(row.balls, row.azimuths, &mut own);
            sides[usize::from(row.mount.facing < T::ZERO)] += row.mount.force * own.force[0];
            row.mount.assemble(&mut own, sum);
        };
        let layout = self.layout;
        let rows = self.rows.get(..layout.count()).unwrap_or_default();
        if layout.bends() {
            let mut add_row = |row: usize, sum: &mut Sum<T, D>| {
                if let Some(row) = rows.get(row) {
                    add(row, sum);
                }
            };
            let deflections = layout.of_joints_mut(self.deflections);
            elastic::fold(layout.joints(), deflections, &mut add_row, sum);
        } else {
            *sum = Sum::NONE;
            for row in rows {
                add(row, sum);
            }
        }
        *self.preload = sides[0].at_most(sides[1]).at_least(T::ZERO);
        if D == 6 && !layout.has_sleeve::<D>() {
            // For the factors of a problem without displacements: no pivot of the shaft's is other by that.
            sum.k[D - 1][D - 1] = sum.k[0][0];
        }
    }

    /// Changes of the stiffness's diagonal along a step `du`, and the rest of their estimate; its force is the largest error.
    #[inline(never)]
    pub fn changes<A: Rule>(&self, du: &[T; D]) -> ([T; D], Estimate<T>) {
        if !SET {
            let (k, estimate) = self.rows[0].changes::<A>(&in_full(du));
            return (vector(|i| k[i]), estimate);
        }
        let (mut k, mut all) = ([T::ZERO; D], Estimate::<T>::NONE);
        let all_deflections = self.layout.of_joints(self.deflections);
        let mut deflections = all_deflections.iter();
        let mut of_rows = [[T::ZERO; D]; E];
        let of_rows = self.layout.of_joints_mut(&mut of_rows);
        let mut rows = of_rows.iter_mut();
        for row in self.rows() {
            let (mount, deflection, of_row) = (row.mount, deflections.next(), rows.next());
            let step = match deflection {
                Some(deflection) => mount.of_centre(&deflection.moved),
                None => mount.motion::<D, SET>(du),
            };
            let (own, estimate) = row.changes::<A>(&step);
            let unit = mount.force * mount.length;
            // From the row's groove plane to the shaft's, or to the row's centre.
            let lever = match deflection {
                Some(_) => mount.arm * mount.reach,
                None => mount.lever,
            };
            let (arm, lever) = (mount.arm * mount.arm, lever * lever);
            let to = of_row.unwrap_or(&mut k);
            to[0] += unit * own[0];
            to[1] += unit * own[1];
            to[2] += unit * own[2];
            to[3] += unit * (arm * own[3] + lever * own[2]);
            to[4] += unit * (arm * own[4] + lever * own[1]);
            if D == 6 && mount.sliding {
                to[5] += unit * own[0];
            }
            all.relative = all.relative.at_least(estimate.relative);
            all.force = all.force.at_least(mount.force * estimate.force);
            all.largest = all.largest.at_least(mount.force * estimate.largest);
            all.cos = all.cos.at_most(estimate.cos);
        }
        if self.layout.bends() {
            k = elastic::diagonal(self.layout.joints(), all_deflections, of_rows);
        }
        (k, all)
    }

    /// Largest force of second order on a ball along a step `du`: see [`Row::second_order`].
    #[cold]
    #[inline(never)]
    pub fn second_order<A: Rule>(&self, du: &[T; D]) -> T {
        let deflections = self.layout.of_joints(self.deflections);
        let (mut largest, mut deflections) = (T::ZERO, deflections.iter());
        for row in self.rows() {
            let step = match deflections.next() {
                _ if !SET => in_full(du),
                Some(deflection) => row.mount.of_centre(&deflection.moved),
                None => row.mount.motion::<D, SET>(du),
            };
            largest = largest.at_least(row.mount.force * row.second_order::<A>(&step));
        }
        largest
    }

    /// Deflects shaft and supports by the step `du` of the section at the shaft's centre, and a relative change `ds` of `omega^2`.
    #[inline(always)]
    pub fn deflect(&mut self, du: &[T; D], ds: T) {
        let layout = self.layout;
        if layout.bends() {
            let rows = layout.rows();
            let slide = |row: usize| match rows.get(row) {
                Some(row) if D == 6 && row.mount.sliding => row.mount.facing * du[5],
                _ => T::ZERO,
            };
            let deflections = layout.of_joints_mut(self.deflections);
            elastic::unfold(layout.joints(), deflections, &slide, du, ds);
        }
    }

    /// Number of balls that carry.
    #[cold]
    #[inline(never)]
    pub fn loaded(&self) -> u16 {
        self.rows().iter().map(Row::loaded).sum()
    }

    /// The ball whose contacts are furthest apart, counted on from row to row, and that angle, if its cosine is below
    /// `limit`: see [`Row::furthest`].
    pub fn furthest_apart<A: Rule>(&self, limit: T) -> Option<(u16, T)> {
        let (mut furthest, mut before) = (None::<(u16, T)>, 0);
        for row in self.rows() {
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
