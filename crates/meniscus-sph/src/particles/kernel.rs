//! The smoothing kernel: Wendland C2 in three dimensions.
//!
//! ```text
//! W(r) = 21 / (16 pi h^3) (1 - q/2)^4 (2 q + 1),   q = r/h <= 2
//! F(r) = W'(r) / r = -105 / (16 pi h^5) (1 - q/2)^3,   so that grad W = F x
//! ```
//! (Wendland 1995; Dehnen and Aly 2012 for its freedom from pairing.) `F` needs no division by `r`.

use super::lanes::Lane;

/// Smoothing length in units of the particle spacing; 1.4 gives about 92 neighbours.
pub(crate) const SMOOTHING: f64 = 1.4;

/// The kernel for one smoothing length.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kernel<T = f64> {
    /// Smoothing length h, metres.
    pub(crate) h: T,
    /// Square of the support radius 2 h.
    pub(crate) support2: T,
    half_inverse: T,
    value: T,
    slope: T,
}

impl Kernel {
    /// The kernel of smoothing length `h` metres.
    pub(crate) fn new(h: f64) -> Self {
        let pi = std::f64::consts::PI;
        Self {
            h,
            support2: 4.0 * h * h,
            half_inverse: 0.5 / h,
            value: 21.0 / (16.0 * pi * h.powi(3)),
            slope: -105.0 / (16.0 * pi * h.powi(5)),
        }
    }

    /// Returns the kernel in single precision.
    pub(crate) fn single(&self) -> Kernel<f32> {
        Kernel {
            h: f32::of(self.h),
            support2: f32::of(self.support2),
            half_inverse: f32::of(self.half_inverse),
            value: f32::of(self.value),
            slope: f32::of(self.slope),
        }
    }
}

impl<T: Lane> Kernel<T> {
    /// `W`, 1/m3, from the squared distance; zero outside the support.
    #[inline(always)]
    pub(crate) fn value(&self, r2: T) -> T {
        let half_q = r2.root() * self.half_inverse;
        let s = (T::of(1.0) - half_q).positive();
        self.value * (s * s) * (s * s) * (T::of(4.0) * half_q + T::of(1.0))
    }

    /// `F`, 1/m5, from the squared distance; zero outside the support.
    #[inline(always)]
    pub(crate) fn slope(&self, r2: T) -> T {
        let s = (T::of(1.0) - r2.root() * self.half_inverse).positive();
        self.slope * (s * s * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integrates_to_one_and_its_slope_is_its_derivative() {
        let kernel = Kernel::new(0.007);
        let step = 1e-5;
        let mut sum = 0.0;
        for i in 0..1500 {
            let r: f64 = (i as f64 + 0.5) * step;
            sum += 4.0 * std::f64::consts::PI * r * r * kernel.value(r * r) * step;
            let (low, high) = (kernel.value((r - 1e-8).powi(2)), kernel.value((r + 1e-8).powi(2)));
            let derivative = (high - low) / 2e-8;
            assert!((derivative - kernel.slope(r * r) * r).abs() < 1e-4 * kernel.value(0.0) / kernel.h);
        }
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}
