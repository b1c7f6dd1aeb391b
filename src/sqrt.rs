//! The one module with `unsafe`: square roots that lower to the FPU's own instruction.
//!
//! `core` has no stable square root and `libm` computes it in software even where the target has
//! `vsqrt`. The C names are known to the compiler, which replaces a call by the instruction; on a
//! target without an FPU they resolve to the runtime's own routines. Both round correctly, so the
//! results are the same bits everywhere. On microcontrollers whose ABI passes singles in the FPU's
//! registers the instruction is written out: for negative numbers the compiler would keep the routine,
//! half a kilobyte of flash.

// SAFETY: the C standard defines both functions for every bit pattern, without side effects that
// Rust can see (errno is not read); every Rust target has them, from its C library or from
// `compiler_builtins`.
unsafe extern "C" {
    #[cfg(not(all(target_arch = "arm", target_os = "none", target_abi = "eabihf")))]
    safe fn sqrtf(x: f32) -> f32;
    safe fn sqrt(x: f64) -> f64;
}

/// Square root of a single.
#[cfg(not(all(target_arch = "arm", target_os = "none", target_abi = "eabihf")))]
#[inline(always)]
pub(crate) fn sqrt_f32(x: f32) -> f32 {
    sqrtf(x)
}

/// Square root of a single.
#[cfg(all(target_arch = "arm", target_os = "none", target_abi = "eabihf"))]
#[inline(always)]
pub(crate) fn sqrt_f32(x: f32) -> f32 {
    let root: u32;
    // SAFETY: touches these registers only, and is defined for every bit pattern. The FPU's register is
    // a clobber because stable Rust does not know the operand class on cores with a small FPU.
    unsafe {
        core::arch::asm!(
            "vmov s0, {x}",
            "vsqrt.f32 s0, s0",
            "vmov {root}, s0",
            x = in(reg) x.to_bits(),
            root = lateout(reg) root,
            out("s0") _,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    f32::from_bits(root)
}

/// Square root of a double.
#[inline(always)]
pub(crate) fn sqrt_f64(x: f64) -> f64 {
    sqrt(x)
}
