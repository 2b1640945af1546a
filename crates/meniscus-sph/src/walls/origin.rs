//! An image's original, and how the walls mirror it.

use meniscus_data::glass::{Glass, Side};

/// Original of an image, and the walls that mirror it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    pub(super) particle: u32,
    pub(super) side: bool,
    pub(super) bottom: bool,
}

impl Origin {
    /// The side wall that mirrors a particle at `x`. In a corner it stands upright on the edge of the bottom: mirrored there and at the
    /// bottom, a particle stands opposite behind the edge, whatever the angle. (Mirrored at a wall that leans, it would stand to one side
    /// of that: liquid in a cone that narrows by 0.1 then sank by 1.8 % of its height while it settled.)
    pub(super) fn wall(self, glass: &Glass, x: &[f64; 3]) -> Side {
        if !self.bottom {
            return glass.side(x);
        }
        let r = radius(x);
        Side { distance_m: glass.radius_m - r, normal: [x[0] / r, x[1] / r, 0.0], curvature: 0.0 }
    }

    /// The velocity `v` behind the walls that mirror it, the side wall with the outward normal `n`.
    pub(super) fn mirror(self, n: &[f64; 3], v: &[f64; 3]) -> [f64; 3] {
        let mut out = *v;
        if self.side {
            let normal: f64 = n.iter().zip(v).map(|(n, v)| n * v).sum();
            for (out, n) in out.iter_mut().zip(n) {
                *out -= 2.0 * normal * n;
            }
        }
        if self.bottom {
            out[2] = -out[2];
        }
        out
    }
}

/// Distance from the axis, m, and never nothing.
pub(super) fn radius(x: &[f64; 3]) -> f64 {
    (x[0] * x[0] + x[1] * x[1]).sqrt().max(1e-9)
}

/// Length of the wall's line behind the wall over that before it: `(1 + c y)/(1 - c y)`, between two circles about its centre.
pub(super) fn bulge(side: &Side) -> f64 {
    // Nearer to the centre than a tenth of the radius there is no image that means anything.
    let turn = (side.curvature * side.distance_m).clamp(-0.9, 0.9);
    (1.0 + turn) / (1.0 - turn)
}
