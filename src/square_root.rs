//! Square root by the processor's own instruction, where the build is for an ARM with a floating-point unit.
//!
//! IEEE 754 states the square root to the last bit, so that the instruction gives what `libm` computes in forty times the
//! instructions. Stable Rust has no name for it in `core`.
#![allow(unsafe_code, reason = "an instruction in assembly; the argument stands at it")]

/// Square root.
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
#[inline(always)]
pub(crate) fn sqrtf(x: f32) -> f32 {
    let mut bits = x.to_bits();
    // SAFETY: the hard-float interface states that the registers of the unit are there, and every unit with them has VSQRT in
    // single precision. It takes a number from a general register and gives one back by s0, which is named as overwritten, and
    // touches neither memory nor flags.
    unsafe {
        core::arch::asm!(
            "vmov s0, {bits}",
            "vsqrt.f32 s0, s0",
            "vmov {bits}, s0",
            bits = inout(reg) bits,
            out("s0") _,
            options(pure, nomem, nostack, preserves_flags)
        );
    }
    f32::from_bits(bits)
}

/// Square root.
#[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
#[inline(always)]
pub(crate) fn sqrtf(x: f32) -> f32 {
    libm::sqrtf(x)
}
