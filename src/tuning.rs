//! Every number of the solver that was chosen by trial.
//!
//! Trial: `cargo campaign --cases 14000`, and `cargo reports` for cycles. The effect of doubling a number is given in
//! solves of 400 cases of each family that are missed (+) or found (-), both precisions.

/// Unbalanced force of a ball over its larger contact force, above which its linearisation is repeated.
/// Tuned: doubled, random +3, zero-loads +9, moderate +2.
pub const SETTLE: f64 = 0.1;
/// Unbalanced force of a ball over its larger contact force, at which settling ends. Where it is not well below [`SETTLE`], a ball
/// may be settled again and again.
/// Tuned: doubled, zero-loads +5, warm jumps +3.
pub const SETTLED: f64 = 0.03;
/// Steps of settling in one pass, over half the number of balls: a ball without a step left goes on in the next pass.
/// Tuned: doubled, no effect, and a pass of six medians in place of four; at 3, random -2, radial and zero-loads -1 %.
pub const SETTLING: u16 = 8;
/// Longest step of the ring at first, over `L0`.
/// Tuned: doubled, random +6, moderate +3; halved, half an iteration more.
pub const FIRST_RADIUS: f64 = 0.1;
/// A step is taken back in part where the unbalanced force along it turns round and grows by more than this: a 3/2 law
/// seen from far above or below makes factors of 10 that the next step mends.
/// Tuned: doubled, no effect; a tenth, random +4 and zero-loads +6.
pub const REJECT: f64 = 100.0;
/// Least damping over the largest diagonal element of the tangent, at first.
/// Tuned: doubled, random +5, zero-loads +5, radial -5.
pub const DAMPING: f64 = 1e-5;
/// Growth of the damping until the step is short enough.
/// Tuned: doubled, random +6, zero-loads +9; more cycles if smaller.
pub const DAMPING_GROWTH: f64 = 3.0;
/// Unbalanced part of the load, and change of the stiffness, below which a solve is near its end.
/// Tuned: doubled, random +2, warm jumps -3.
pub const COARSE: f64 = 0.1;
/// Part of the change of the stiffness along a step that its correction misses, since that leaves out what friction
/// changes: 0.3 % at 5,000 rpm, 2 % at 20,000 rpm (B7005C), and more under light loads.
/// Tuned: doubled, the stated error of an unfinished tick is 31 times the true one in place of 21, and an iteration more in
/// every second warm solve by default; halved, not tried.
pub const CORRECTED: f64 = 0.1;
/// Unbalanced part of the load, over the tolerance, from which on a step is known to change the stiffness by more than that:
/// no need to work it out, which costs 5,000 cycles on a pair.
/// Tuned: at 30, rounding that ends a solve is taken for its end too early; at 200, up to 1,300 cycles an iteration.
pub const FAR: f64 = 100.0;
/// Unbalanced part of the load with the meaning of [`FAR`], above a tolerance of 1.5e-4, where no rounding ends a solve.
/// Tuned: trebled, as many iterations, each of 1,300 cycles more.
pub const FAR_AT_MOST: f64 = 0.015;
/// Error of the balls' forces after a converged step, over the tolerance of the stiffness: forces are good to 1e-6
/// where the stiffness is to 2e-5. Follows from what is promised.
pub const FORCE: f64 = 0.05;
/// Margin of the error estimate on what the last step leaves.
/// Tuned: halved, 0.3 % of the stiffnesses of moderate loads are not covered.
pub const MARGIN: f64 = 5.0;
/// Most iterations of an attempt; twice as many while the balance is within [`COARSE`], for balls that touch without force.
/// Tuned: doubled, random -23, few-balls -47, radial -6; at 30, random +44, few-balls +61, radial +21.
pub const ATTEMPT: u16 = 50;
