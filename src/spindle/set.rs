//! The rows of a spindle, as the solver moves them.

use crate::float::Real;
use crate::frame::{refer, refer_stiffness};
use crate::kinematics::Rule;
use crate::linalg::Matrix;
use crate::ring::{Changes, Row, Sum, sum_up};
use crate::rows::{Rows, Seat, Stance};
use crate::spindle::Group;

impl<T: Real> Seat<T> {
    /// Factors that mirror the row's force and moments if it faces against the axis, and give the latter the shaft's arm.
    #[inline(always)]
    fn mirror(&self) -> [T; 5] {
        let turn = self.facing * self.arm;
        [self.facing, T::ONE, T::ONE, turn, turn]
    }

    /// Adds the force that a row makes on the shaft, about its centre.
    #[inline(never)]
    fn add_force<const D: usize>(&self, sum: &mut [T; D], own: &[T; 5]) {
        let mirror = self.mirror();
        let mut force = *own;
        refer(self.reach, &mut force);
        for i in 0..5 {
            sum[i] += self.force * (mirror[i] * force[i]);
        }
        if D == 6 && self.sliding {
            sum[5] += self.force * own[0];
        }
    }

    /// Adds the stiffness of a row, or its change, about the shaft's centre.
    #[inline(never)]
    pub(super) fn add_stiffness<const D: usize>(
        &self,
        sum: &mut Matrix<T, D>,
        own: &mut Matrix<T, 5>,
    ) {
        let mirror = self.mirror();
        refer_stiffness(self.reach, own);
        let unit = self.force * self.length;
        for i in 0..5 {
            for j in 0..5 {
                sum[i][j] += unit * (mirror[i] * mirror[j] * own[i][j]);
            }
        }
        if D == 6 && self.sliding {
            for i in 0..5 {
                sum[i][5] += unit * (mirror[i] * own[i][0]);
                sum[5][i] += unit * (mirror[i] * own[0][i]);
            }
            sum[5][5] += unit * own[0][0];
        }
    }
}

/// The rows of a spindle in one solve.
pub struct Set<'a, 'b, T> {
    pub rows: &'a mut [Row<'b, T>],
    pub seats: &'a [Seat<T>],
    /// Axial force by which rows of either facing hold each other.
    pub internal: &'a mut T,
    pub fixed: Group<T>,
    pub sliding: Option<Group<T>>,
    /// Position of the groove plane, and number of balls weighted with their inertia.
    pub plane: T,
    pub weight: T,
}

impl<T: Real, const D: usize> Rows<T, D> for Set<'_, '_, T> {
    fn plane(&self) -> T {
        self.plane
    }

    fn weight(&self) -> T {
        self.weight
    }

    fn inertia(&self) -> T {
        self.rows.first().map_or(T::ZERO, |row| row.p.s)
    }

    fn each(&mut self, v: &[T; D], mut f: impl FnMut(&mut Row<'_, T>, &Seat<T>, &[T; 5])) {
        // Not `zip`, which the compiler unrolls.
        let mut seats = self.seats.iter();
        for row in self.rows.iter_mut() {
            let Some(seat) = seats.next() else { return };
            f(row, seat, &seat.motion(v));
        }
    }

    fn is_opposed(&self) -> bool {
        self.fixed.opposed
    }

    #[inline(never)]
    fn stance(&self, sliding: bool) -> Option<Stance<'_, T>> {
        let group = if sliding { self.sliding? } else { self.fixed };
        let mut rows = self.rows.iter().zip(self.seats);
        let (row, seat) = rows.find(|(_, seat)| seat.sliding == sliding)?;
        Some(Stance {
            c: row.c,
            p: row.p,
            seat: *seat,
            balls: group.balls,
        })
    }

    fn internal(&self) -> T {
        *self.internal
    }

    #[inline(never)]
    fn condense<R: Rule>(&mut self, v: &[T; D], ds: T) -> bool {
        let mut near = true;
        self.each(v, |row, _, v| near &= row.condense_balls::<R>(v, ds));
        near
    }

    fn refer(&mut self, u: &[T; D]) {
        self.each(u, |row, seat, v| row.p.start(row.c, v[0] + seat.closure));
    }

    #[inline(never)]
    fn sum<R: Rule>(&mut self, sum: &mut Sum<T, D>) {
        *sum = Sum::NONE;
        let mut sides = [T::ZERO; 2];
        self.each(&[T::ZERO; D], |row, seat, _| {
            let mut own = Sum::<T, 5>::NONE;
            sum_up::<T, R, 5>(row.balls, row.azimuths, &mut own);
            sides[usize::from(seat.facing < T::ZERO)] += seat.force * own.force[0];
            seat.add_force(&mut sum.force, &own.force);
            seat.add_force(&mut sum.by_speed, &own.by_speed);
            seat.add_stiffness(&mut sum.k, &mut own.k);
        });
        *self.internal = sides[0].at_most(sides[1]).at_least(T::ZERO);
    }

    #[inline(never)]
    fn changes<R: Rule>(&self, du: &[T; D]) -> Changes<T, D> {
        let mut all = Changes {
            k: [T::ZERO; D],
            most: T::ZERO,
            lost: T::ZERO,
            largest: T::TINY,
            cos: T::ONE,
        };
        let mut seats = self.seats.iter();
        for row in self.rows.iter() {
            let Some(seat) = seats.next() else { break };
            let own = row.changes_by::<R>(&seat.motion(du));
            let k = seat.force * seat.length;
            let (arm, lever) = (seat.arm * seat.arm, seat.lever * seat.lever);
            all.k[0] += k * own.k[0];
            all.k[1] += k * own.k[1];
            all.k[2] += k * own.k[2];
            all.k[3] += k * (arm * own.k[3] + lever * own.k[2]);
            all.k[4] += k * (arm * own.k[4] + lever * own.k[1]);
            if D == 6 && seat.sliding {
                all.k[5] += k * own.k[0];
            }
            all.most = all.most.at_least(own.most);
            all.lost = all.lost.at_least(seat.force * own.lost);
            all.largest = all.largest.at_least(seat.force * own.largest);
            all.cos = all.cos.at_most(own.cos);
        }
        all
    }

    fn loaded(&self) -> u16 {
        let rows = self.rows.iter();
        rows.map(|row| Rows::<T, 5>::loaded(row)).sum()
    }

    fn furthest_apart<R: Rule>(&self, limit: T) -> Option<(u16, T)> {
        let (mut furthest, mut before) = (None::<(u16, T)>, 0);
        for row in self.rows.iter() {
            if let Some((ball, apart)) = row.furthest::<R>(limit)
                && furthest.is_none_or(|(_, most)| apart > most)
            {
                furthest = Some((before + ball, apart));
            }
            before += row.balls.len() as u16;
        }
        furthest
    }
}
