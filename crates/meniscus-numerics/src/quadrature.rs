//! Gauss-Legendre quadrature.
//!
//! ```text
//! int_0^L f(x) dx = sum_i w_i f(x_i),      x_i = L (1 + z_i) / 2,      P_n(z_i) = 0
//! w_i = L / ((1 - z_i^2) P_n'(z_i)^2)                       (Abramowitz and Stegun 1964, 25.4.29)
//! (n+1) P_(n+1) = (2n+1) z P_n - n P_(n-1)                  (ibid., 22.7.10)
//! ```

use std::f64::consts::PI;

/// Newton iterations for a node. From the usual first guess four reach rounding.
const NEWTON_ITERATIONS: usize = 8;

/// Returns the nodes and weights of the Gauss-Legendre rule with `count` nodes on `[0, length]`, from the largest node to
/// the smallest. The rule is exact for polynomials up to the degree `2 count - 1`.
///
/// ```
/// use meniscus_numerics::quadrature::gauss_legendre;
///
/// // int_0^2 x^9 dx = 102.4 needs five nodes.
/// let integral: f64 = gauss_legendre(5, 2.0).iter().map(|(x, weight)| weight * x.powi(9)).sum();
/// assert!((integral - 102.4).abs() < 1e-11);
/// ```
#[must_use]
pub fn gauss_legendre(count: usize, length: f64) -> Vec<(f64, f64)> {
    let node = |i: usize| {
        // Tricomi's approximation is near enough to its root that Newton's method does not leave it.
        let mut z = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..NEWTON_ITERATIONS {
            let (value, derivative) = legendre(count, z);
            (z, slope) = (z - value / derivative, derivative);
        }
        let weight = 2.0 / ((1.0 - z * z) * slope * slope);
        (0.5 * length * (1.0 + z), 0.5 * length * weight)
    };
    (0..count).map(node).collect()
}

/// Returns `P_n(z)` and `P_n'(z)`.
fn legendre(n: usize, z: f64) -> (f64, f64) {
    let (mut before, mut last) = ((1.0, 0.0), (z, 1.0));
    if n == 0 {
        return before;
    }
    for k in 1..n {
        let k = k as f64;
        // The simulator's surface tension rests on the bits of the nodes: the order of these operations is kept.
        let factor = 1.0 / (k + 1.0);
        let value = (z * last.0 * (2.0 * k + 1.0) - before.0 * k) * factor;
        let slope = ((z * last.1 + last.0) * (2.0 * k + 1.0) - before.1 * k) * factor;
        (before, last) = (last, (value, slope));
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nodes on `[0, 2]` and weights for n = 5, by
    /// `python3 -c "from scipy.special import roots_legendre as r; x, w = r(5); print(1 + x, w)"`.
    const FIVE: [(f64, f64); 5] = [
        (1.906_179_845_938_664, 0.236_926_885_056_189_1),
        (1.538_469_310_105_683, 0.478_628_670_499_366_5),
        (1.0, 0.568_888_888_888_888_9),
        (0.461_530_689_894_316_9, 0.478_628_670_499_366_5),
        (0.093_820_154_061_336, 0.236_926_885_056_189_1),
    ];

    #[test]
    fn five_nodes_are_those_of_the_tables() {
        for ((x, weight), (x_due, weight_due)) in gauss_legendre(5, 2.0).into_iter().zip(FIVE) {
            assert!((x - x_due).abs() < 4e-16 && (weight - weight_due).abs() < 2e-15, "{x} {weight}");
        }
    }

    #[test]
    fn exact_up_to_the_degree_and_not_beyond() {
        let power = |count: usize, degree: i32| -> f64 {
            let integral: f64 = gauss_legendre(count, 1.0).iter().map(|(x, w)| w * x.powi(degree)).sum();
            integral * f64::from(degree + 1) - 1.0
        };
        for count in 1..20 {
            let highest = 2 * count as i32 - 1;
            assert!(power(count, highest).abs() < 1e-13, "{count} nodes: {}", power(count, highest));
        }
        assert!(power(4, 8).abs() > 1e-5);
    }

    #[test]
    fn no_nodes_integrate_to_nothing() {
        assert!(gauss_legendre(0, 1.0).is_empty());
        assert_eq!(gauss_legendre(1, 2.0), [(1.0, 2.0)]);
    }
}
