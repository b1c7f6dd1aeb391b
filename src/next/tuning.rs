//! Every number of the solver that was chosen by trial.
//!
//! Trials: 300 to 2,000 cases of each family of the campaign, seed 1, in both precisions, and the 200 mixed cases of the
//! report on the modelled Cortex-M4F.

/// Unbalanced force of a ball over its larger contact force, above which its linearisation is repeated after its own
/// Newton step. Three times as much: 2 in 400 moderate cases are not solved, in place of 1.
pub const PLACE: f64 = 0.1;
/// The same, above which the ball is placed at once.
pub const RETRY: f64 = 1.0;
/// The same, at which placing ends. With 0.1, a ball may be placed at the same point again and again.
pub const PLACED: f64 = 0.03;
/// Longest step of the ring at first, over `L0`.
pub const FIRST_RADIUS: f64 = 0.1;
/// Longest step of the ring at all, over `L0`.
pub const LARGEST_RADIUS: f64 = 0.5;
/// A step is taken back in part where the unbalanced force along it turns round and grows by more than this. A 3/2 law
/// seen from far above or below makes factors of 10 that the next step mends; a third of it costs solved radial cases.
pub const REJECT: f64 = 100.0;
/// Least damping over the largest diagonal element of the tangent. A hundred times as much: steps along a weak direction
/// creep, and one radial case in 30 is missed.
pub const DAMPING: f64 = 1e-5;
/// Growth of the damping until the step is short enough. With 10: up to 3 iterations more at 99 %.
pub const DAMPING_GROWTH: f64 = 3.0;
/// Least pivot of the tangent, over its diagonal and the precision, that counts as positive.
pub const SINGULAR: f64 = 8.0;
/// Inertia over load below which a solve starts from rest.
pub const LIGHT: f64 = 0.05;
/// Inertia over load above which a solve starts from balls that the outer race holds.
pub const HEAVY: f64 = 500.0;
/// Change of the stiffness at which a start ends, which a solve from there refines.
pub const ROUGH: f64 = 0.1;
/// Offset from the reference position, in units of length, beyond which the reference moves: rounding of the offset is
/// then that of a deformation of about this size.
pub const ANCHOR: f64 = 4.0;
/// Part of the change of the stiffness along a step that its correction misses, since that leaves out what friction
/// changes: 0.3 % at 5,000 rpm, 2 % at 20,000 rpm (B7005C), and more under light loads.
pub const CORRECTED: f64 = 0.1;
/// What a converged step may leave of the balls' forces, over the tolerance of the stiffness: forces are good to 1e-6
/// where the stiffness is to 2e-5.
pub const FORCE: f64 = 0.05;
/// Margin of the error estimate on what the last step leaves.
pub const MARGIN: f64 = 5.0;
/// Tolerance below which a prediction takes in the second order of the balls' motion, which costs 3,000 cycles.
pub const CURVED: f64 = 5e-4;
/// Most iterations from a solution nearby.
pub const WARM: u16 = 8;
/// Most iterations from one start.
pub const ATTEMPT: u16 = 25;
