//! A function of one variable at a point with its first two derivatives, and the Legendre polynomials.

use std::ops::{Add, Mul, Sub};

/// Value, first and second derivative at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet(pub(super) [f64; 3]);

impl Jet {
    /// The variable itself at `x`.
    pub(super) fn variable(x: f64) -> Self {
        Self([x, 1.0, 0.0])
    }

    /// A constant.
    pub(super) fn constant(c: f64) -> Self {
        Self([c, 0.0, 0.0])
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, Self([d, e, f]): Self) -> Self {
        let Self([a, b, c]) = self;
        Self([a + d, b + e, c + f])
    }
}

impl Sub for Jet {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + other * -1.0
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, Self([d, e, f]): Self) -> Self {
        let Self([a, b, c]) = self;
        Self([a * d, a * e + b * d, a * f + 2.0 * b * e + c * d])
    }
}

impl Mul<f64> for Jet {
    type Output = Self;
    fn mul(self, by: f64) -> Self {
        Self(self.0.map(|part| by * part))
    }
}

/// The first `count` Legendre polynomials of `x`: `(n+1) P_(n+1) = (2n+1) x P_n - n P_(n-1)`.
pub(super) fn legendre(x: Jet, count: usize) -> Vec<Jet> {
    let mut all = vec![Jet::constant(1.0), x];
    while all.len() < count {
        let n = all.len() as f64 - 1.0;
        let [.., before, last] = all[..] else { unreachable!("two polynomials stand at the start") };
        all.push((x * last * (2.0 * n + 1.0) - before * n) * (1.0 / (n + 1.0)));
    }
    all.truncate(count);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_and_polynomials_have_their_derivatives() {
        let x = Jet::variable(0.3);
        let Jet([p, dp, ddp]) = legendre(x, 4)[3];
        assert!((p - 0.5 * (5.0 * 0.027 - 0.9)).abs() < 1e-15);
        assert!((dp - 0.5 * (15.0 * 0.09 - 3.0)).abs() < 1e-15 && (ddp - 15.0 * 0.3).abs() < 1e-14);
        assert_eq!(x - Jet::constant(0.3), Jet([0.0, 1.0, 0.0]));
    }
}
