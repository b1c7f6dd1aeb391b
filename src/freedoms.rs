//! Freedoms of the inner ring that a scene has.
//!
//! | scene | freedoms | balls |
//! | --- | --- | --- |
//! | [`Axial`] | `dx` | one stands for all: pure axial load, no radial displacement, no tilt |
//! | [`Translations`] | `dx, dy, dz` | all; the tilts are locked at 0, by a moment that is not reported |
//! | [`All`] | `dx, dy, dz, ty, tz` | all |
//!
//! Loads, displacements and stiffness have as many components as there are freedoms. Each smaller scene
//! is the special case of the next, and says the same where it applies.

use crate::float::{Print, Real};
use crate::solver::State;
use core::fmt::Debug;

/// The first `D` of the five freedoms: [`Axial`], [`Translations`] or [`All`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedoms<const D: usize>;

/// The axial freedom alone; one ball stands for all.
pub type Axial = Freedoms<1>;
/// Three translations, the tilts locked at 0.
pub type Translations = Freedoms<3>;
/// Three translations and two tilts.
pub type All = Freedoms<5>;

mod sealed {
    pub trait Sealed {}
    impl<const D: usize> Sealed for super::Freedoms<D> {}
}

/// How many balls are kept for the bearing's `N`. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a set of freedoms of the inner ring",
    label = "not a set of freedoms",
    note = "choose `Axial` (1), `Translations` (3) or `All` (5)"
)]
pub trait BallStore: sealed::Sealed + 'static {
    #[doc(hidden)]
    type Balls<B: Copy + Debug, const N: usize>: Copy + Debug + AsRef<[B]> + AsMut<[B]>;
    #[doc(hidden)]
    fn balls<B: Copy + Debug, const N: usize>(each: B) -> Self::Balls<B, N>;
}

impl BallStore for Axial {
    type Balls<B: Copy + Debug, const N: usize> = [B; 1];
    fn balls<B: Copy + Debug, const N: usize>(each: B) -> [B; 1] {
        [each]
    }
}

impl BallStore for Translations {
    type Balls<B: Copy + Debug, const N: usize> = [B; N];
    fn balls<B: Copy + Debug, const N: usize>(each: B) -> [B; N] {
        [each; N]
    }
}

impl BallStore for All {
    type Balls<B: Copy + Debug, const N: usize> = [B; N];
    fn balls<B: Copy + Debug, const N: usize>(each: B) -> [B; N] {
        [each; N]
    }
}

/// A set of freedoms: [`Axial`], [`Translations`] or [`All`]. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a set of freedoms of the inner ring",
    label = "not a set of freedoms",
    note = "choose `Axial` (1), `Translations` (3) or `All` (5)"
)]
pub trait FreedomSet: BallStore {
    /// Loads or displacements, an array of as many as there are freedoms.
    type Vector<T: Real>: Copy + Debug + PartialEq + Print;
    /// Derivatives of loads (rows) by displacements (columns).
    type Matrix<T: Real>: Copy + Debug + PartialEq + Print;
    #[doc(hidden)]
    type State<T: Real>: Copy + Debug;
}

impl<const D: usize> FreedomSet for Freedoms<D>
where
    Self: BallStore,
{
    type Vector<T: Real> = [T; D];
    type Matrix<T: Real> = [[T; D]; D];
    type State<T: Real> = State<T, D>;
}
