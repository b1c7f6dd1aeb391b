//! The one module with `unsafe`: square roots that lower to the FPU's own instruction.
//!
//! `core` has no stable square root and `libm` computes it in software even where the target has
//! `vsqrt`. The C names are known to the compiler, which replaces a call by the instruction; on a
//! target without an FPU they resolve to the runtime's own routines. Both round correctly, so the
//! results are the same bits everywhere. The root is that of the magnitude: for numbers that may be negative
//! the compiler would keep the routine beside the instruction, half a kilobyte of flash. Hence, too, callers
//! take it ahead of a branch for positive numbers, within which the magnitude would be optimised away too early.

// SAFETY: the C standard defines both functions for every bit pattern, without side effects that
// Rust can see (errno is not read); every Rust target has them, from its C library or from
// `compiler_builtins`.
#[cfg(not(miri))]
unsafe extern "C" {
    safe fn sqrtf(x: f32) -> f32;
    safe fn sqrt(x: f64) -> f64;
}

// Miri cannot call them. It takes `-p spindle-bearing`: other packages switch on assembly in `libm`.
#[cfg(miri)]
use libm::{sqrt, sqrtf};

/// Square root of a single's magnitude, by the instruction of the core where it has one.
#[inline(always)]
pub fn sqrt_f32(x: f32) -> f32 {
    sqrtf(x.abs())
}

/// Square root of a double's magnitude.
#[inline(always)]
pub(crate) fn sqrt_f64(x: f64) -> f64 {
    sqrt(x.abs())
}
