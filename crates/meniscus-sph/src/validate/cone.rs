//! The first mode without viscosity in a cone: Ritz's method over the liquid at rest.
//!
//! ```text
//! int grad phi.grad psi dV = (w^2/g) int_surface phi psi dA,        phi = F(r, z) cos(azimuth)
//! F = (r/R)^(1+2a) (z/h)^b in the height of the cross-section,     no flow through the wall is natural
//! ```
//! (Moiseev and Rumyantsev 1968, the variational form of sloshing.) The quadrature stretches Gauss's nodes to the wall.

use super::jet::{Jet, legendre};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::recording::Glass;
use meniscus_numerics::quadrature::gauss_legendre;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Powers of the radius and polynomials of the height.
const POWERS: (usize, usize) = (4, 8);

/// Nodes in each direction.
const NODES: usize = 20;

/// Frequency of the first mode of an inviscid liquid in `glass`, Hz; not a number where the method fails.
#[must_use]
pub fn cone_hz(glass: &Glass) -> f64 {
    let size = POWERS.0 * POWERS.1;
    let h = glass.fill_m;
    let (mut volume, mut surface) = (DMatrix::<f64>::zeros(size, size), DMatrix::<f64>::zeros(size, size));
    // Value, slope along r, slope along z of every function.
    let all = |r: f64, z: f64| -> Vec<[f64; 3]> {
        let scale = 1.0 / glass.radius_at(h);
        let along_z = legendre((Jet::variable(z) * (2.0 / h)) - Jet::constant(1.0), POWERS.1);
        let along_r = (0..POWERS.0).map(|a| {
            let power = 1.0 + 2.0 * a as f64;
            [(r * scale).powf(power), power * scale * (r * scale).powf(power - 1.0)]
        });
        let products = |[p, dp]: [f64; 2]| along_z.iter().map(move |Jet([q, dq, _])| [p * q, dp * q, p * dq]);
        along_r.flat_map(|p| products(p).collect::<Vec<_>>()).collect()
    };
    for (z, over_z) in gauss_legendre(NODES, h) {
        for (r, over_r) in gauss_legendre(NODES, glass.radius_at(z)) {
            let functions = all(r, z);
            for (i, a) in functions.iter().enumerate() {
                for (j, b) in functions.iter().enumerate() {
                    let sum = a[1] * b[1] + a[2] * b[2] + a[0] * b[0] / (r * r);
                    volume[(i, j)] += over_z * over_r * r * sum;
                }
            }
        }
    }
    for (r, over_r) in gauss_legendre(NODES, glass.radius_at(h)) {
        let functions = all(r, h);
        for (i, a) in functions.iter().enumerate() {
            for (j, b) in functions.iter().enumerate() {
                surface[(i, j)] += over_r * r * a[0] * b[0];
            }
        }
    }
    // The largest g/w^2 of L^-1 S L^-T with V = L L^T.
    let Some(factor) = volume.cholesky() else { return f64::NAN };
    let Some(half) = factor.l().solve_lower_triangular(&surface) else { return f64::NAN };
    let Some(whole) = factor.l().solve_lower_triangular(&half.transpose()) else { return f64::NAN };
    (GRAVITY_M_S2 / whole.symmetric_eigenvalues().max()).sqrt() / TAU
}

#[cfg(test)]
mod tests {
    use super::super::Mode;
    use super::*;

    #[test]
    fn a_cylinder_has_its_known_frequency_and_a_wider_surface_is_slower() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, taper: 0.0 };
        assert!((cone_hz(&glass) / Mode::first(glass).hz() - 1.0).abs() < 1e-5, "{}", cone_hz(&glass));
        let at = |taper: f64| {
            // The same radius at the surface: what is left is the shape of the wall below.
            cone_hz(&Glass { taper, radius_m: 0.035 - taper * 0.07, ..glass })
        };
        println!("{} {} {}", at(-0.1), at(0.0), at(0.1));
        assert!(at(0.1) < at(0.0) && at(0.0) < at(-0.1));
    }
}
