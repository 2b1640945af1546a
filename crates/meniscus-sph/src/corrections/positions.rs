//! Density by the positions of the particles, and the relaxation of the flow's density towards it.
//!
//! Gradients that are exact at a free surface ([`super::corrected`]) leave nothing that ties the density to where the
//! particles are: particles too close below the surface are too heavy and sink, and a low-viscosity liquid moves
//! from rest (0.1 Pa s to 72 mm/s in 0.65 s). So the density relaxes towards that of the positions:
//! ```text
//! rho_i' = ... + (q_i - rho_i)/TAU         q_i = c(mu_i) s_i f(mu_i/h)         mu_i = |m_i|/s_i
//! ```
//! with the sums `s`, `m` of [`super::moments`]. At the depth `d` below a flat surface of a half-space of density rho they are
//! `s = rho C(d)` and `|m| = rho Q(d)`, with `w(z)` the kernel summed over a plane at the distance `z` from its middle:
//! ```text
//! C(d) = 1 - int_d^2h w dz       Q(d) = int_d^2h z w dz       so that       f(Q/C) = 1/C
//! u = 1 - d/2h:   w = 21/2h (u^5 - 3/2 u^6 + 4/7 u^7),   C = 1 - 21 (u^6/6 - 3/14 u^7 + u^8/14),
//!                 Q = 42h (u^6/6 - 5/14 u^7 + 29/112 u^8 - 4/63 u^9)
//! ```
//! for the kernel of [`Kernel`](crate::particles::Kernel): two sums of the positions tell the depth and the density, with neither a surface that
//! would have to be found nor a neighbour that lacks. What particles in layers differ from a continuum, up to 4 %, is in
//! `c`, a parabola fitted to the liquid that settles; it calls nothing from where it rests.

use super::moments::Seen;
use crate::particles::{Fluid, retain};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// Time in which the density follows, s: a third of the first mode of the glass of the recordings. 0.2 and 0.05 give the
/// same frequencies and damping; 0.02 keeps more noise, and without any of it a low-viscosity liquid moves from rest.
const TAU_S: f64 = 0.1;

/// The largest part of the density that is called for; what is further off is a splash.
const LARGEST: f64 = 0.05;

/// Steps of the table of `f`.
const STEPS: usize = 64;

/// `Q/(C h)` and `1/C` over `u`.
fn row(u: f64) -> (f64, f64) {
    let c = 1.0 - 21.0 * u.powi(6) * (1.0 / 6.0 - 3.0 / 14.0 * u + u * u / 14.0);
    let q = 42.0 * u.powi(6) * (1.0 / 6.0 - 5.0 / 14.0 * u + 29.0 / 112.0 * u * u - 4.0 / 63.0 * u.powi(3));
    (q / c, 1.0 / c)
}

/// The law `c` of a packing: a parabola in `mu/h` up to the largest that it was fitted to.
#[derive(Clone, Copy, Debug)]
struct Law {
    c: Vector3<f64>,
    up_to: f64,
}

impl Law {
    fn at(&self, mu: f64) -> f64 {
        let mu = mu.min(self.up_to);
        self.c[0] + mu * (self.c[1] + mu * self.c[2])
    }

    /// The law that fits the ratios of densities to what the positions say, `(mu/h, ratio)`; `None` where they determine none.
    fn fit(ratios: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let (mut normal, mut right, mut up_to) = (Matrix3::zeros(), Vector3::zeros(), 0.0_f64);
        for (mu, ratio) in ratios {
            let powers = Vector3::new(1.0, mu, mu * mu);
            normal += powers * powers.transpose();
            right += powers * ratio;
            up_to = up_to.max(mu);
        }
        let c = normal.cholesky()?.solve(&right);
        c.iter().all(|c| c.is_finite()).then_some(Self { c, up_to })
    }
}

/// The call back of every particle.
#[derive(Clone, Debug)]
pub(crate) struct PositionDensity {
    /// `(mu/h, f)` in order.
    table: Vec<(f64, f64)>,
    law: Law,
    settled: bool,
    /// `mu/h` and `s f` of every particle.
    found: Vec<(f64, f64)>,
    /// Addition to the rate of density, kg/m3/s.
    pub(crate) recall: Vec<f64>,
}

impl PositionDensity {
    /// For `particles` particles that settle.
    pub(crate) fn new(particles: usize) -> Self {
        Self {
            table: (0..=STEPS).map(|k| row(k as f64 / STEPS as f64)).collect(),
            law: Law { c: Vector3::new(1.0, 0.0, 0.0), up_to: 0.0 },
            settled: false,
            found: vec![(0.0, 0.0); particles],
            recall: vec![0.0; particles],
        }
    }

    /// The law of the packing as it is now: the coefficients of its parabola, and the largest `mu/h` that it was fitted to.
    pub(crate) fn law(&self) -> [f64; 4] {
        let Law { c, up_to } = self.law;
        [c[0], c[1], c[2], up_to]
    }

    /// Keeps the law of a settled packing from here on, as [`Self::law`] gave it.
    pub(crate) fn keep(&mut self, [a, b, c, up_to]: [f64; 4]) {
        self.law = Law { c: Vector3::new(a, b, c), up_to };
        self.settled = true;
    }

    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        retain(&mut self.found, keep);
        retain(&mut self.recall, keep);
    }

    /// `f(mu/h)`; less than half of the neighbours of a flat surface is a splash, which has that surface's.
    fn completion(&self, mu: f64) -> f64 {
        let above = self.table.partition_point(|(m, _)| *m <= mu).clamp(1, STEPS);
        let ((m, f), (n, g)) = (self.table[above - 1], self.table[above]);
        f + ((mu - m) / (n - m)).min(1.0) * (g - f)
    }

    /// Finds anew what calls the densities of `liquid` back, from what the particles see with a kernel of length `h` m.
    pub(crate) fn update(&mut self, seen: impl IndexedParallelIterator<Item = Seen>, h: f64, liquid: &Fluid) {
        let mut found = std::mem::take(&mut self.found);
        found.par_iter_mut().zip(seen).with_min_len(512).for_each(|(found, seen)| {
            let mu = seen.offset() / h;
            *found = (mu, seen.density() * self.completion(mu));
        });
        if !self.settled {
            let ratios = found.iter().zip(&liquid.density).map(|((mu, q), rho)| (*mu, rho / q));
            self.law = Law::fit(ratios).unwrap_or(self.law);
        }
        for ((recall, (mu, q)), rho) in self.recall.iter_mut().zip(&found).zip(&liquid.density) {
            let off = (self.law.at(*mu) * q - rho) / rho;
            *recall = off.clamp(-LARGEST, LARGEST) * rho / TAU_S;
        }
        self.found = found;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::corrections::Moments;
    use crate::particles::{Box3, Kernel, Neighbours, Particle};
    use crate::walls::Walls;

    /// The kernel of h = 1 summed over a plane at the distance `z`.
    fn plane(z: f64) -> f64 {
        let kernel = Kernel::new(1.0);
        let step = 1e-3;
        let rings = (0..2000).map(|k| (f64::from(k) + 0.5) * step);
        rings.map(|rho| std::f64::consts::TAU * rho * kernel.value(rho * rho + z * z) * step).sum()
    }

    #[test]
    fn the_polynomials_are_the_integrals_of_the_kernel() {
        for depth in [0.0, 0.4, 1.0, 1.6] {
            let step = 1e-2;
            let above = |power: i32| {
                let steps = ((2.0 - depth) / step) as usize;
                let at = (0..steps).map(|k| depth + (k as f64 + 0.5) * step);
                at.map(|z| z.powi(power) * plane(z) * step).sum::<f64>()
            };
            let (c, q) = (1.0 - above(0), above(1));
            let (mu, f) = row(1.0 - 0.5 * depth);
            assert!(
                (f * c - 1.0).abs() < 1e-4 && (mu - q / c).abs() < 1e-4,
                "{mu}, {f} for {}, {}",
                q / c,
                1.0 / c
            );
        }
    }

    /// A block of 9 layers of 11 x 11 particles of density and spacing 1, `pressed` closer along z: what the middle of each
    /// layer sees.
    fn block(pressed: f64) -> (Fluid, Vec<Seen>) {
        let particle = (0..9 * 121_usize).map(|k| {
            let x = [(k % 11) as f64, (k / 11 % 11) as f64, (k / 121) as f64 / pressed];
            Particle { x, v: [0.0; 3], volume: 1.0 / pressed, p: 0.0 }
        });
        let n = 9 * 121;
        let fluid = Fluid {
            particle: particle.collect(),
            mass: vec![1.0; n],
            density: vec![1.0; n],
            viscosity: vec![0.0; n],
            acceleration: vec![[0.0; 3]; n],
            heat: vec![0.0; n],
        };
        let lists = Neighbours::new(&fluid.particle, &[], Box3 { low: [-1.0; 3], high: [12.0; 3] }, 2.8, 0.1);
        let mut moments = Moments::new(n);
        moments.form(&Kernel::new(1.4), &lists, &fluid, &Walls::default(), |_| 1.0);
        let seen = moments.seen().collect();
        (fluid, seen)
    }

    #[test]
    fn the_positions_tell_their_density_at_any_depth() {
        for pressed in [1.0, 1.1] {
            let positions = PositionDensity::new(0);
            let (_, seen) = block(pressed);
            for layer in 0..9 {
                let seen = seen[121 * layer + 60];
                let found = seen.density() * positions.completion(seen.offset() / 1.4);
                assert!((found / pressed - 1.0).abs() < 0.06, "layer {layer}: {found} for {pressed}");
            }
        }
    }

    #[test]
    fn a_density_is_called_to_the_positions_and_not_where_it_rests() {
        let (mut fluid, seen) = block(1.0);
        let mut positions = PositionDensity::new(seen.len());
        positions.update(seen.par_iter().copied(), 1.4, &fluid);
        let middle = 121 * 4 + 60;
        assert!(positions.recall[middle].abs() < 0.01 / TAU_S, "{}", positions.recall[middle]);
        positions.keep(positions.law());
        let before = positions.recall[middle];
        fluid.density[middle] = 0.98;
        positions.update(seen.par_iter().copied(), 1.4, &fluid);
        let called = positions.recall[middle] - before;
        assert!((called - 0.02 / TAU_S).abs() < 1e-9, "{called}");
    }
}
