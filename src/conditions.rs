//! What is given of each freedom: its load, or its displacement.
//!
//! [`Loads`] gives every load. A tuple with one of [`Load`] and [`Displacement`] per freedom mixes
//! them: `(Displacement, Load, Load, Load, Load)` is a bearing under rigid axial preload. A freedom
//! whose displacement is given is *held*: its equation is not solved, the displacement is met exactly,
//! and its load, the reaction, is in [`Solution::load`](crate::Solution::load). The stiffness is that of
//! the freedoms that are free.

use crate::constants::Constants;
use crate::float::{Print, Real};
use crate::freedoms::{All, Axial, BallStore, FreedomSet, Freedoms, Translations};
use crate::ring::Tangent;
use core::array::from_fn;
use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Load {}
    impl Sealed for super::Displacement {}
    impl Sealed for super::Loads {}
    impl<X> Sealed for (X,) {}
    impl<X, Y, Z> Sealed for (X, Y, Z) {}
    impl<X, Y, Z, Ty, Tz> Sealed for (X, Y, Z, Ty, Tz) {}
}

/// The load of this freedom is given; its displacement is solved for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Load;

/// The displacement of this freedom is given; its load is the reaction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Displacement;

/// The load of every freedom is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Loads;

/// Of [`All`] freedoms, the axial displacement is given: a preload by spacers between two bearings.
pub type RigidPreload = (Displacement, Load, Load, Load, Load);

/// Of [`All`] freedoms, both tilts are given: a shaft that is much stiffer than the bearing.
pub type ImposedTilt = (Load, Load, Load, Displacement, Displacement);

/// What is given of one freedom: [`Load`] or [`Displacement`]. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is nothing that can be given of a freedom",
    label = "neither `Load` nor `Displacement`"
)]
pub trait Condition: sealed::Sealed + 'static {
    #[doc(hidden)]
    const HELD: bool;
    /// One more than `C` if the freedom is free.
    #[doc(hidden)]
    type After<C: Count>: Count;
}

impl Condition for Load {
    const HELD: bool = false;
    type After<C: Count> = C::Next;
}

impl Condition for Displacement {
    const HELD: bool = true;
    type After<C: Count> = C;
}

/// A number of free freedoms, as a type.
#[derive(Debug, Clone, Copy)]
pub struct Size<const K: usize>;

/// The next number, which the compiler does not work out for us.
pub trait Successor {
    type Next: Count;
}

impl Successor for Size<0> {
    type Next = Size<1>;
}
impl Successor for Size<1> {
    type Next = Size<2>;
}
impl Successor for Size<2> {
    type Next = Size<3>;
}
impl Successor for Size<3> {
    type Next = Size<4>;
}
impl Successor for Size<4> {
    type Next = Size<5>;
}
impl Successor for Size<5> {
    type Next = Size<5>;
}

/// A number of free freedoms and the stiffness among them.
pub trait Count: Successor {
    type Matrix<T: Real>: Copy + Debug + PartialEq + Print + IntoIterator<Item: AsRef<[T]>>;
    fn select<T: Real, const D: usize>(k: &Tangent<T, D>, held: &[bool; 5]) -> Self::Matrix<T>;
}

impl<const K: usize> Count for Size<K>
where
    Self: Successor,
{
    type Matrix<T: Real> = [[T; K]; K];

    #[inline]
    fn select<T: Real, const D: usize>(k: &Tangent<T, D>, held: &[bool; 5]) -> [[T; K]; K] {
        let mut rows = k.iter().zip(held).filter(|(_, held)| !**held);
        from_fn(|_| {
            let row = rows.next().map_or([T::ZERO; D], |(row, _)| *row);
            let mut elements = row.into_iter().zip(held).filter(|(_, held)| !**held);
            from_fn(|_| elements.next().map_or(T::ZERO, |(element, _)| element))
        })
    }
}

/// At least one freedom is free.
#[diagnostic::on_unimplemented(
    message = "the displacement of every freedom is given, so that there is nothing to solve",
    label = "no freedom is free",
    note = "`Solver::law` gives forces and tangent for displacements"
)]
pub trait Free: Count {}
impl Free for Size<1> {}
impl Free for Size<2> {}
impl Free for Size<3> {}
impl Free for Size<4> {}
impl Free for Size<5> {}

/// What is given of the freedoms `F`: [`Loads`], or a tuple with a [`Load`] or a [`Displacement`] for
/// each. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say what is given of each freedom of `{F}`",
    label = "not the conditions of these freedoms",
    note = "`Loads` gives every load; a tuple of `Load` and `Displacement` has one for each freedom: 1 of \
            `Axial`, 3 of `Translations`, 5 of `All`",
    note = "only `All` has tilts to hold: where one ball stands for all, or the tilts are locked, there \
            are none"
)]
pub trait Conditions<F: FreedomSet>: sealed::Sealed + 'static {
    /// Which freedoms are held; of the first ones, if there are fewer than 5.
    #[doc(hidden)]
    const HELD: [bool; 5];
    /// Some are.
    #[doc(hidden)]
    const HOLDS: bool =
        Self::HELD[0] || Self::HELD[1] || Self::HELD[2] || Self::HELD[3] || Self::HELD[4];
    /// Stiffness of the free freedoms, the others held: an array of rows.
    type Stiffness<T: Real>: Copy + Debug + PartialEq + Print + IntoIterator<Item: AsRef<[T]>>;
    #[doc(hidden)]
    fn stiffness<T: Real>(k: &F::Matrix<T>) -> Self::Stiffness<T>;
}

impl<const D: usize> Conditions<Freedoms<D>> for Loads
where
    Freedoms<D>: BallStore,
{
    const HELD: [bool; 5] = [false; 5];
    type Stiffness<T: Real> = [[T; D]; D];

    #[inline(always)]
    fn stiffness<T: Real>(k: &[[T; D]; D]) -> [[T; D]; D] {
        *k
    }
}

type OfOne<X> = <X as Condition>::After<Size<0>>;
type OfThree<X, Y, Z> = <Z as Condition>::After<<Y as Condition>::After<OfOne<X>>>;
type OfFive<X, Y, Z, Ty, Tz> = <Tz as Condition>::After<<Ty as Condition>::After<OfThree<X, Y, Z>>>;

impl<X: Condition> Conditions<Axial> for (X,)
where
    OfOne<X>: Free,
{
    const HELD: [bool; 5] = [X::HELD, false, false, false, false];
    type Stiffness<T: Real> = <OfOne<X> as Count>::Matrix<T>;

    #[inline]
    fn stiffness<T: Real>(k: &[[T; 1]; 1]) -> Self::Stiffness<T> {
        OfOne::<X>::select(k, &Self::HELD)
    }
}

impl<X: Condition, Y: Condition, Z: Condition> Conditions<Translations> for (X, Y, Z)
where
    OfThree<X, Y, Z>: Free,
{
    const HELD: [bool; 5] = [X::HELD, Y::HELD, Z::HELD, false, false];
    type Stiffness<T: Real> = <OfThree<X, Y, Z> as Count>::Matrix<T>;

    #[inline]
    fn stiffness<T: Real>(k: &[[T; 3]; 3]) -> Self::Stiffness<T> {
        OfThree::<X, Y, Z>::select(k, &Self::HELD)
    }
}

impl<X: Condition, Y: Condition, Z: Condition, Ty: Condition, Tz: Condition> Conditions<All>
    for (X, Y, Z, Ty, Tz)
where
    OfFive<X, Y, Z, Ty, Tz>: Free,
{
    const HELD: [bool; 5] = [X::HELD, Y::HELD, Z::HELD, Ty::HELD, Tz::HELD];
    type Stiffness<T: Real> = <OfFive<X, Y, Z, Ty, Tz> as Count>::Matrix<T>;

    #[inline]
    fn stiffness<T: Real>(k: &[[T; 5]; 5]) -> Self::Stiffness<T> {
        OfFive::<X, Y, Z, Ty, Tz>::select(k, &Self::HELD)
    }
}

/// Puts in the place of the held freedoms' equations that they make the steps `by` (of the bearing
/// centre): of the unbalanced load `b` and the tangent, both of the groove plane.
///
/// A radial displacement is held at the bearing centre, so that a tilt moves the groove plane sideways:
/// `vy - p tz` is held, with `p` the plane's distance, and the moment equation of the tilt is the one
/// about the bearing centre, which the reaction does not enter.
#[inline(always)]
pub fn hold<T: Real, B: Conditions<Freedoms<D>>, const D: usize>(
    c: &Constants<T>,
    by: &[T; D],
    b: &mut [T; D],
    tangent: &mut Tangent<T, D>,
) where
    Freedoms<D>: BallStore,
{
    if !B::HOLDS {
        return;
    }
    let diagonal: [T; D] = from_fn(|i| {
        let stiff = tangent[i][i].abs();
        if stiff > T::TINY { stiff } else { T::ONE }
    });
    // Row and column of a tilt, those of the radial displacement that it makes, and its sign.
    let pairs = [(4, 1, T::ONE), (3, 2, -T::ONE)];
    if D == 5 {
        for (tilt, radial, sign) in pairs {
            if B::HELD[radial] {
                let arm = sign * c.plane;
                b[tilt] += arm * b[radial];
                for j in 0..D {
                    let across = tangent[radial][j];
                    tangent[tilt][j] += arm * across;
                }
            }
        }
    }
    for i in 0..D {
        if B::HELD[i] {
            b[i] = diagonal[i] * by[i];
            tangent[i] = from_fn(|j| if j == i { diagonal[i] } else { T::ZERO });
        }
    }
    if D == 5 {
        for (tilt, radial, sign) in pairs {
            if B::HELD[radial] {
                tangent[radial][tilt] = -(diagonal[radial] * sign * c.plane);
            }
        }
    }
}

/// As [`hold`], of a tangent that stays what it is: where freedoms are held, their equations go in a `copy`,
/// and nothing is copied elsewhere.
#[inline(always)]
pub fn held<'t, T: Real, B: Conditions<Freedoms<D>>, const D: usize>(
    c: &Constants<T>,
    by: &[T; D],
    b: &mut [T; D],
    tangent: &'t Tangent<T, D>,
    copy: &'t mut Tangent<T, D>,
) -> &'t Tangent<T, D>
where
    Freedoms<D>: BallStore,
{
    if !B::HOLDS {
        return tangent;
    }
    *copy = *tangent;
    hold::<T, B, D>(c, by, b, copy);
    copy
}

/// Makes the held freedoms' part of the step `d` of the groove plane exactly the steps `by` of the
/// bearing centre.
#[inline(always)]
pub fn constrain<T: Real, B: Conditions<Freedoms<D>>, const D: usize>(
    c: &Constants<T>,
    by: &[T; D],
    d: &mut [T; D],
) where
    Freedoms<D>: BallStore,
{
    if !B::HOLDS {
        return;
    }
    for (i, (step, by)) in d.iter_mut().zip(by).enumerate() {
        if B::HELD[i] {
            *step = *by;
        }
    }
    if D == 5 {
        if B::HELD[1] {
            d[1] += c.plane * d[4];
        }
        if B::HELD[2] {
            d[2] -= c.plane * d[3];
        }
    }
}

/// How far the held freedoms still are from where they are `wanted`, of the bearing centre; 0 of the
/// others. `at` is the position of the groove plane.
#[inline(always)]
pub fn missing<T: Real, B: Conditions<Freedoms<D>>, const D: usize>(
    c: &Constants<T>,
    wanted: &[T; D],
    at: &[T; D],
) -> [T; D]
where
    Freedoms<D>: BallStore,
{
    let mut centre = *at;
    if D == 5 {
        centre[1] -= c.plane * at[4];
        centre[2] += c.plane * at[3];
    }
    from_fn(|i| {
        if B::HELD[i] {
            wanted[i] - centre[i]
        } else {
            T::ZERO
        }
    })
}
