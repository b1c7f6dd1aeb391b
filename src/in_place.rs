//! Solvers made where they are to live.
//!
//! Beside `sqrt`, the one module with `unsafe`. Without optimisation, a solver that a function returns is on the stack several
//! times: 73 kB for four rows, more than a small chip has. Here, nothing larger than a ball or a [`State`] is.

use crate::ball::Ball;
use crate::ball::contact::Point;
use crate::ball::kinematics::{Motion, Speed};
use crate::bearing::Bearing;
use crate::real::Real;
use crate::shaft::elastic::Bend;
use crate::solver::Solver;
use crate::solver::problem::RingVector;
use crate::solver::state::State;
use crate::solver::warm_start::WarmStart;
use crate::spindle::Spindle;
use crate::spindle::solver::SpindleSolver;
use core::mem::MaybeUninit;

impl<'b, T: Real, const N: usize, M: Motion, const D: usize> Solver<'b, T, N, M, D> {
    /// [`Solver::of`] in a place that is given, such as a static: no copy of the solver is on the stack.
    ///
    /// The place needs its type. In firmware it is a static's, of one of these crates:
    ///
    /// ```ignore
    /// type One = Solver<'static, f32, 15>;
    /// // static_cell, as in Embassy
    /// static PLACE: StaticCell<One> = StaticCell::new();
    /// let solver = One::new_in(&BEARING, PLACE.uninit());
    /// // cortex-m
    /// let place = singleton!(: MaybeUninit<One> = MaybeUninit::uninit());
    /// // RTIC 2
    /// #[init(local = [place: MaybeUninit<One> = MaybeUninit::uninit()])]
    /// ```
    ///
    /// ```
    /// use core::mem::MaybeUninit;
    /// use spindle_bearing::{Bearing, Design, Solver};
    ///
    /// const DESIGN: Design = Design::angular_contact(6.35e-3, 36e-3, 15_f64.to_radians());
    /// static BEARING: Bearing<f32, 15> = Bearing::<f32, 15>::const_new(&DESIGN);
    /// type One = Solver<'static, f32, 15>;
    /// let mut place = MaybeUninit::<One>::uninit();
    /// let solver = One::new_in(&BEARING, &mut place);
    /// # assert!(solver.unfinished().is_none());
    /// ```
    pub fn new_in<'m>(bearing: &'b Bearing<T, N>, place: &'m mut MaybeUninit<Self>) -> &'m mut Self
    where
        [T; D]: RingVector,
    {
        let solver = place.as_mut_ptr();
        // SAFETY: the place is writable and aligned; every field but the motion, which has no size, is written.
        let solver = unsafe {
            (&raw mut (*solver).bearing).write(bearing);
            write_cold(&raw mut (*solver).last);
            place.assume_init_mut()
        };
        // A new field does not compile until it is written above.
        let Self {
            bearing: _,
            last: _,
            motion: _,
        } = solver;
        solver
    }
}

impl<'b, T: Real, const R: usize, const N: usize, M: Motion, const D: usize, const E: usize>
    SpindleSolver<'b, T, R, N, M, D, E>
{
    /// [`SpindleSolver::of`] in a place that is given, such as a static: no copy of the solver is on the stack.
    ///
    /// See [`Solver::new_in`] for an example.
    pub fn new_in<'m>(
        spindle: Spindle<'b, T, R, N, D, E>,
        place: &'m mut MaybeUninit<Self>,
    ) -> &'m mut Self {
        let solver = place.as_mut_ptr();
        // SAFETY: the place is writable and aligned; every field but the motion, which has no size, is written.
        let solver = unsafe {
            (&raw mut (*solver).spindle).write(spindle);
            write_cold(&raw mut (*solver).last);
            place.assume_init_mut()
        };
        // A new field does not compile until it is written above.
        let Self {
            spindle: _,
            last: _,
            motion: _,
        } = solver;
        solver
    }
}

/// Writes [`WarmStart::COLD`].
///
/// # Safety
///
/// As for [`core::ptr::write`].
unsafe fn write_cold<T: Real, const R: usize, const N: usize, const D: usize, const E: usize>(
    to: *mut WarmStart<T, R, N, D, E>,
) {
    // SAFETY: arrays are their elements, one after the other.
    unsafe {
        (&raw mut (*to).state).write(State::COLD);
        let balls = (&raw mut (*to).balls).cast::<Ball<T>>();
        for i in 0..R * N {
            balls.add(i).write(Ball::NONE);
        }
        let points = (&raw mut (*to).points).cast::<Point<T>>();
        for i in 0..R {
            points.add(i).write(Point::NONE);
        }
        (&raw mut (*to).preload).write(T::ZERO);
        (&raw mut (*to).speed).write(Speed::REST);
        let bends = (&raw mut (*to).bends).cast::<Bend<T, D>>();
        for i in 0..E {
            bends.add(i).write(Bend::NONE);
        }
        // A new field does not compile until it is written above.
        let WarmStart {
            state: _,
            balls: _,
            points: _,
            preload: _,
            speed: _,
            bends: _,
        } = &*to;
    }
}
