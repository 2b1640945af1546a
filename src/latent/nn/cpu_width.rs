//! Width of the vectors that the kernels are compiled for.
//!
//! The build is for any x86-64 (128 bit). A host that has found out that its processor has AVX2 says so once,
//! and the same Rust runs as compiled for 256 bit. Rows lie across the vector and each row is summed in its
//! own order, without fused multiply-adds, so every width gives the same bits.
#![allow(
    unsafe_code,
    reason = "a function compiled for a processor's feature may only be called where it is there; a prefetch takes a pointer"
)]

#[cfg(target_arch = "x86_64")]
use core::sync::atomic::{AtomicBool, Ordering};

/// Whether AVX2 may be used.
#[cfg(target_arch = "x86_64")]
static WIDE: AtomicBool = AtomicBool::new(false);

/// Lets the kernels run as compiled for AVX2, from now on and for all threads.
///
/// ```
/// #[cfg(target_arch = "x86_64")]
/// if std::arch::is_x86_feature_detected!("avx2") {
///     // SAFETY: detected in the line above.
///     unsafe { meniscus::latent::nn::allow_avx2() };
///     assert!(meniscus::latent::nn::is_wide());
/// }
/// ```
///
/// # Safety
/// The processor, and its operating system, must have AVX2.
#[cfg(target_arch = "x86_64")]
pub unsafe fn allow_avx2() {
    WIDE.store(true, Ordering::Relaxed);
}

/// Returns whether [`allow_avx2`] was called.
///
/// ```standalone_crate
/// // Narrow until the host calls `allow_avx2`.
/// assert!(!meniscus::latent::nn::is_wide());
/// ```
#[must_use]
pub fn is_wide() -> bool {
    #[cfg(target_arch = "x86_64")]
    return WIDE.load(Ordering::Relaxed);
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// A piece of work that gains from wide vectors. `run` has to be `#[inline(always)]`, or it is compiled once,
/// for the narrow ones. `WIDE` is whether it is compiled for AVX2.
pub trait Kernel {
    /// Runs the work, compiled for AVX2 if `WIDE`.
    fn run<const WIDE: bool>(self);
}

/// Runs `kernel` as compiled for the widest vectors that are allowed.
///
/// ```
/// use meniscus::latent::nn::{Kernel, widest};
///
/// struct Scale<'a>(&'a mut [f32]);
///
/// impl Kernel for Scale<'_> {
///     #[inline(always)]
///     fn run<const WIDE: bool>(self) {
///         self.0.iter_mut().for_each(|x| *x *= 2.0);
///     }
/// }
///
/// let mut numbers = [1.0, 2.0, 3.0];
/// widest(Scale(&mut numbers));
/// assert_eq!(numbers, [2.0, 4.0, 6.0]);
/// ```
#[inline]
pub fn widest(kernel: impl Kernel) {
    #[cfg(target_arch = "x86_64")]
    if is_wide() {
        // SAFETY: whoever set `WIDE` promised that AVX2 is there.
        return unsafe { with_avx2(kernel) };
    }
    kernel.run::<false>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2(kernel: impl Kernel) {
    kernel.run::<true>();
}

/// Has the memory that a kernel will read a little later fetched now. One that computes much on each line does not look as far
/// ahead as the memory is away (docs/bench).
#[inline(always)]
pub(super) fn ahead<T>(now: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        /// Bytes from what is being read to what is fetched.
        const DISTANCE: usize = 2048;
        let later = core::ptr::from_ref(now).cast::<i8>().wrapping_add(DISTANCE);
        // SAFETY: a prefetch changes nothing that a program can see and fails nowhere, whatever the address.
        unsafe { core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(later) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _alone = now;
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    extern crate std;

    use super::*;

    struct Sum<'a>(&'a [f32], &'a mut [f32]);

    impl Kernel for Sum<'_> {
        #[inline(always)]
        fn run<const WIDE: bool>(self) {
            self.1.iter_mut().zip(self.0).for_each(|(to, x)| *to = *to * 1.1 + *x * 0.3);
        }
    }

    #[test]
    fn both_widths_give_the_same_bits() {
        if !std::is_x86_feature_detected!("avx2") {
            return std::println!("skipped: this processor has no AVX2");
        }
        let x: [f32; 97] = core::array::from_fn(|k| (k as f32 * 0.37).rem_euclid(1.3) - 0.6);
        let (mut narrow, mut wide) = ([0.7; 97], [0.7; 97]);
        Sum(&x, &mut narrow).run::<false>();
        // SAFETY: asked for above.
        unsafe { with_avx2(Sum(&x, &mut wide)) };
        assert_eq!(narrow.map(f32::to_bits), wide.map(f32::to_bits));
    }
}
