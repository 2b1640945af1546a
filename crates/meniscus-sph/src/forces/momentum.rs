//! Pressure and friction: the momentum equation, the heat of its friction and the rate of shear.
//!
//! With `x = x_i - x_j`, `v = v_i - v_j`, `V = m/rho`, `grad W = F x`, `s = (v.x)/(r^2 + 0.01 h^2)`:
//! ```text
//! momentum     m_i v_i' = -sum_j V_i V_j (p_i L_i + p_j L_j) F x  +  sum_j V_i V_j K (c_i mu_i + c_j mu_j)/2 F s x  +  m_i g
//! heat         each of a pair gains half of   -V_i V_j K (c_i mu_i + c_j mu_j)/2 F s v.x
//! shear rate   rate_i^2 = -(K/2) c_i sum_j V_j F s v.x   -> 2 D:D in the continuum
//! ```
//! Viscosity: Monaghan and Gingold 1983 with K = 2 (d + 2) = 10 (Violeau 2009). `c_i` is 1 in the bulk and about 2 at a free
//! surface, where half of the neighbours are missing: without it the surface layer dissipates half of what it should
//! (glycerine's first mode 7 % too little without walls' friction). The sum over an even function of direction needs no other
//! correction. The friction of what is not smooth is that of [`Gradients`].

use crate::corrections::{Gradients, share};
use crate::particles::blocks::{
    BLOCK, Column, Near, PairSum, add, dot, gather, gather_numbers, put, row, scatter, sum,
};
use crate::particles::tensor::{Symmetric, times};
use crate::particles::{Kernel, Neighbours, Particle};
use crate::walls::Walls;

/// The factor of the viscous pair force in three dimensions, 2 (d + 2).
pub(super) const K: f64 = 10.0;

/// Inputs of the sums.
pub(super) struct Momentum<'a> {
    pub(super) kernel: Kernel,
    pub(super) lists: &'a Neighbours,
    pub(super) particle: &'a [Particle],
    pub(super) walls: &'a Walls,
    /// `p L` of every particle, Pa.
    pub(super) pressure: &'a [Symmetric],
    /// `c_i mu_i` of every particle, Pa s.
    pub(super) drag: &'a [f64],
    pub(super) gradients: &'a Gradients,
    /// Viscosity for what is not smooth, Pa s, where some particle has less than this of its own.
    pub(super) noise: Option<f64>,
    /// 1 where friction acts here, 0 where [`Friction`](super::Friction) has it.
    pub(super) rubs: f64,
    /// `0.01 h^2`, m2.
    pub(super) soft: f64,
}

/// Force N (3), dissipated power W, squared shear rate without its `c_i` 1/s2.
type Push = [f64; 5];

/// The columns of a block.
pub(super) struct Columns {
    near: Near,
    /// `p L` of the neighbours, Pa.
    pressure: [Column; 6],
    /// `c_j mu_j`, Pa s.
    drag: Column,
    /// Symmetric velocity gradients of the neighbours, 1/s.
    gradient: [Column; 6],
    /// Stress against the jitter, Pa; zero where it is not needed.
    jitter: Column,
    /// Velocities of images as friction sees them, m/s.
    rubbing: [Column; 3],
    mine: [Column; 5],
    theirs: [Column; 5],
}

impl Momentum<'_> {
    /// Adds to `out` what particle `i` gives the particles `at`; returns what they give it.
    #[inline(always)]
    fn liquid(&self, i: usize, at: &[u32], columns: &mut Columns, out: &mut [Push]) -> Push {
        let (a, p, drag) = (&self.particle[i], &self.pressure[i], self.drag[i]);
        columns.near.gather(self.particle, at);
        gather_numbers(&mut columns.drag, self.drag, at);
        gather(&mut columns.pressure, self.pressure, at);
        if let Some(noise) = self.noise {
            self.jitter(noise, i, at, columns);
        }
        let Columns { near, pressure, drag: drags, jitter, mine, theirs, .. } = columns;
        for k in 0..at.len().min(BLOCK) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let dot = dot(&near.slower(&a.v, k), &d);
            let f = self.kernel.slope(r2);
            let (both, inverse) = (a.volume * near.volume[k] * f, 1.0 / (r2 + self.soft));
            let rub = self.rubs * K * (0.5 * (drag + drags[k])) * dot * inverse + jitter[k];
            let heat = -0.5 * both * rub * dot;
            let shear = -0.5 * K * f * dot * dot * inverse;
            let q = row(pressure, k);
            let both_p = [p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]];
            let press = times(&both_p, &d);
            let x = both * (rub * d[0] - press[0]);
            let y = both * (rub * d[1] - press[1]);
            let z = both * (rub * d[2] - press[2]);
            put(mine, k, [x, y, z, heat, near.volume[k] * shear]);
            put(theirs, k, [-x, -y, -z, heat, a.volume * shear]);
        }
        scatter(theirs, at, out);
        sum(mine, at.len())
    }

    /// Fills what rubs against what is not smooth between particle `i` and the gathered particles `at`, up to the viscosity
    /// `noise`.
    #[inline(always)]
    fn jitter(&self, noise: f64, i: usize, at: &[u32], columns: &mut Columns) {
        let (a, drag) = (&self.particle[i], self.drag[i]);
        let Columns { near, drag: drags, gradient, jitter, .. } = columns;
        let g = &self.gradients.g[i];
        gather(gradient, &self.gradients.g, at);
        for k in 0..at.len().min(BLOCK) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let lacks = (noise - 0.5 * (drag + drags[k])).max(0.0);
            let rough = dot(&near.slower(&a.v, k), &d) - share(g, &row(gradient, k), &d);
            jitter[k] = K * lacks * rough * (1.0 / (r2 + self.soft));
        }
    }

    /// Contribution of the images `at` to particle `i`.
    #[inline(always)]
    fn wall(&self, i: usize, at: &[u32], columns: &mut Columns) -> Push {
        let (a, p, drag) = (&self.particle[i], &self.pressure[i], self.drag[i]);
        let Columns { near, pressure, rubbing, mine, .. } = columns;
        near.gather(&self.walls.image, at);
        gather(pressure, &self.walls.pressure, at);
        gather(rubbing, &self.walls.rubbing, at);
        for k in 0..at.len().min(BLOCK) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let both = a.volume * near.volume[k] * f;
            let own_speed = dot(&a.v, &d);
            let dot_v = own_speed - dot(&row(rubbing, k), &d);
            let sliding = dot_v / (r2 + self.soft);
            let rub = self.rubs * both * K * drag * sliding;
            let (press, image) = (times(p, &d), times(&row(pressure, k), &d));
            let x = rub * d[0] - both * (press[0] + image[0]);
            let y = rub * d[1] - both * (press[1] + image[1]);
            let z = rub * d[2] - both * (press[2] + image[2]);
            // The wall stands still, so the power of its friction is heat; so is what a round mirror does not give back
            // of the power of pressure.
            let heat = both * (dot(&image, &a.v) + dot(&press, &near.velocity(k))) - rub * own_speed;
            put(mine, k, [x, y, z, heat, -0.5 * K * near.volume[k] * f * sliding * dot_v]);
        }
        sum(mine, at.len())
    }
}

impl PairSum<5> for Momentum<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        let empty = [0.0; BLOCK];
        Columns {
            near: Near::new(),
            pressure: [empty; 6],
            drag: empty,
            gradient: [empty; 6],
            jitter: empty,
            rubbing: [empty; 3],
            mine: [empty; 5],
            theirs: [empty; 5],
        }
    }

    #[inline(always)]
    fn row(&self, i: usize, columns: &mut Columns, out: &mut [Push]) {
        for at in self.lists.liquid.row(i).chunks(BLOCK) {
            let own = self.liquid(i, at, columns, out);
            add(&mut out[i], &own);
        }
        for at in self.lists.wall.row(i).chunks(BLOCK) {
            add(&mut out[i], &self.wall(i, at, columns));
        }
    }
}
