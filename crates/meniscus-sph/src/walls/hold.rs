//! Last resort at the wall: a particle that the pressure does not stop loses its velocity into the wall.

use crate::particles::{Fluid, Particle};
use meniscus_data::recording::Glass;

/// A particle this near to the wall, in spacings, moves no nearer; in rest it keeps about one half.
const NEAREST: f64 = 0.1;

/// Takes from particles at the wall the velocity into it, and books its energy as heat. The pressure
/// alone does this everywhere but in a thin splash, where there is too little of it.
pub(crate) fn hold(glass: &Glass, spacing_m: f64, liquid: &mut Fluid) {
    let bottom = NEAREST * spacing_m;
    let below = |p: &&mut Particle| p.x[2] <= glass.rim_m;
    for (p, heat) in liquid.particle.iter_mut().zip(&mut liquid.heat).filter(|(p, _)| below(p)) {
        let radius = glass.radius_at(p.x[2]) - NEAREST * spacing_m;
        let r2 = p.x[0] * p.x[0] + p.x[1] * p.x[1];
        if r2 > radius * radius {
            // Outwards from a cone r = r0 + taper z: (x, y, -taper r).
            let down = glass.taper * r2.sqrt();
            let n2 = r2 * (1.0 + glass.taper * glass.taper);
            let outward = p.x[0] * p.v[0] + p.x[1] * p.v[1] - down * p.v[2];
            if outward > 0.0 {
                *heat += 0.5 * outward * outward / n2;
                p.v[0] -= outward / n2 * p.x[0];
                p.v[1] -= outward / n2 * p.x[1];
                p.v[2] += outward / n2 * down;
            }
        }
        if p.x[2] < bottom && p.v[2] < 0.0 {
            *heat += 0.5 * p.v[2] * p.v[2];
            p.v[2] = 0.0;
        }
    }
}
