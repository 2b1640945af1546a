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
use crate::particles::blocks::{BLOCK, LAST, Own, PairSum, Panel, VOLUME, dot, whole};
use crate::particles::lanes::{Single, Width};
use crate::particles::tensor::{first, times};
use crate::particles::{Kernel, Neighbours};
use crate::walls::Walls;

/// The factor of the viscous pair force in three dimensions, 2 (d + 2).
pub(super) const K: f32 = 10.0;

/// Inputs of the sums.
pub(super) struct Momentum<'a> {
    pub(super) kernel: Kernel<f32>,
    pub(super) lists: &'a Neighbours,
    pub(super) particle: &'a [Single<8>],
    pub(super) walls: &'a Walls,
    /// `p L` of every particle, Pa, then its `c_i mu_i`, Pa s.
    pub(super) pressure: &'a [Single<8>],
    /// `c_i mu_i` of every particle, Pa s.
    pub(super) drag: &'a [f64],
    pub(super) gradients: &'a Gradients,
    /// Viscosity for what is not smooth, Pa s, where some particle has less than this of its own.
    pub(super) noise: Option<f32>,
    /// 1 where friction acts here, 0 where [`Friction`](super::Friction) has it.
    pub(super) rubs: f32,
    /// `0.01 h^2`, m2.
    pub(super) soft: f32,
}

/// Force N (3), dissipated power W, squared shear rate without its `c_i` 1/s2; zeros.
type Push = [f32; 8];

/// The columns of a block.
pub(super) struct Columns {
    near: Panel<f32>,
    /// `p L` of the neighbours, Pa, and their `c_j mu_j`, Pa s; of images, along with their velocity as friction sees it.
    pressure: Panel<f32>,
    /// Symmetric velocity gradients of the neighbours, 1/s.
    gradient: Panel<f32>,
    /// Sums for the neighbours.
    theirs: Panel<f32>,
    /// Sums from them.
    mine: Panel<f32>,
}

/// Column of `c_j mu_j`.
const DRAG: usize = 6;

impl Momentum<'_> {
    /// Adds to `out` what particle `i` gives the particles `at`; returns what they give it. `NOISY` is whether some particle has less
    /// than the viscosity `noise` of its own.
    #[inline(always)]
    fn liquid<W: Width, const NOISY: bool>(
        &self,
        i: usize,
        noise: f32,
        at: &[u32],
        columns: &mut Columns,
        out: &mut [Single<8>],
    ) -> Push {
        let (a, own) = (Own::new(&self.particle[i]), &self.pressure[i].0);
        let (p, drag, g) = (first(own), own[DRAG], first(&self.gradients.g[i].0));
        let Columns { near, pressure, gradient, theirs, mine } = columns;
        near.gather::<W>(self.particle, at);
        pressure.gather::<W>(self.pressure, at);
        if NOISY {
            gradient.gather::<W>(&self.gradients.g, at);
        }
        for k in 0..whole(at.len()) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let closing = dot(&near.slower(&a.v, k), &d);
            let f = self.kernel.slope(r2);
            let (both, inverse) = (a.volume * near.0[VOLUME][k] * f, 1.0 / (r2 + self.soft));
            let mean = 0.5 * (drag + pressure.0[DRAG][k]);
            let mut rub = self.rubs * K * mean * closing * inverse;
            if NOISY {
                let rough = closing - share(&g, &gradient.row(k), &d);
                rub += K * (noise - mean).max(0.0) * rough * inverse;
            }
            let heat = -0.5 * both * rub * closing;
            let shear = -0.5 * K * f * closing * closing * inverse;
            let q: [f32; 6] = pressure.row(k);
            let both_p = [p[0] + q[0], p[1] + q[1], p[2] + q[2], p[3] + q[3], p[4] + q[4], p[5] + q[5]];
            let press = times(&both_p, &d);
            let x = both * (rub * d[0] - press[0]);
            let y = both * (rub * d[1] - press[1]);
            let z = both * (rub * d[2] - press[2]);
            theirs.put(k, [-x, -y, -z, heat, a.volume * shear]);
            mine.put(k, [x, y, z, heat, near.0[VOLUME][k] * shear]);
        }
        theirs.scatter::<W, 8>(at, out, 0);
        mine.totals::<W>(at.len())
    }

    /// Contribution of the images `at` to particle `i`.
    #[inline(always)]
    fn wall<W: Width>(&self, i: usize, at: &[u32], columns: &mut Columns) -> Push {
        let (a, own) = (Own::new(&self.particle[i]), &self.pressure[i].0);
        let (p, drag) = (first(own), own[DRAG]);
        let Columns { near, pressure, mine, .. } = columns;
        near.gather::<W>(&self.walls.rubbed, at);
        pressure.gather::<W>(&self.walls.pressure, at);
        for k in 0..whole(at.len()) {
            let d = near.apart(&a.x, k);
            let r2 = dot(&d, &d);
            let f = self.kernel.slope(r2);
            let both = a.volume * near.0[VOLUME][k] * f;
            let own_speed = dot(&a.v, &d);
            let rubbing = [near.0[LAST][k], pressure.0[6][k], pressure.0[7][k]];
            let dot_v = own_speed - dot(&rubbing, &d);
            let sliding = dot_v / (r2 + self.soft);
            let rub = self.rubs * both * K * drag * sliding;
            let (press, image) = (times(&p, &d), times(&pressure.row(k), &d));
            let x = rub * d[0] - both * (press[0] + image[0]);
            let y = rub * d[1] - both * (press[1] + image[1]);
            let z = rub * d[2] - both * (press[2] + image[2]);
            // The wall stands still, so the power of its friction is heat; so is what a round mirror does not give back
            // of the power of pressure.
            let heat = both * (dot(&image, &a.v) + dot(&press, &near.velocity(k))) - rub * own_speed;
            mine.put(k, [x, y, z, heat, -0.5 * K * near.0[VOLUME][k] * f * sliding * dot_v]);
        }
        mine.totals::<W>(at.len())
    }
}

impl PairSum<8> for Momentum<'_> {
    type Columns = Columns;

    fn columns(&self) -> Columns {
        let empty = Panel::new();
        Columns { near: empty, pressure: empty, gradient: empty, theirs: empty, mine: empty }
    }

    #[inline(always)]
    fn row<W: Width>(&self, i: usize, columns: &mut Columns, out: &mut [Single<8>]) {
        for at in self.lists.liquid.row(i).chunks(BLOCK) {
            let own = match self.noise {
                Some(noise) => self.liquid::<W, true>(i, noise, at, columns, out),
                None => self.liquid::<W, false>(i, 0.0, at, columns, out),
            };
            out[i].give(own);
        }
        for at in self.lists.wall.row(i).chunks(BLOCK) {
            out[i].give(self.wall::<W>(i, at, columns));
        }
    }
}
