//! What decides how a start goes on. Steps of the ring are in units of `L0`, residuals relative to the load;
//! numbers with two digits are those of their neighbourhood with which the campaign's cases went best.

/// Longest step of the ring.
pub const LONGEST_STEP: f64 = 0.5;
/// Longest step over which linearisations hold: after a longer one there is another sweep, and with laws there is
/// none.
pub const SHORT_STEP: f64 = 0.03;
/// Step that rounding may have made, at most, in roundings of `L0`.
pub const ROUNDED_STEP: f64 = 100.0;
/// Residual beyond which the next sweep takes laws; and that of a sweep without them beyond which it is
/// repeated with them.
pub const NEEDS_LAWS: f64 = 0.06;
pub const MISSES_LAWS: f64 = 0.12;
/// Imbalance of a ball beyond which its law and its linearisation do not agree, and rounding alone does
/// not end a solve.
pub const AT_ODDS: f64 = 0.035;
/// Residual over the last one: below it steps may grow, and above it a sweep led nowhere.
pub const WENT_WELL: f64 = 0.4;
pub const LED_NOWHERE: f64 = 0.55;
/// Residual over the last one, at most, and residual in tolerances, at least, of a sweep that another is
/// sure to follow.
pub const GOES_ON: (f64, f64) = (0.3, 100.0);
/// Change of the stiffness over the last one above which a sweep made no progress.
pub const NO_PROGRESS: f64 = 0.25;
/// What rounding may have left unknown of the stiffness where the balance alone ends a solve; and how many times
/// as much every further sweep may that begins and ends there.
pub const UNKNOWN: f64 = 0.04;
pub const UNKNOWN_GROWS: f64 = 1.05;
/// Residual, over what rounding makes steps of, below which the last step is all rounding.
pub const ALL_ROUNDING: f64 = 1.0 / 16.0;
/// Residual of an answer, at most.
pub const BALANCED: f64 = 1e-3;
/// Part of the load that the laws' balance may leave of it, and the steps it takes for that, at most.
pub const LAWS_LEAVE: f64 = 0.03;
pub const LAWS_STEPS: u8 = 12;
/// Unbalanced load, of all of it, so small that laws are linear over the step.
pub const LINEAR: f64 = 1e-3;
/// Offset from a reference, or step of a ball, that would cost digits of the deformations.
pub const FAR_FROM_REFERENCE: f64 = 2e-3;
/// Steps of its own, at most, in which a ball follows the ring; and in which one that they have lost comes back.
pub const OWN_STEPS: u16 = 9;
pub const STEPS_ANEW: u16 = 10;
/// Sweeps in a row that a ball may be lost in, for all its own steps, before the start is.
pub const LOST: u8 = 3;
/// Centrifugal forces of all balls, over the load, below which a bearing from nothing is first put where it is at
/// a standstill; and below which that is tried where the first start led nowhere.
pub const LIGHT: f64 = 1e-3;
pub const HEAVY: f64 = 1.0;
/// Tolerance of that.
pub const STANDSTILL: f64 = 0.1;
/// Force of the ball that faces a load that is nearly radial, in mean loads of a ball: that of Stribeck (1901) for a
/// bearing with clearance.
pub const STRIBECK: f64 = 5.0;

/// Those of a search at rest.
pub mod at_rest {
    /// Longest step of the ring.
    pub const LONGEST_STEP: f64 = 0.3;
    /// Part of the load's balance at the beginning of a sweep that ends it, and its passes over the balls, at
    /// most.
    pub const LEFT: f64 = 0.02;
    pub const PASSES: u8 = 16;
    /// Sweeps in which deformations may lead.
    pub const LEADING: u16 = 8;
    /// Part of a deformation by which geometry differs from it, at most, to lead.
    pub const AGREES: f64 = 0.067;
    /// Part of the load that a contact may carry at once that a step closes.
    pub const CLOSES: f64 = 0.1;
    /// That contact's deformation over the ring's offset from its reference, from which on this serves as long
    /// as steps are long.
    pub const SERVES: f64 = 0.03;
    /// Force of each ball from which a step along the grooves counts little.
    pub const HEAVY: f64 = 0.01;
    /// Part of a heavier load that may be left unbalanced when it is lightened, and what is left of it then.
    pub const LIGHTENS_AT: f64 = 0.3;
    pub const LIGHTENED: f64 = 0.2;
    /// How many times larger the force along a step may be behind it, the other way round; and how often
    /// a step is halved for it.
    pub const TURNED: f64 = 20.0;
    pub const HALVED: u8 = 4;
    /// Residual over the last one below which a pass made progress, and residual in roundings below which
    /// that says nothing.
    pub const FALLS: f64 = 0.3;
    pub const NOISE: f64 = 8.0;
    /// Part of the load that a ball must carry to hold the ring.
    pub const NOTHING: f64 = 1e-12;
    /// Roundings of the balance that light contacts may hide.
    pub const HIDDEN: f64 = 128.0;
}
