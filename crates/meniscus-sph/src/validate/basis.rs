//! Velocities of one azimuthal period in a cylinder, free of divergence, that keep to its walls.
//!
//! They are products of Legendre polynomials in `2 (r/R)^2 - 1` and `2 z/h - 1` with factors for axis, wall and bottom. The part around
//! the axis follows from continuity (see [`super::viscous`]):
//! ```text
//!             U                      W
//! slip        (1 - (r/R)^2)          r z
//! no slip     (1 - (r/R)^2)^2 z      r z^2 (1 - (r/R)^2)
//! ```

use super::jet::{Jet, legendre};

/// The factors in r and z of one velocity: `U = a(r) b(z)` or `W = c(r) d(z)`.
#[derive(Clone, Copy)]
pub(super) enum Shape {
    Radial(Jet, Jet),
    Vertical(Jet, Jet),
}

/// Every velocity of the basis at `(r, z)` in a cylinder of depth `h`.
pub(super) fn basis(r: f64, z: f64, h: f64, no_slip: bool, degrees: (usize, usize)) -> Vec<Shape> {
    let (one, r, z) = (Jet::constant(1.0), Jet::variable(r), Jet::variable(z));
    let wall = one - r * r;
    let [a, b, c, d] = if no_slip { [wall * wall, z, r * wall, z * z] } else { [wall, one, r, z] };
    let (along_r, along_z) =
        (legendre(r * r * 2.0 - one, degrees.0), legendre(z * (2.0 / h) - one, degrees.1));
    let products = || along_r.iter().flat_map(|p| along_z.iter().map(move |q| (*p, *q)));
    let radial = products().map(|(p, q)| Shape::Radial(a * p, b * q));
    radial.chain(products().map(|(p, q)| Shape::Vertical(c * p, d * q))).collect()
}

/// `(U, V, W)` of a shape at radius `r`, and the six parts of `D` scaled so that their squares sum to
/// `2 D:D`: rr, aa, zz, ra, rz, az.
pub(super) fn flow(shape: Shape, r: f64) -> ([f64; 3], [f64; 6]) {
    let root2 = std::f64::consts::SQRT_2;
    match shape {
        Shape::Radial(Jet([a, da, dda]), Jet([b, db, _])) => {
            let v = -(a + r * da) * b;
            let v_r = -(2.0 * da + r * dda) * b;
            let u = a * b;
            let hoop = (u + v) / r;
            ([u, v, 0.0], [root2 * da * b, root2 * hoop, 0.0, v_r - hoop, a * db, -(a + r * da) * db])
        }
        Shape::Vertical(Jet([c, dc, _]), Jet([d, dd, ddd])) => {
            let v = -r * c * dd;
            let v_r = -(c + r * dc) * dd;
            let rest = [v_r - v / r, dc * d, -r * c * ddd - c * d / r];
            ([0.0, v, c * d], [0.0, root2 * v / r, root2 * c * dd, rest[0], rest[1], rest[2]])
        }
    }
}
