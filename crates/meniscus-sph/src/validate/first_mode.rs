//! The first mode without viscosity in any glass of revolution: Ritz's method over the liquid at rest.
//!
//! ```text
//! int grad phi.grad psi dV = (w^2/g) int_surface phi psi dA,        phi = F(r, z) cos(azimuth)
//! F = (r/R)^(1+2a) P_b(2 z/h - 1)                    no flow through the wall is natural
//! ```
//! with `R` the radius of the surface and `P_b` Legendre's polynomials (Moiseev and Rumyantsev 1968, the variational form of
//! sloshing). The quadrature stretches Gauss's nodes to the wall. It shares no code with the particles.

use super::jet::{Jet, legendre};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::glass::Glass;
use meniscus_numerics::quadrature::gauss_legendre;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Powers of the radius and polynomials of the height.
const POWERS: (usize, usize) = (4, 8);

/// Nodes in each direction.
const NODES: usize = 24;

/// The first mode of an inviscid liquid in a glass of revolution.
#[derive(Clone, Debug)]
pub struct FirstMode {
    hz: f64,
    basis: Basis,
    /// Contribution of each function; the largest speed of the mode at the edge of the surface is 1.
    share: DVector<f64>,
}

/// The functions of which the potential is made.
#[derive(Clone, Debug)]
struct Basis {
    radius_m: f64,
    depth_m: f64,
}

impl Basis {
    /// Value, slope along r and slope along z of every function, all without the cosine of the azimuth.
    fn at(&self, r: f64, z: f64) -> Vec<[f64; 3]> {
        let along_z = legendre((Jet::variable(z) * (2.0 / self.depth_m)) - Jet::constant(1.0), POWERS.1);
        let (mut all, ratio) = (Vec::with_capacity(POWERS.0 * POWERS.1), r / self.radius_m);
        for a in 0..POWERS.0 {
            let power = 1 + 2 * a as i32;
            let [p, dp] = [ratio.powi(power), f64::from(power) / self.radius_m * ratio.powi(power - 1)];
            all.extend(along_z.iter().map(|Jet([q, dq, _])| [p * q, dp * q, p * dq]));
        }
        all
    }
}

impl FirstMode {
    /// The mode of `glass`; `None` where the functions do not determine it.
    #[must_use]
    pub fn new(glass: &Glass) -> Option<Self> {
        let (size, h) = (POWERS.0 * POWERS.1, glass.fill_m);
        let basis = Basis { radius_m: glass.radius_at(h), depth_m: h };
        let (mut volume, mut surface) =
            (DMatrix::<f64>::zeros(size, size), DMatrix::<f64>::zeros(size, size));
        let add = |matrix: &mut DMatrix<f64>,
                   weight: f64,
                   product: &dyn Fn(&[f64; 3], &[f64; 3]) -> f64,
                   all: &[[f64; 3]]| {
            for (i, a) in all.iter().enumerate() {
                for (j, b) in all.iter().enumerate() {
                    matrix[(i, j)] += weight * product(a, b);
                }
            }
        };
        for (z, over_z) in gauss_legendre(NODES, h) {
            for (r, over_r) in gauss_legendre(NODES, glass.radius_at(z)) {
                let product = |a: &[f64; 3], b: &[f64; 3]| a[1] * b[1] + a[2] * b[2] + a[0] * b[0] / (r * r);
                add(&mut volume, over_z * over_r * r, &product, &basis.at(r, z));
            }
        }
        for (r, over_r) in gauss_legendre(NODES, basis.radius_m) {
            add(&mut surface, over_r * r, &|a, b| a[0] * b[0], &basis.at(r, h));
        }
        // The largest g/w^2 of L^-1 S L^-T with V = L L^T.
        let factor = volume.cholesky()?.l();
        let half = factor.solve_lower_triangular(&surface)?;
        let whole = factor.solve_lower_triangular(&half.transpose())?;
        let all = whole.symmetric_eigen();
        let (first, value) = all.eigenvalues.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        let share =
            factor.transpose().solve_upper_triangular(&all.eigenvectors.column(first).into_owned())?;
        let mut mode = Self { hz: (GRAVITY_M_S2 / value).sqrt() / TAU, basis, share };
        let [_, _, top] = mode.velocity([mode.basis.radius_m, 0.0, h]);
        mode.share /= top;
        Some(mode)
    }

    /// Frequency, Hz.
    #[must_use]
    pub fn hz(&self) -> f64 {
        self.hz
    }

    /// Velocity of the mode at `x`: the gradient of its potential, whose part upwards is 1 at the edge of the surface at rest.
    #[must_use]
    pub fn velocity(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let r = x.hypot(y).max(1e-9);
        let [mut value, mut out, mut up] = [0.0; 3];
        for ([f, along_r, along_z], share) in self.basis.at(r, z).iter().zip(self.share.iter()) {
            value += share * f;
            out += share * along_r;
            up += share * along_z;
        }
        // phi = F cos: out of the axis F' cos, around it -F/r sin.
        let [cos, sin] = [x / r, y / r];
        [out * cos * cos + value / r * sin * sin, (out - value / r) * cos * sin, up * cos]
    }
}

#[cfg(test)]
mod tests {
    use super::super::Mode;
    use super::*;
    use meniscus_data::glass::{Profile, WallShape};

    const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };

    fn hz(glass: &Glass) -> f64 {
        FirstMode::new(glass).expect("a mode").hz()
    }

    #[test]
    fn a_cylinder_has_its_known_mode_and_a_wider_surface_is_slower() {
        let (found, known) = (FirstMode::new(&GLASS).expect("a mode"), Mode::first(GLASS));
        assert!((found.hz() / known.hz() - 1.0).abs() < 1e-5, "{}", found.hz());
        for x in [[0.02, 0.01, 0.06], [-0.01, 0.03, 0.03], [0.0, 0.0, 0.07]] {
            for (a, b) in found.velocity(x).iter().zip(known.velocity(x)) {
                assert!((a - b).abs() < 2e-3, "{x:?}: {a} for {b}");
            }
        }
        let at = |taper: f64| {
            // The same radius at the surface: what is left is the shape of the wall below.
            hz(&Glass { wall: WallShape::Straight { taper }, radius_m: 0.035 - taper * 0.07, ..GLASS })
        };
        println!("{} {} {}", at(-0.1), at(0.0), at(0.1));
        assert!(at(0.1) < at(0.0) && at(0.0) < at(-0.1));
    }

    /// The eigenvalue `w^2 R/g` of a sphere filled to its middle is 1.5602 (McIver 1989, J. Fluid Mech. 201, 243).
    #[test]
    fn a_half_full_sphere_has_its_published_eigenvalue() {
        let radius = 0.04;
        let point = |k: usize| {
            let z = radius * k as f64 / 16.0;
            [z, (2.0 * radius * z - z * z).sqrt()]
        };
        let profile = Profile::new(&(0..=20).map(point).collect::<Vec<_>>()).expect("a sphere");
        let found = hz(&Glass::curved(profile, radius, 1.2 * radius));
        let eigenvalue = (TAU * found).powi(2) * radius / GRAVITY_M_S2;
        println!("half-full sphere: {eigenvalue}");
        assert!((eigenvalue / 1.5602 - 1.0).abs() < 2e-4, "{eigenvalue}");
    }

    /// No flow through the wall, which no function meets by itself.
    #[test]
    fn the_mode_of_a_bowl_follows_its_wall() {
        let points = [
            [0.0, 0.0],
            [0.005, 0.018],
            [0.015, 0.029],
            [0.03, 0.036],
            [0.05, 0.038],
            [0.08, 0.034],
            [0.1, 0.03],
        ];
        let glass = Glass::curved(Profile::new(&points).expect("a wine glass"), 0.06, 0.1);
        let mode = FirstMode::new(&glass).expect("a mode");
        for z in [0.01, 0.02, 0.035, 0.05] {
            let x = [glass.radius_at(z), 0.0, z];
            let v = mode.velocity(x);
            let into: f64 = glass.side(&x).normal.iter().zip(v).map(|(n, v)| n * v).sum();
            assert!(into.abs() < 0.02, "{into} of 1 flows into the wall at the height {z}");
        }
    }
}
