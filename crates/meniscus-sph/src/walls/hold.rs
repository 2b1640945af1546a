//! Last resort at the wall: a particle that the pressure does not stop loses its velocity into the wall.

use crate::particles::Particle;
use meniscus_data::glass::{Glass, Side};

/// A particle this near to the wall, in spacings, moves no nearer; in rest it keeps about one half.
const NEAREST: f64 = 0.1;

/// Takes from a particle at the wall the velocity into it, and books its energy in its `heat`, J/kg. The pressure
/// alone does this everywhere but in a thin splash, where there is too little of it.
pub(crate) fn hold(glass: &Glass, spacing_m: f64, p: &mut Particle, heat: &mut f64) {
    if p.x[2] > glass.rim_m {
        return;
    }
    let nearest = NEAREST * spacing_m;
    if let Some(Side { normal, .. }) = glass.side_within(&p.x, nearest) {
        let outward: f64 = normal.iter().zip(p.v).map(|(n, v)| n * v).sum();
        if outward > 0.0 {
            *heat += 0.5 * outward * outward;
            for (v, n) in p.v.iter_mut().zip(normal) {
                *v -= outward * n;
            }
        }
    }
    if p.x[2] < nearest && p.v[2] < 0.0 {
        *heat += 0.5 * p.v[2] * p.v[2];
        p.v[2] = 0.0;
    }
}
