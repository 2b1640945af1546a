//! Rates of change of density and velocity: sums over pairs of neighbours.
//!
//! With `x = x_i - x_j`, `v = v_i - v_j`, `V = m/rho`, `grad W = F x`:
//! ```text
//! continuity   rho_i' = rho_i sum_j V_j F v.x  +  sum_j V_j D_ij,
//! diffusion    D_ij = -2 delta h c0 F [ (p_j - p_i) - rho0 g.(x_j - x_i) ] / c0^2
//! momentum     m_i v_i' = -sum_j V_i V_j (p_i + p_j) F x  +  sum_j V_i V_j K mu_ij F (v.x)/(r^2 + 0.01 h^2) x  +  m_i g
//! heat         each of a pair gains half of   -V_i V_j K mu_ij F (v.x)^2/(r^2 + 0.01 h^2)
//! shear rate   rate_i^2 = -(K/2) sum_j V_j F (v.x)^2/(r^2 + 0.01 h^2)   -> 2 D:D in the continuum
//! ```
//! Pressure and continuity are conjugate, so the pairs exchange kinetic and compressive energy
//! exactly. Sources: diffusion, Fourtakas et al. 2019 (Computers & Fluids 190, 346); viscosity,
//! Monaghan and Gingold 1983 with K = 2 (d + 2) = 10 (Violeau 2009), which loses no accuracy at a
//! free surface. Walls have no diffusion and stand still in the continuity equation.

use super::kernel::Kernel;
use super::neighbours::{CHUNKS, Neighbours};
use super::state::{Fluid, Particle};
use crate::offline::prelude::*;
use rayon::prelude::*;

/// The factor of the viscous pair force in three dimensions, 2 (d + 2).
const K: f64 = 10.0;

/// Strength of the density diffusion.
const DELTA: f64 = 0.1;

/// Constants and scratch memory of the sums.
#[derive(Clone, Debug)]
pub(crate) struct Forces {
    /// The kernel.
    pub(crate) kernel: Kernel,
    /// Numerical speed of sound, m/s.
    pub(crate) sound: f64,
    /// Density at zero pressure, kg/m3.
    pub(crate) rest_density: f64,
    /// Whether the liquid sticks to the wall.
    pub(crate) no_slip: bool,
    rate_buffers: Vec<Vec<[f64; 2]>>,
    force_buffers: Vec<Vec<[f64; 5]>>,
    /// Volume strain rate 1/s and diffusive density rate kg/m3/s.
    pub(crate) rate: Vec<[f64; 2]>,
    /// Force N (3), dissipated power W, squared shear rate 1/s2.
    pub(crate) force: Vec<[f64; 5]>,
}

/// Separation and its square, relative velocity along it.
#[inline]
fn pair(a: &Particle, b: &Particle) -> ([f64; 3], f64, f64) {
    let d = [a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]];
    let r2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let dot = (a.v[0] - b.v[0]) * d[0] + (a.v[1] - b.v[1]) * d[1] + (a.v[2] - b.v[2]) * d[2];
    (d, r2, dot)
}

impl Forces {
    /// Sums for `particles` particles.
    pub(crate) fn new(
        kernel: Kernel,
        sound: f64,
        rest_density: f64,
        no_slip: bool,
        particles: usize,
    ) -> Self {
        Self {
            kernel,
            sound,
            rest_density,
            no_slip,
            rate_buffers: vec![Vec::new(); CHUNKS],
            force_buffers: vec![Vec::new(); CHUNKS],
            rate: vec![[0.0; 2]; particles],
            force: vec![[0.0; 5]; particles],
        }
    }

    /// Fills `rate` from the present positions, velocities and pressures under the body force `g`.
    pub(crate) fn density_rates(
        &mut self,
        lists: &Neighbours,
        liquid: &Fluid,
        wall: &[Particle],
        g: [f64; 3],
    ) {
        let kernel = self.kernel;
        let diffusion = -2.0 * DELTA * kernel.h / self.sound;
        let lift = [self.rest_density * g[0], self.rest_density * g[1], self.rest_density * g[2]];
        let particle = &liquid.particle;
        lists.sum(&mut self.rate_buffers, &mut self.rate, |i, out| {
            let a = &particle[i];
            let mut own = [0.0; 2];
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let (d, r2, dot) = pair(a, b);
                let f = kernel.slope(r2);
                let rest = lift[0] * d[0] + lift[1] * d[1] + lift[2] * d[2];
                let flux = diffusion * f * (b.p - a.p + rest);
                own[0] += b.volume * f * dot;
                own[1] += b.volume * flux;
                let other = &mut out[j as usize];
                other[0] += a.volume * f * dot;
                other[1] -= a.volume * flux;
            }
            for &w in lists.wall.row(i) {
                let b = &wall[w as usize];
                let (d, r2, _) = pair(a, b);
                own[0] += b.volume * kernel.slope(r2) * (a.v[0] * d[0] + a.v[1] * d[1] + a.v[2] * d[2]);
            }
            out[i][0] += own[0];
            out[i][1] += own[1];
        });
    }

    /// Fills `force` (without the body force) from the present state.
    pub(crate) fn forces(&mut self, lists: &Neighbours, liquid: &Fluid, wall: &[Particle]) {
        let kernel = self.kernel;
        let soft = 0.01 * kernel.h * kernel.h;
        let Fluid { particle, viscosity, .. } = liquid;
        let no_slip = self.no_slip;
        lists.sum(&mut self.force_buffers, &mut self.force, |i, out| {
            let a = &particle[i];
            let mut own = [0.0; 5];
            for &j in lists.liquid.row(i) {
                let b = &particle[j as usize];
                let (d, r2, dot) = pair(a, b);
                let f = kernel.slope(r2);
                let both = a.volume * b.volume * f;
                let sliding = dot / (r2 + soft);
                let mu = 0.5 * K * (viscosity[i] + viscosity[j as usize]);
                let size = both * (mu * sliding - (a.p + b.p));
                let heat = -0.5 * both * mu * sliding * dot;
                let shear = -0.5 * K * f * sliding * dot;
                let push = [size * d[0], size * d[1], size * d[2]];
                own[0] += push[0];
                own[1] += push[1];
                own[2] += push[2];
                own[3] += heat;
                own[4] += b.volume * shear;
                let other = &mut out[j as usize];
                other[0] -= push[0];
                other[1] -= push[1];
                other[2] -= push[2];
                other[3] += heat;
                other[4] += a.volume * shear;
            }
            for &w in lists.wall.row(i) {
                let b = &wall[w as usize];
                let (d, r2, dot) = pair(a, b);
                let f = kernel.slope(r2);
                let both = a.volume * b.volume * f;
                let sliding = if no_slip { dot / (r2 + soft) } else { 0.0 };
                let rub = both * K * viscosity[i] * sliding;
                let size = rub - both * (a.p + b.p);
                own[0] += size * d[0];
                own[1] += size * d[1];
                own[2] += size * d[2];
                // The wall stands still: the power of its friction and of its pressure (which has
                // no partner in the continuity equation) stays in the liquid as heat.
                let speed = d[0] * a.v[0] + d[1] * a.v[1] + d[2] * a.v[2];
                own[3] -= (rub - both * b.p) * speed;
                own[4] -= 0.5 * K * b.volume * f * sliding * dot;
            }
            for (o, s) in out[i].iter_mut().zip(own) {
                *o += s;
            }
        });
    }

    /// Accelerations of the particles under `g`, from the last `forces`.
    pub(crate) fn accelerations(&self, liquid: &mut Fluid, g: [f64; 3]) {
        let Fluid { acceleration, mass, .. } = liquid;
        acceleration.par_iter_mut().zip(&*mass).zip(&self.force).with_min_len(512).for_each(|((a, m), f)| {
            *a = [f[0] / m + g[0], f[1] / m + g[1], f[2] / m + g[2]];
        });
    }
}
