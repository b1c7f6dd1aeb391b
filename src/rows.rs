//! What the solver moves: the balls of one bearing, or of all bearings on a shaft.

use super::constants::Constants;
use super::float::Real;
use super::kinematics::Rule;
use super::mounting::Point;
use super::ring::{Changes, Row, Sum, in_full, sum_up};

/// How a row sits on the shaft, and what turns the shaft's motion and force into the row's.
///
/// Shaft and row have frames and units of their own: those of the shaft are those of its first row. A row that faces
/// against the axis is mirrored. Its motion is `r P v` with the shaft's motion `v` of the groove plane, the force on the shaft
/// `phi P^T F`:
///
/// `P v = (s vx + e, vy + l vtz, vz - l vty, s m vty, s m vtz)`
///
/// with the motion `e` of the row's sleeve towards its balls, if that slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seat<T> {
    /// `s`: 1, or -1 for a row that faces against the axis.
    pub facing: T,
    /// `r` and `phi`: the shaft's unit of length over the row's, the row's unit of force over the shaft's.
    pub length: T,
    pub force: T,
    /// `l`: the row's groove plane beyond the shaft's, over the shaft's `Rp`.
    pub lever: T,
    /// The row's groove plane beyond the shaft's centre, in the row's own direction and over its own `Rp`.
    pub reach: T,
    /// `m`: `Rp` of the row over that of the shaft.
    pub arm: T,
    /// Inertia `m dm omega^2 / 2` of a ball over that of the first row's, in either row's unit of force.
    pub inertia: T,
    /// Closure, in the row's unit of length.
    pub closure: T,
    /// The row's sleeve slides under a spring.
    pub sliding: bool,
}

impl<T: Real> Seat<T> {
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
    #[inline(never)]
    pub fn motion<const D: usize>(&self, v: &[T; D]) -> [T; 5] {
        let r = self.length;
        let mut own = in_full(v);
        if D == 6 && self.sliding {
            own[0] += self.facing * v[5];
        }
        if D >= 5 {
            own[1] += self.lever * own[4];
            own[2] -= self.lever * own[3];
        }
        own[0] = r * (self.facing * own[0]);
        own[1] = r * own[1];
        own[2] = r * own[2];
        let turn = r * (self.facing * self.arm);
        own[3] = turn * own[3];
        own[4] = turn * own[4];
        own
    }

    /// The row's axial displacement from where its own contacts would be free, for the shaft's displacement `u`.
    #[inline(never)]
    pub fn axial<const D: usize>(&self, u: &[T; D]) -> T {
        let [axial, ..] = self.motion(u);
        axial + self.closure
    }
}

/// Rows that hold the shaft together, or are pressed by one spring: as a start sees them, by the first one.
#[derive(Debug, Clone, Copy)]
pub struct Stance<'a, T> {
    pub c: &'a Constants<T>,
    pub p: &'a Point<T>,
    pub seat: Seat<T>,
    /// Number of their balls.
    pub balls: T,
}

/// What the solver moves and condenses. Displacements and offsets are those of the shaft's groove plane; what is summed is
/// referred to its centre.
pub trait Rows<T: Real, const D: usize> {
    /// Axial position of the groove plane, from the centre, over `Rp`.
    fn plane(&self) -> T;

    /// Number of balls, weighted with their inertia in units of the first row.
    fn weight(&self) -> T;

    /// Inertia `m dm omega^2 / 2` of a ball of the first row.
    fn inertia(&self) -> T;

    /// Every row, how it sits, and its offset when the shaft has the offset `v`.
    fn each(&mut self, v: &[T; D], f: impl FnMut(&mut Row<'_, T>, &Seat<T>, &[T; 5]));

    /// Rows that do not slide hold the shaft from either side.
    fn is_opposed(&self) -> bool;

    /// The rows that slide, or those that do not.
    fn stance(&self, sliding: bool) -> Option<Stance<'_, T>>;

    /// Axial force by which rows hold each other, besides the load.
    fn internal(&self) -> T;

    /// Has every ball follow to `v` and a relative change `ds` of `omega^2`, and condenses it there; whether all are near
    /// their balance.
    fn condense<R: Rule>(&mut self, v: &[T; D], ds: T) -> bool;

    /// Has offsets count from the shaft's displacement `u`, which is axial.
    fn refer(&mut self, u: &[T; D]);

    /// Sums what the balls hand over.
    fn sum<R: Rule>(&mut self, sum: &mut Sum<T, D>);

    /// What a step `du` changes of the rows.
    fn changes<R: Rule>(&self, du: &[T; D]) -> Changes<T, D>;

    /// Number of balls that carry, and that of the ball whose contacts are furthest apart, with that angle, if the cosine
    /// is below `limit`: see [`Row::furthest_apart`].
    fn loaded(&self) -> u16;
    fn furthest_apart<R: Rule>(&self, limit: T) -> Option<(u16, T)>;
}

impl<T: Real, const D: usize> Rows<T, D> for Row<'_, T> {
    #[inline(always)]
    fn plane(&self) -> T {
        self.c.plane
    }

    #[inline(always)]
    fn weight(&self) -> T {
        self.c.balls
    }

    #[inline(always)]
    fn inertia(&self) -> T {
        self.p.s
    }

    #[inline(always)]
    fn each(&mut self, v: &[T; D], mut f: impl FnMut(&mut Row<'_, T>, &Seat<T>, &[T; 5])) {
        f(self, &Seat::PLAIN, &in_full(v));
    }

    #[inline(always)]
    fn is_opposed(&self) -> bool {
        false
    }

    #[inline(always)]
    fn stance(&self, sliding: bool) -> Option<Stance<'_, T>> {
        let own = Stance {
            c: self.c,
            p: self.p,
            seat: Seat::PLAIN,
            balls: self.c.balls,
        };
        (!sliding).then_some(own)
    }

    #[inline(always)]
    fn internal(&self) -> T {
        T::ZERO
    }

    #[inline(always)]
    fn condense<R: Rule>(&mut self, v: &[T; D], ds: T) -> bool {
        self.condense_balls::<R>(&in_full(v), ds)
    }

    #[inline(always)]
    fn refer(&mut self, u: &[T; D]) {
        self.p.start(self.c, u[0]);
    }

    #[inline(always)]
    fn sum<R: Rule>(&mut self, sum: &mut Sum<T, D>) {
        sum_up::<T, R, D>(self.balls, self.azimuths, sum);
        sum.refer(self.c.plane);
    }

    #[inline(always)]
    fn changes<R: Rule>(&self, du: &[T; D]) -> Changes<T, D> {
        let of_row = self.changes_by::<R>(&in_full(du));
        let mut k = [T::ZERO; D];
        k.copy_from_slice(&of_row.k[..D]);
        Changes {
            k,
            most: of_row.most,
            lost: of_row.lost,
            largest: of_row.largest,
            cos: of_row.cos,
        }
    }

    #[cold]
    #[inline(never)]
    fn loaded(&self) -> u16 {
        let loaded = self.balls.iter().filter(|ball| ball.carries(self.p));
        loaded.count() as u16
    }

    #[inline(always)]
    fn furthest_apart<R: Rule>(&self, limit: T) -> Option<(u16, T)> {
        self.furthest::<R>(limit)
    }
}
