//! Surface tension: the energy of the area of the free surface (Lamb 1932, article 267).
//!
//! ```text
//! E = sigma int ( sqrt(1 + |grad eta|^2) - 1 ) dA,       q_j = sigma int grad eta.grad psi_j / sqrt(1 + |grad eta|^2) dA
//! ```
//! with the heights of `columns`. The line where the surface meets the wall is free, at 90 degrees. Small
//! waves get `w^2 = (g k + sigma k^3/rho) tanh k h`. The quadrature is Gauss's in r and even in azimuth.

//! The sums of a particle end at the surface. Though their gradients are exact for what is linear, this makes short waves slow,
//! ```text
//! w^2 = g k tanh(k h) (1 - 0.06 (k l)^2),       l the smoothing length
//! ```
//! (second mode without viscosity: -7.9, -3.8 and -1.8 % in frequency at 7, 5 and 3.5 mm, so that one number serves all). It is the
//! dispersion of a negative tension `-0.06 rho g l^2`, 36 mN/m in glycerine at 5 mm, and a tension of that size gives it back: -0.6, -0.2
//! and 0.0 % are left. Its energy is in the books as that of an area. At rest, inclined or not, it does nothing.

use super::waves::{COUNT, Coefficients, Value, Waves};
use meniscus_numerics::quadrature::gauss_legendre;

/// Tension that the sums lack, in units of `rho g l^2`; measured in the glass of the recordings alone.
const LACKING: f64 = 0.06;

/// Returns the tension that sums of the smoothing length `length_m` lack in a liquid of `density` kg/m3 under `gravity` m/s2, N/m.
pub(super) fn lacking(density: f64, gravity: f64, length_m: f64) -> f64 {
    LACKING * density * gravity * length_m * length_m
}

/// Nodes along the radius and around.
const NODES: (usize, usize) = (10, 20);

/// The energy of the surface's area.
#[derive(Clone, Debug)]
pub(super) struct Tension {
    sigma: f64,
    /// Area of each node, and the waves there.
    nodes: Vec<(f64, [Value; COUNT])>,
}

impl Tension {
    /// A tension of `sigma` N/m in a circle of radius `radius_m`.
    pub(super) fn new(sigma: f64, radius_m: f64, waves: &Waves) -> Self {
        let mut nodes = Vec::with_capacity(NODES.0 * NODES.1);
        for (r, over_r) in gauss_legendre(NODES.0, radius_m) {
            for k in 0..NODES.1 {
                let turn = std::f64::consts::TAU / NODES.1 as f64;
                let (sin, cos) = (turn * k as f64).sin_cos();
                nodes.push((over_r * r * turn, waves.at(r * cos, r * sin)));
            }
        }
        Self { sigma, nodes }
    }

    /// The stored energy (J) at the heights `c`, and the generalised forces added to `q`.
    pub(super) fn pull(&self, c: &Coefficients, q: &mut Coefficients) -> f64 {
        let mut energy = 0.0;
        for (area, values) in &self.nodes {
            let slope = |axis: usize| values.iter().zip(c).map(|(v, c)| v[axis] * c).sum::<f64>();
            let (x, y) = (slope(1), slope(2));
            let stretch = (1.0 + x * x + y * y).sqrt();
            energy += area * (stretch - 1.0);
            let weight = self.sigma * area / stretch;
            for (q, v) in q.iter_mut().zip(values) {
                *q += weight * (x * v[1] + y * v[2]);
            }
        }
        self.sigma * energy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_has_its_area_and_forces_are_slopes_of_the_energy() {
        let (radius, sigma) = (0.035, 0.5);
        let waves = Waves::new(radius);
        let tension = Tension::new(sigma, radius, &waves);
        // For small heights 2 E = sigma k^2 int eta^2 dA. The first wave of one period is the third of all.
        let mut c = Coefficients::zeros();
        c[2] = 1e-5;
        let mut q = Coefficients::zeros();
        let energy = tension.pull(&c, &mut q);
        let k = 1.841_184 / radius;
        let truth = 0.5 * sigma * k * k * c[2] * c[2] / waves.inverse[2];
        assert!((energy / truth - 1.0).abs() < 1e-4, "{energy} J for {truth} J");
        (c[2], c[9]) = (0.3 * radius, 2e-3);
        q.fill(0.0);
        tension.pull(&c, &mut q);
        let shifted = |by: f64| {
            let mut moved = c;
            moved[6] += by;
            tension.pull(&moved, &mut Coefficients::zeros())
        };
        let slope = (shifted(1e-7) - shifted(-1e-7)) / 2e-7;
        assert!((q[6] - slope).abs() < 1e-7, "{} for {slope}", q[6]);
    }
}
