//! What a solution holds: what is not asked for is neither stored in it nor worked out.

use crate::float::Print;
use core::fmt::Debug;

mod sealed {
    pub trait Sealed {}
    impl Sealed for super::Displacements {}
    impl Sealed for super::Stiffness {}
    impl Sealed for super::Balls {}
}

/// Displacements and reactions only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Displacements;

/// The stiffness, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stiffness;

/// The stiffness, and the balls' states, which are worked out when they are called for. The default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Balls;

/// In the place of what a scene does not put out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NotPutOut;

/// What a solution holds: [`Displacements`], [`Stiffness`] or [`Balls`]. Sealed.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is nothing that a solution can put out",
    label = "not an output",
    note = "choose `Displacements`, `Stiffness` (with it) or `Balls` (with both)"
)]
pub trait Outputs: sealed::Sealed + 'static {
    /// The stiffness is put out.
    #[doc(hidden)]
    const STIFFNESS: bool;
    /// A stiffness matrix `K`, or [`NotPutOut`].
    type Stiffness<K: Copy + Debug + PartialEq + Print>: Copy + Debug + PartialEq + Print;
    #[doc(hidden)]
    type Balls<S: Copy>: Copy;
    #[doc(hidden)]
    fn stiffness<K: Copy + Debug + PartialEq + Print>(k: K) -> Self::Stiffness<K>;
    #[doc(hidden)]
    fn balls<S: Copy>(solver: S) -> Self::Balls<S>;
}

/// A solution that knows its balls.
#[diagnostic::on_unimplemented(
    message = "a solution with the output `{Self}` does not know its balls",
    label = "no states of balls in this scene",
    note = "give the solver the output `Balls`"
)]
pub trait PerBall: Outputs {
    #[doc(hidden)]
    fn solver<S: Copy>(kept: &Self::Balls<S>) -> S;
}

impl Outputs for Displacements {
    const STIFFNESS: bool = false;
    type Stiffness<K: Copy + Debug + PartialEq + Print> = NotPutOut;
    type Balls<S: Copy> = NotPutOut;
    fn stiffness<K: Copy + Debug + PartialEq + Print>(_: K) -> NotPutOut {
        NotPutOut
    }
    fn balls<S: Copy>(_: S) -> NotPutOut {
        NotPutOut
    }
}

impl Outputs for Stiffness {
    const STIFFNESS: bool = true;
    type Stiffness<K: Copy + Debug + PartialEq + Print> = K;
    type Balls<S: Copy> = NotPutOut;
    fn stiffness<K: Copy + Debug + PartialEq + Print>(k: K) -> K {
        k
    }
    fn balls<S: Copy>(_: S) -> NotPutOut {
        NotPutOut
    }
}

impl Outputs for Balls {
    const STIFFNESS: bool = true;
    type Stiffness<K: Copy + Debug + PartialEq + Print> = K;
    type Balls<S: Copy> = S;
    fn stiffness<K: Copy + Debug + PartialEq + Print>(k: K) -> K {
        k
    }
    fn balls<S: Copy>(solver: S) -> S {
        solver
    }
}

impl PerBall for Balls {
    fn solver<S: Copy>(kept: &S) -> S {
        *kept
    }
}
