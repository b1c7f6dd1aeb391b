//! How the balls move, chosen by type.

use super::kinematics::{AtRest, Frictionless, Rule};
use core::marker::PhantomData;

/// How the balls move: [`Static`], [`Centrifugal`] or [`Full`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a motion of the balls",
    label = "not a motion",
    note = "a motion is `Static`, `Centrifugal<A>` or `Full<A>`, with an attitude rule `A`"
)]
pub trait Motion: 'static {
    /// The rule of their attitude.
    type Rule: Rule;
    /// The shaft turns.
    const AT_SPEED: bool = <Self::Rule as Rule>::INERTIA;
}

/// The bearing at rest: its solvers refuse any speed but [`Speed::REST`](crate::Speed::REST).
///
/// See [`AxialSolver`](crate::AxialSolver) for an example.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Static;

/// The bearing at speed under centrifugal force alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Centrifugal<A = crate::kinematics::RacewayControlFree>(PhantomData<A>);

/// The bearing at speed with all inertia loads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Full<A = crate::kinematics::RacewayControlFree>(PhantomData<A>);

impl Motion for Static {
    type Rule = AtRest;
}

impl<A: Rule> Motion for Centrifugal<A> {
    type Rule = Frictionless<A>;
}

impl<A: Rule> Motion for Full<A> {
    type Rule = A;
}
