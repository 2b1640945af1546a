//! The first mode of a viscous liquid in an upright cylinder: the linearised Navier-Stokes equations
//! as an eigenvalue problem, solved by Ritz and Galerkin's method.
//!
//! For `u = (U cos a, V sin a, W cos a)` with azimuth `a`, the continuity equation gives `V` from `U`
//! and `W`, so that every velocity below is free of divergence and no pressure is needed:
//! ```text
//! V = -(r U)' - r W_z
//! int v.u_t  +  nu int 2 D(v):D(u)  +  g int_surface W_v eta = 0,      eta_t = W at z = h
//! u = x(t) in a basis,  x ~ e^(s t):     (s^2 M + s C + K) x = 0
//! ```
//! Zero stress at the surface, and zero shear stress at walls that slip, are natural conditions of
//! this form. Where the walls do not slip the velocity vanishes on them, hence the contact line is
//! pinned; where they slip it slides freely. The basis are products of Legendre polynomials in
//! `2 (r/R)^2 - 1` and `2 z/h - 1` with factors for axis, wall and bottom:
//! ```text
//!             U                      W
//! slip        (1 - (r/R)^2)          r z
//! no slip     (1 - (r/R)^2)^2 z      r z^2 (1 - (r/R)^2)
//! ```
//! The root nearest to the boundary-layer formula is found by inverse iteration with a Rayleigh
//! quotient. All numbers are made without dimension by `R` and `sqrt(g/R)`.

use super::jet::{Jet, gauss, legendre};
use super::theory::{Mode, Tone};
use crate::offline::prelude::*;
use crate::offline::recording::Glass;
use crate::units::GRAVITY_M_S2;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// Polynomials along the radius and along the height.
const DEGREES: (usize, usize) = (14, 19);

/// Nodes of the quadrature in each direction, enough to integrate every product exactly.
const NODES: usize = 42;

/// Turns with the first guess of the root before it is improved, and with the Rayleigh quotient.
const TURNS: (usize, usize) = (4, 6);

/// The three matrices of the eigenvalue problem and the surface's answer to a tilt.
struct Problem {
    mass: DMatrix<f64>,
    friction: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    tilt: DVector<f64>,
}

/// Frequency and decay of the first mode of a liquid of kinematic viscosity `nu` (m2/s) in `glass`;
/// `None` where the iteration finds no oscillation.
#[must_use]
pub fn viscous_mode(glass: &Glass, nu: f64, no_slip: bool) -> Option<Tone> {
    let rate = (GRAVITY_M_S2 / glass.radius_m).sqrt();
    let problem = Problem::new(glass.fill_m / glass.radius_m, nu / (glass.radius_m.powi(2) * rate), no_slip);
    let mode = Mode::first(*glass);
    let guess = Complex::new(-mode.layer_decay(nu), TAU * mode.hz()) / rate;
    let root = problem.root(guess)? * rate;
    (root.re.is_finite() && root.im > 0.0).then_some(Tone { hz: root.im / TAU, decay: -root.re })
}

/// The factors in r and z of one velocity: `U = a(r) b(z)` or `W = c(r) d(z)`.
#[derive(Clone, Copy)]
enum Shape {
    Radial(Jet, Jet),
    Vertical(Jet, Jet),
}

/// Every velocity of the basis at `(r, z)` in a cylinder of depth `h`.
fn basis(r: f64, z: f64, h: f64, no_slip: bool) -> Vec<Shape> {
    let (one, r, z) = (Jet::constant(1.0), Jet::variable(r), Jet::variable(z));
    let wall = one - r * r;
    let [a, b, c, d] = if no_slip { [wall * wall, z, r * wall, z * z] } else { [wall, one, r, z] };
    let (along_r, along_z) =
        (legendre(r * r * 2.0 - one, DEGREES.0), legendre(z * (2.0 / h) - one, DEGREES.1));
    let products = || along_r.iter().flat_map(|p| along_z.iter().map(move |q| (*p, *q)));
    let radial = products().map(|(p, q)| Shape::Radial(a * p, b * q));
    radial.chain(products().map(|(p, q)| Shape::Vertical(c * p, d * q))).collect()
}

/// `(U, V, W)` of a shape at radius `r`, and the six parts of `D` scaled so that their squares sum to
/// `2 D:D`: rr, aa, zz, ra, rz, az.
fn flow(shape: Shape, r: f64) -> ([f64; 3], [f64; 6]) {
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

impl Problem {
    fn new(h: f64, nu: f64, no_slip: bool) -> Self {
        let size = 2 * DEGREES.0 * DEGREES.1;
        let (radii, heights) = (gauss(NODES, 1.0), gauss(NODES, h));
        let mut velocity = DMatrix::zeros(3 * NODES * NODES, size);
        let mut strain = DMatrix::zeros(6 * NODES * NODES, size);
        let places = radii.iter().flat_map(|r| heights.iter().map(move |z| (*r, *z)));
        for (place, ((r, over_r), (z, over_z))) in places.enumerate() {
            let weight = (over_r * over_z * r).sqrt();
            for (column, shape) in basis(r, z, h, no_slip).into_iter().enumerate() {
                let (u, d) = flow(shape, r);
                for (k, u) in u.into_iter().enumerate() {
                    velocity[(3 * place + k, column)] = weight * u;
                }
                for (k, d) in d.into_iter().enumerate() {
                    strain[(6 * place + k, column)] = weight * d;
                }
            }
        }
        let mut surface = DMatrix::zeros(NODES, size);
        let mut tilt = DVector::zeros(size);
        for (row, (r, over_r)) in radii.into_iter().enumerate() {
            for (column, shape) in basis(r, h, h, no_slip).into_iter().enumerate() {
                let (u, _) = flow(shape, r);
                surface[(row, column)] = (over_r * r).sqrt() * u[2];
                tilt[column] += over_r * r * r * u[2];
            }
        }
        Self {
            mass: velocity.tr_mul(&velocity),
            friction: strain.tr_mul(&strain) * nu,
            stiffness: surface.tr_mul(&surface),
            tilt,
        }
    }

    /// `s^2 M + s C + K`.
    fn at(&self, s: Complex<f64>) -> DMatrix<Complex<f64>> {
        DMatrix::from_fn(self.mass.nrows(), self.mass.ncols(), |i, j| {
            s * s * self.mass[(i, j)] + s * self.friction[(i, j)] + self.stiffness[(i, j)]
        })
    }

    /// `2 s M + C`, its derivative by `s`.
    fn slope(&self, s: Complex<f64>) -> DMatrix<Complex<f64>> {
        DMatrix::from_fn(self.mass.nrows(), self.mass.ncols(), |i, j| {
            s * 2.0 * self.mass[(i, j)] + self.friction[(i, j)]
        })
    }

    /// The root near `s`, starting from the answer to a tilt of the glass.
    fn root(&self, mut s: Complex<f64>) -> Option<Complex<f64>> {
        let mut x = self.at(s).lu().solve(&self.tilt.map(|t| Complex::new(t, 0.0)))?;
        for turn in 0..TURNS.0 + TURNS.1 {
            x /= Complex::new(x.norm(), 0.0);
            let slope = self.slope(s);
            if turn >= TURNS.0 {
                // The matrices are symmetric, so that the left vector is the right one.
                s -= (x.transpose() * (self.at(s) * &x))[0] / (x.transpose() * (&slope * &x))[0];
            }
            x = self.at(s).lu().solve(&(slope * x))?;
        }
        Some(s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11 };

    #[test]
    fn it_has_the_inviscid_limit_and_the_known_numbers_of_glycerine() {
        let mode = Mode::first(GLASS);
        let thin = viscous_mode(&GLASS, 1e-7, false).expect("it oscillates");
        println!("{thin:?}");
        assert!((thin.hz / mode.hz() - 1.0).abs() < 1e-5);
        let nu = 0.950 / 1261.0;
        for (no_slip, hz, decay) in [(true, 3.399, 6.74), (false, 3.484, 2.96)] {
            let tone = viscous_mode(&GLASS, nu, no_slip).expect("it oscillates");
            println!("{tone:?} for {hz} {decay}");
            assert!(
                (tone.hz / hz - 1.0).abs() < 0.002 && (tone.decay / decay - 1.0).abs() < 0.01,
                "{tone:?}"
            );
        }
    }
}
