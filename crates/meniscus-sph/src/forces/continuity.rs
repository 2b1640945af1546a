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
use crate::particles::blocks::{BLOCK, LAST, Own, PairSum, Panel, Quads, VOLUME, dot, whole};
use crate::particles::lanes::{Lane, Single, Width};
use crate::particles::tensor::{first, strain, trace};
use crate::particles::{Kernel, Neighbours};

/// Strength of the density diffusion, delta.
pub(super) const DELTA: f64 = 0.1;

/// Inputs of the sums.
pub(super) struct Continuity<'a> {
    pub(super) kernel: Kernel<f32>,
    pub(super) lists: &'a Neighbours,
    /// Position (3), velocity (3), volume and pressure of the particles.
    pub(super) particle: &'a [Single<8>],
    /// Those of the images.
    pub(super) image: &'a [Single<8>],
    /// `L` of every particle, then the pressure on the surface above it, Pa.
    pub(super) matrix: &'a [Single<8>],
    pub(super) body: &'a Body,
    /// Density at zero pressure, kg/m3.
    pub(super) rest_density: f64,
    /// `-2 delta h/c0`, s.
    pub(super) diffusion: f32,
}

/// The columns of a block.
pub(super) struct Columns {
    near: Panel<f32>,
    /// `L` of the neighbours and the pressure above them.
    matrix: Panel<f32>,
    /// Sums from the neighbours: volume strain rate 1/s, diffusive density rate kg/m3/s, `3/c_i`.
    mine: Quads,
    /// The same for the neighbours, with their signs changed.
    taken: Quads,
}

impl Continuity<'_> {
    /// Adds to `out` what particle `i` gives the particles `at`; returns what they give it. `lift` is the gradient of the
    /// pressure at rest.
    #[inline(always)]
    fn liquid<W: Width>(
        &self,
        i: usize,
        lift: &[f32; 3],
        at: &[u32],
        columns: &mut Columns,
        out: &mut [Single<4>],
    ) -> [f32; 4] {
        let (a, own) = (Own::new(&self.particle[i]), &self.matrix[i].0);
        let (l, pressed) = (&first(own), own[6]);
        let Columns { near, matrix, mine, taken } = columns;
        near.gather::<W>(self.particle, at);
        matrix.gather::<W>(self.matrix, at);
        for k in 0..whole(at.len()) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let t = strain(f, &d, &near.slower(&a.v, k));
            // What presses on the surface is balanced by a gradient of p as the weight is.
            let above = matrix.0[6][k] - pressed;
            let flux = self.diffusion * f * (near.0[LAST][k] - a.last + dot(lift, &d) + above);
            let volume = near.0[VOLUME][k];
            taken.put(k, [-(a.volume * trace(&matrix.row(k), &t)), a.volume * flux, a.volume * f * r2]);
            mine.put(k, [volume * trace(l, &t), volume * flux, -(volume * f * r2)]);
        }
        taken.take::<W>(at, out);
        mine.totals::<W>(at.len())
    }

    /// Contribution of the images `at` to particle `i`.
    #[inline(always)]
    fn wall<W: Width>(&self, i: usize, at: &[u32], columns: &mut Columns) -> [f32; 4] {
        let (a, l) = (Own::new(&self.particle[i]), &first(&self.matrix[i].0));
        let Columns { near, mine, .. } = columns;
        near.gather::<W>(self.image, at);
        for k in 0..whole(at.len()) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let t = strain(f, &d, &near.slower(&a.v, k));
            let volume = near.0[VOLUME][k];
            mine.put(k, [volume * trace(l, &t), 0.0, -(volume * f * r2)]);
        }
        mine.totals::<W>(at.len())
    }
}

impl PairSum<4> for Continuity<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        Columns { near: Panel::new(), matrix: Panel::new(), mine: Quads::new(), taken: Quads::new() }
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, columns: &mut Columns, out: &mut [Single<4>]) {
        let [x, y, z, ..] = self.particle[i].0.map(f64::from);
        let lift = self.body.still(&[x, y, z]).map(|g| f32::of(self.rest_density * g));
        for at in self.lists.liquid.row(i).chunks(BLOCK) {
            let own = self.liquid::<W>(i, &lift, at, columns, out);
            out[i].give(own);
        }
        for at in self.lists.wall.row(i).chunks(BLOCK) {
            out[i].give(self.wall::<W>(i, at, columns));
        }
    }
}
