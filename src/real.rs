//! Precision of a turn's arithmetic: double, or single for a processor whose floating-point unit has no more.
//!
//! Weights are `f32` and what is kept from turn to turn is `f64`, whatever the precision is. A stage is written once, over
//! [`Real`]: it takes its constants and its state in, computes, and hands the state back.

use crate::math;
use core::fmt::Debug;
use core::iter::Sum;
use nalgebra::{Field, SMatrix};

/// Precision in which an estimator computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 64 bits.
    #[default]
    Double,
    /// 32 bits.
    Single,
}

/// Number in which a stage of a turn computes: `f64` or `f32`.
///
/// ```
/// use meniscus::real::Real;
///
/// fn hypotenuse<R: Real>(a: R, b: R) -> f64 {
///     (a * a + b * b).root().wide()
/// }
/// assert_eq!(hypotenuse(3.0_f64, 4.0), hypotenuse(3.0_f32, 4.0));
/// ```
pub trait Real:
    Field + Copy + Debug + Default + PartialOrd + Sum<Self> + for<'a> Sum<&'a Self> + From<f32> + 'static
{
    /// Smallest positive normal number.
    const LEAST: Self;
    /// Squared relative residual at which the implicit step counts as solved: what rounding leaves in it, with a margin.
    const SOLVED: f64;
    /// Relative rise of the energy in a step that is rounding, and is taken off again.
    const NUDGE: f64;

    /// Rounds a number in double precision.
    fn of(x: f64) -> Self;
    /// Returns the number in double precision.
    fn wide(self) -> f64;
    /// Returns the square root.
    fn root(self) -> Self;
    /// Returns the larger of two numbers, the one that is a number where the other is not.
    fn larger(self, other: Self) -> Self;
    /// Returns the smaller of two numbers, the one that is a number where the other is not.
    fn smaller(self, other: Self) -> Self;
    /// Returns the size of the number.
    fn size(self) -> Self;
    /// Whether it is finite.
    fn is_real(self) -> bool;
    /// Lends `matrix` to `work` in this precision, and keeps what that leaves in it.
    fn lend<const N: usize, T>(
        matrix: &mut SMatrix<f64, N, N>,
        work: impl FnOnce(&mut SMatrix<Self, N, N>) -> T,
    ) -> T;
}

/// Operations whose names both types share.
macro_rules! comparisons {
    () => {
        fn larger(self, other: Self) -> Self {
            self.max(other)
        }

        fn smaller(self, other: Self) -> Self {
            self.min(other)
        }

        fn size(self) -> Self {
            self.abs()
        }

        fn is_real(self) -> bool {
            self.is_finite()
        }
    };
}

impl Real for f64 {
    const LEAST: Self = Self::MIN_POSITIVE;
    const SOLVED: f64 = 1e-26;
    const NUDGE: f64 = 1e-9;

    fn of(x: f64) -> Self {
        x
    }

    fn wide(self) -> f64 {
        self
    }

    fn root(self) -> Self {
        math::sqrt(self)
    }

    comparisons!();

    fn lend<const N: usize, T>(
        matrix: &mut SMatrix<f64, N, N>,
        work: impl FnOnce(&mut SMatrix<Self, N, N>) -> T,
    ) -> T {
        work(matrix)
    }
}

impl Real for f32 {
    const LEAST: Self = Self::MIN_POSITIVE;
    const SOLVED: f64 = 1e-10;
    const NUDGE: f64 = 1e-4;

    fn of(x: f64) -> Self {
        x as Self
    }

    fn wide(self) -> f64 {
        f64::from(self)
    }

    fn root(self) -> Self {
        math::sqrtf(self)
    }

    comparisons!();

    fn lend<const N: usize, T>(
        matrix: &mut SMatrix<f64, N, N>,
        work: impl FnOnce(&mut SMatrix<Self, N, N>) -> T,
    ) -> T {
        let mut single = narrow(matrix);
        let result = work(&mut single);
        *matrix = single.map(f64::from);
        result
    }
}

/// Returns `matrix` in the precision of a stage.
///
/// ```
/// let tenth = nalgebra::Matrix2::repeat(0.1);
/// assert_eq!(meniscus::real::narrow::<f64, 2, 2>(&tenth), tenth);
/// assert_eq!(meniscus::real::narrow::<f32, 2, 2>(&tenth)[0], 0.1_f32);
/// ```
#[must_use]
pub fn narrow<R: Real, const M: usize, const N: usize>(matrix: &SMatrix<f64, M, N>) -> SMatrix<R, M, N> {
    matrix.map(R::of)
}

/// Returns `matrix` in double precision.
///
/// ```
/// let tenth = nalgebra::Vector2::repeat(0.1_f32);
/// assert_eq!(meniscus::real::widen(&tenth)[1], f64::from(0.1_f32));
/// ```
#[must_use]
pub fn widen<R: Real, const M: usize, const N: usize>(matrix: &SMatrix<R, M, N>) -> SMatrix<f64, M, N> {
    matrix.map(R::wide)
}
