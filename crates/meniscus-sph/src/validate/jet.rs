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

/// Nodes and weights of Gauss and Legendre on `[0, length]`, exact to the degree `2 count - 1`.
pub(crate) fn gauss(count: usize, length: f64) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Newton from the usual first guess converges in four turns.
        for _ in 0..8 {
            let Jet([p, dp, _]) = legendre(Jet::variable(x), count + 1)[count];
            (x, slope) = (x - p / dp, dp);
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        (0.5 * length * (1.0 + x), 0.5 * length * weight)
    };
    (0..count).map(node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_differentiate_and_quadrature_is_exact() {
        let x = Jet::variable(0.3);
        let Jet([p, dp, ddp]) = legendre(x, 4)[3];
        assert!((p - 0.5 * (5.0 * 0.027 - 0.9)).abs() < 1e-15);
        assert!((dp - 0.5 * (15.0 * 0.09 - 3.0)).abs() < 1e-15 && (ddp - 15.0 * 0.3).abs() < 1e-14);
        assert_eq!(x - Jet::constant(0.3), Jet([0.0, 1.0, 0.0]));
        let ninth: f64 = gauss(5, 2.0).iter().map(|(x, w)| w * x.powi(9)).sum();
        assert!((ninth - 102.4).abs() < 1e-11, "{ninth}");
    }
}
