//! The wall model of Adami, Hu and Adams (2012, J. Comput. Phys. 231, 7057): wall particles carry the
//! pressure of the liquid nearby, continued by the body force, and minus its velocity (no slip).
//!
//! ```text
//! p_w = sum_f [ p_f + rho_f g . (x_w - x_f) ] W_wf / sum_f W_wf,      v_w = - sum_f v_f W_wf / sum_f W_wf
//! ```
//! with `g` the body force of the accelerated frame of the glass.

use super::kernel::Kernel;
use super::neighbours::{Neighbours, distance2};
use super::state::{Fluid, Particle};
use crate::offline::recording::Glass;
use rayon::prelude::*;

/// Continues pressure and velocity of the liquid to the wall particles.
pub(crate) fn extrapolate(
    kernel: &Kernel,
    lists: &Neighbours,
    liquid: &Fluid,
    g: [f64; 3],
    wall: &mut [Particle],
) {
    wall.par_iter_mut().enumerate().with_min_len(256).for_each(|(w, own)| {
        let x = own.x;
        let mut sum = [0.0; 5];
        for &f in lists.wall_liquid.row(w) {
            let p = &liquid.particle[f as usize];
            let weight = kernel.value(distance2(&x, &p.x));
            let lift = g[0] * (x[0] - p.x[0]) + g[1] * (x[1] - p.x[1]) + g[2] * (x[2] - p.x[2]);
            sum[0] += weight * (p.p + liquid.density[f as usize] * lift);
            sum[1] += weight * p.v[0];
            sum[2] += weight * p.v[1];
            sum[3] += weight * p.v[2];
            sum[4] += weight;
        }
        let inverse = if sum[4] > 0.0 { 1.0 / sum[4] } else { 0.0 };
        own.p = sum[0] * inverse;
        own.v = [-sum[1] * inverse, -sum[2] * inverse, -sum[3] * inverse];
    });
}

/// A particle this near to the wall, in spacings, moves no nearer; in rest it keeps about one half.
const NEAREST: f64 = 0.1;

/// Takes from particles at the wall the velocity into it, and books its energy as heat. The pressure
/// alone does this everywhere but in a thin splash, where there is too little of it.
pub(crate) fn hold(glass: &Glass, spacing_m: f64, liquid: &mut Fluid) {
    let (radius, bottom) = (glass.radius_m - NEAREST * spacing_m, NEAREST * spacing_m);
    for (p, heat) in liquid.particle.iter_mut().zip(&mut liquid.heat) {
        let r2 = p.x[0] * p.x[0] + p.x[1] * p.x[1];
        let outward = p.x[0] * p.v[0] + p.x[1] * p.v[1];
        if r2 > radius * radius && outward > 0.0 {
            *heat += 0.5 * outward * outward / r2;
            p.v[0] -= outward / r2 * p.x[0];
            p.v[1] -= outward / r2 * p.x[1];
        }
        if p.x[2] < bottom && p.v[2] < 0.0 {
            *heat += 0.5 * p.v[2] * p.v[2];
            p.v[2] = 0.0;
        }
    }
}
