//! Tells the core how wide the vectors of this processor are.
#![allow(
    unsafe_code,
    reason = "the promise that AVX2 is there can only be given here; the argument stands at the call"
)]

use meniscus::latent::nn;

/// Lets the kernels use AVX2 where processor and system have it; call it once, at the start. Results are the same
/// to the bit with and without. `MENISCUS_NARROW` in the environment leaves them as any x86-64 runs them.
pub fn widen() {
    #[cfg(target_arch = "x86_64")]
    if std::env::var_os("MENISCUS_NARROW").is_none() && std::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor was asked on the line above, and so was the system, as `std` does.
        unsafe { nn::allow_avx2() };
    }
}

/// Returns the instruction set of the kernels, in words.
#[must_use]
pub fn words() -> &'static str {
    match (nn::is_wide(), cfg!(target_arch = "x86_64")) {
        (true, _) => "AVX2, found at the start",
        (false, true) => "SSE2, as any x86-64",
        (false, false) => "the build's own",
    }
}
