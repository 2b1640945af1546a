//! Viscoelastic memory: a Maxwell stress S on every particle beside the viscous one.
//!
//! ```text
//! S' = 2 G D + W S - S W - S/lambda           (Maxwell 1867; co-rotational rate, Jaumann 1911)
//! stored  S:S/(4 G),     heat  S:S/(2 G lambda)     a volume
//! ```
//! with `D`, `W` the symmetric (without trace) and skew parts of the velocity gradient L; the rotation
//! does no work. Small waves see the viscosity `G lambda/(1 + i w lambda)`: their decay grows by the real
//! part, their frequency rises by the imaginary part.
//!
//! Gradient and force are conjugate sums over pairs, `x = x_i - x_j`, `grad W = F x`:
//! ```text
//! L_i = c_i sum_j V_j (v_j - v_i) (x) F x,     m_i a_i = sum_j V_i V_j (c_i S_i + c_j S_j) F x
//! sum_i v_i.m_i a_i = -sum_i V_i S_i:L_i
//! ```
//! with `c_i` of `corrections::completion`, which makes up for the neighbours that a free surface lacks,
//! so that the liquid loses exactly what the stress takes up. An image `w` in the wall continues the profile of the particles
//! behind it: it moves with `B_w` times the velocity of its original `o`, `-1` where the liquid sticks (see `walls`), and gives back to it
//! what it takes:
//! ```text
//! L_i += c_i V_w (B_w v_o - v_i) (x) F x,    m_i a_i += V_i V_w c_i S_i F x,    m_o a_o -= B_w^T V_i V_w c_i S_i F x
//! ```
//! The relaxation is implicit:
//! ```text
//! S <- [ S + dt (2 G D + W S - S W) ] / (1 + dt/lambda)
//! ```
//! and what the implicit step loses, `|dS|^2/(4 G)`, is booked as heat.

use super::laws::Relaxation;
use super::surroundings::Surroundings;
use crate::corrections::completion;
use crate::particles::lanes::Row;
use crate::particles::{CHUNKS, Fluid, Particle, distance2, retain};
use crate::walls::Map;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

/// The Maxwell branch.
#[derive(Clone, Debug)]
pub(super) struct Maxwell {
    modulus: f64,
    time_s: f64,
    stress: Vec<Matrix3<f64>>,
    gradient: Vec<[f64; 9]>,
    gradient_buffers: Vec<Vec<Row<9>>>,
    force: Vec<[f64; 3]>,
    force_buffers: Vec<Vec<Row<3>>>,
    /// From the velocities of the originals to those of their images.
    maps: Vec<Map>,
    /// Velocities of the images, m/s.
    behind: Vec<[f64; 3]>,
}

impl Maxwell {
    /// A branch without stress that obeys `relaxation`.
    pub(super) fn new(relaxation: Relaxation, particles: usize) -> Self {
        let Relaxation { modulus_pa: modulus, time_s } = relaxation;
        Self {
            modulus,
            time_s,
            stress: vec![Matrix3::zeros(); particles],
            gradient: vec![[0.0; 9]; particles],
            gradient_buffers: vec![Vec::new(); CHUNKS],
            force: vec![[0.0; 3]; particles],
            force_buffers: vec![Vec::new(); CHUNKS],
            maps: Vec::new(),
            behind: Vec::new(),
        }
    }

    /// Keeps the particles that are in `keep`.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        retain(&mut self.stress, keep);
        retain(&mut self.gradient, keep);
        retain(&mut self.force, keep);
    }

    /// Advances the stress by `dt` under the present velocities and books its heat.
    pub(super) fn advance(&mut self, dt: f64, around: &Surroundings<'_>, fluid: &mut Fluid) {
        let Surroundings { kernel, lists, walls, sticking, rate, glass, .. } = *around;
        let particle = &fluid.particle;
        walls.map(glass, fluid, sticking.straight(), &mut self.maps);
        self.behind.clear();
        self.behind.extend(walls.mapped(&self.maps, |i| particle[i].v));
        let behind = &self.behind;
        lists.sum(&mut self.gradient_buffers, &mut self.gradient, &|i: usize, out: &mut [Row<9>]| {
            let a = &particle[i];
            let mut own = [0.0; 9];
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let f = kernel.slope(distance2(&a.x, &b.x));
                let other = &mut out[j as usize].0;
                for row in 0..3 {
                    for column in 0..3 {
                        // Both signs change between the partners, so that the product is the same.
                        let part = f * (b.v[row] - a.v[row]) * (a.x[column] - b.x[column]);
                        own[3 * row + column] += b.volume * part;
                        other[3 * row + column] += a.volume * part;
                    }
                }
            }
            for &w in lists.wall.row(i) {
                let (b, u) = (&walls.image[w as usize], &behind[w as usize]);
                let f = b.volume * kernel.slope(distance2(&a.x, &b.x));
                for row in 0..3 {
                    for column in 0..3 {
                        own[3 * row + column] += f * (u[row] - a.v[row]) * (a.x[column] - b.x[column]);
                    }
                }
            }
            out[i].0.iter_mut().zip(own).for_each(|(o, s)| *o += s);
        });
        for (gradient, [_, _, seen]) in self.gradient.iter_mut().zip(rate) {
            gradient.iter_mut().for_each(|g| *g *= completion(*seen));
        }
        let (modulus, time_s) = (self.modulus, self.time_s);
        let Fluid { particle, mass, heat, .. } = fluid;
        let bodies = particle.par_iter().zip(&*mass).zip(heat.par_iter_mut());
        let parts = self.stress.par_iter_mut().zip(&self.gradient).zip(bodies).with_min_len(256);
        parts.for_each(|((stress, gradient), ((p, m), heat))| {
            let l = Matrix3::from_row_slice(gradient);
            let w = (l - l.transpose()) * 0.5;
            let d = (l + l.transpose()) * 0.5 - Matrix3::identity() * (l.trace() / 3.0);
            let turned = *stress + (w * *stress - *stress * w) * dt;
            // Turning must not stretch the stress: it keeps its size to the last bit but rounding.
            let size = turned.norm();
            let turned = if size > 0.0 { turned * (stress.norm() / size) } else { turned };
            let new = (turned + d * (2.0 * modulus * dt)) / (1.0 + dt / time_s);
            let lost = new.norm_squared() * dt / (2.0 * modulus * time_s)
                + (new - turned).norm_squared() / (4.0 * modulus);
            *heat += lost * p.volume / m;
            *stress = new;
        });
    }

    /// Adds the accelerations that the stress causes.
    pub(super) fn push(&mut self, around: &Surroundings<'_>, fluid: &mut Fluid) {
        let Surroundings { kernel, lists, walls, sticking, rate, glass, .. } = *around;
        walls.map(glass, fluid, sticking.straight(), &mut self.maps);
        let Fluid { particle, mass, acceleration, .. } = fluid;
        let (particle, stress, maps) = (&*particle, &self.stress, &self.maps);
        let c = |i: usize| completion(rate[i][2]);
        lists.sum(&mut self.force_buffers, &mut self.force, &|i: usize, out: &mut [Row<3>]| {
            let a = &particle[i];
            let mut own = [0.0; 3];
            let mut add = |f: f64, s: Matrix3<f64>, x: [f64; 3]| -> [f64; 3] {
                let push: [f64; 3] =
                    std::array::from_fn(|r| f * (s[(r, 0)] * x[0] + s[(r, 1)] * x[1] + s[(r, 2)] * x[2]));
                own.iter_mut().zip(push).for_each(|(o, p)| *o += p);
                push
            };
            let apart = |x: &[f64; 3]| -> [f64; 3] { std::array::from_fn(|k| a.x[k] - x[k]) };
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let f = a.volume * b.volume * kernel.slope(distance2(&a.x, &b.x));
                let push = add(f, stress[i] * c(i) + stress[j as usize] * c(j as usize), apart(&b.x));
                out[j as usize].0.iter_mut().zip(push).for_each(|(o, p)| *o -= p);
            }
            for &w in lists.wall.row(i) {
                let b = &walls.image[w as usize];
                let f = a.volume * b.volume * kernel.slope(distance2(&a.x, &b.x));
                add(f, stress[i] * c(i), apart(&b.x));
            }
            out[i].0.iter_mut().zip(own).for_each(|(o, s)| *o += s);
        });
        // What the images take, their originals get: image by image over the particles that see it.
        let seers = lists.wall.transposed(walls.image.len());
        let taken = |(w, b): (usize, &Particle)| {
            let mut sum = Vector3::zeros();
            for &i in seers.row(w) {
                let (i, a) = (i as usize, &particle[i as usize]);
                let f = a.volume * b.volume * kernel.slope(distance2(&a.x, &b.x));
                sum += stress[i] * (Vector3::from(a.x) - Vector3::from(b.x)) * (f * c(i));
            }
            (walls.original(w), (Matrix3::from(maps[w]) * sum).into())
        };
        let taken: Vec<(usize, [f64; 3])> = walls.image.par_iter().enumerate().map(taken).collect();
        for (original, force) in taken {
            self.force[original].iter_mut().zip(force).for_each(|(sum, f)| *sum -= f);
        }
        for ((a, f), m) in acceleration.iter_mut().zip(&self.force).zip(mass) {
            a.iter_mut().zip(f).for_each(|(a, f)| *a += f / *m);
        }
    }

    /// Stored energy, J.
    pub(super) fn stored(&self, fluid: &Fluid) -> f64 {
        let parts = self.stress.iter().zip(&fluid.particle);
        parts.map(|(s, p)| p.volume * s.norm_squared()).sum::<f64>() / (4.0 * self.modulus)
    }
}
