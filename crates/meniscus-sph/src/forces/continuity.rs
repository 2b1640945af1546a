//! Rates of density: the continuity equation with its diffusion, and how complete a particle's neighbourhood is.
//!
//! With `x = x_i - x_j`, `v = v_i - v_j`, `V = m/rho`, `grad W = F x`:
//! ```text
//! continuity   rho_i' = rho_i tr(L_i sum_j V_j F x (x) v)  +  sum_j V_j D_ij  +  what `positions` calls back,
//! diffusion    D_ij = -2 delta h c0 F [ (p_j - p_i) - rho0 g.(x_j - x_i) ] / c0^2
//! surface      3/c_i = -sum_j V_j F r^2
//! ```
//! (diffusion: Fourtakas et al. 2019, Computers & Fluids 190, 346; `L`: [`Corrected`](crate::corrections::Corrected)). Images in the walls do not diffuse.

use crate::frame::Body;
use crate::particles::blocks::{BLOCK, Column, Near, PairSum, add, dot, gather, put, row, scatter, sum};
use crate::particles::tensor::{Symmetric, strain, trace};
use crate::particles::{Kernel, Neighbours, Particle};

/// Strength of the density diffusion, delta.
pub(super) const DELTA: f64 = 0.1;

/// Inputs of the sums.
pub(super) struct Continuity<'a> {
    pub(super) kernel: Kernel,
    pub(super) lists: &'a Neighbours,
    pub(super) particle: &'a [Particle],
    pub(super) image: &'a [Particle],
    /// `L` of every particle.
    pub(super) matrix: &'a [Symmetric],
    /// Pressure on the surface above each particle, Pa; empty where nothing presses.
    pub(super) pressed: &'a [[f64; 3]],
    pub(super) body: &'a Body,
    /// Density at zero pressure, kg/m3.
    pub(super) rest_density: f64,
    /// `-2 delta h/c0`, s.
    pub(super) diffusion: f64,
}

/// Volume strain rate 1/s, diffusive density rate kg/m3/s, and `3/c_i`.
type Rate = [f64; 3];

/// The columns of a block.
pub(super) struct Columns {
    near: Near,
    /// `L` of the neighbours.
    matrix: [Column; 6],
    /// Pressure on the surface above them, Pa.
    above: Column,
    mine: [Column; 3],
    theirs: [Column; 3],
}

impl Continuity<'_> {
    /// Adds to `out` what particle `i` gives the particles `at`; returns what they give it. `lift` is the gradient of the
    /// pressure at rest.
    #[inline(always)]
    fn liquid(&self, i: usize, lift: &[f64; 3], at: &[u32], columns: &mut Columns, out: &mut [Rate]) -> Rate {
        let (a, l) = (&self.particle[i], &self.matrix[i]);
        let Columns { near, matrix, above, mine, theirs } = columns;
        near.gather(self.particle, at);
        gather(matrix, self.matrix, at);
        // What presses on the surface is balanced by a gradient of p as the weight is.
        if !self.pressed.is_empty() {
            for (above, j) in above.iter_mut().zip(at) {
                *above = self.pressed[*j as usize][0] - self.pressed[i][0];
            }
        }
        for (k, above) in above.iter().enumerate().take(at.len()) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let t = strain(f, &d, &near.slower(&a.v, k));
            let flux = self.diffusion * f * (near.p[k] - a.p + dot(lift, &d) + above);
            let volume = near.volume[k];
            put(mine, k, [volume * trace(l, &t), volume * flux, -(volume * f * r2)]);
            put(theirs, k, [a.volume * trace(&row(matrix, k), &t), -(a.volume * flux), -(a.volume * f * r2)]);
        }
        scatter(theirs, at, out);
        sum(mine, at.len())
    }

    /// Contribution of the images `at` to particle `i`.
    #[inline(always)]
    fn wall(&self, i: usize, at: &[u32], columns: &mut Columns) -> Rate {
        let (a, l) = (&self.particle[i], &self.matrix[i]);
        let Columns { near, mine, .. } = columns;
        near.gather(self.image, at);
        for k in 0..at.len().min(BLOCK) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let t = strain(f, &d, &near.slower(&a.v, k));
            put(mine, k, [near.volume[k] * trace(l, &t), 0.0, -(near.volume[k] * f * r2)]);
        }
        sum(mine, at.len())
    }
}

impl PairSum<3> for Continuity<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        let empty = [0.0; BLOCK];
        Columns { near: Near::new(), matrix: [empty; 6], above: empty, mine: [empty; 3], theirs: [empty; 3] }
    }

    #[inline(always)]
    fn row(&self, i: usize, columns: &mut Columns, out: &mut [Rate]) {
        let [x, y, z] = self.body.still(&self.particle[i].x);
        let rho = self.rest_density;
        let lift = [rho * x, rho * y, rho * z];
        for at in self.lists.liquid.row(i).chunks(BLOCK) {
            let own = self.liquid(i, &lift, at, columns, out);
            add(&mut out[i], &own);
        }
        for at in self.lists.wall.row(i).chunks(BLOCK) {
            add(&mut out[i], &self.wall(i, at, columns));
        }
    }
}
