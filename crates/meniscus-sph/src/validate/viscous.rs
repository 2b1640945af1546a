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
//! pinned; where they slip it slides freely. The functions of the basis are in [`super::basis`].
//!
//! Walls that slip by a length `b` (Navier 1823) add their friction to `C`; a Maxwell branch of modulus `G`
//! and time `lambda` makes the viscosity depend on `s`:
//! ```text
//! C  +=  (nu/b) int_walls u_t.v_t,             nu -> nu + (G/rho) lambda/(1 + s lambda)
//! ```
//! The root nearest to the boundary-layer formula is found by inverse iteration with a Rayleigh
//! quotient. All numbers are made without dimension by `R` and `sqrt(g/R)`.

use super::basis::{basis, flow};
use super::theory::{Mode, Tone};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::recording::Glass;
use meniscus_numerics::quadrature::gauss_legendre;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// Polynomials along the radius and along the height, and nodes of the quadrature in each direction,
/// enough to integrate every product exactly.
const FINE: Resolution = Resolution { degrees: (14, 19), nodes: 42 };

/// The same for fields that are integrated many times over; frequencies agree with the fine ones to 0.1 %.
pub(super) const COARSE: Resolution = Resolution { degrees: (9, 12), nodes: 28 };

/// Resolution of the velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Resolution {
    degrees: (usize, usize),
    nodes: usize,
}

/// A liquid in which small waves are linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear {
    /// Kinematic viscosity, m2/s.
    pub nu: f64,
    /// Slip length, m: 0 sticks, infinity slips freely.
    pub slip_m: f64,
    /// Modulus of a Maxwell branch over density, m2/s2, and its relaxation time, s.
    pub memory: Option<(f64, f64)>,
}

/// Turns with the first guess of the root before it is improved, and with the Rayleigh quotient.
const TURNS: (usize, usize) = (4, 6);

/// The three matrices of the eigenvalue problem, `C` for a unit of viscosity, and the surface's answer to
/// a tilt; all without dimension.
pub(super) struct Problem {
    pub(super) mass: DMatrix<f64>,
    friction: DMatrix<f64>,
    pub(super) stiffness: DMatrix<f64>,
    tilt: DVector<f64>,
    /// `(U, V, W)` of each node, times the square root of the node's weight.
    pub(super) velocity: DMatrix<f64>,
    /// Radius and height of each node, in radii.
    places: Vec<[f64; 2]>,
    /// Rows rr, aa, zz, ra, rz, az of each node, times the square root of the node's weight; and weights.
    pub(super) strain: DMatrix<f64>,
    pub(super) weights: Vec<f64>,
}

/// The viscosity at a rate `s`, without dimension.
#[derive(Clone, Copy, Debug)]
pub(super) struct Viscosity {
    pub(super) nu: f64,
    pub(super) memory: Option<(f64, f64)>,
}

impl Viscosity {
    /// The viscosity, and its derivative by `s`.
    fn at(&self, s: Complex<f64>) -> [Complex<f64>; 2] {
        let (modulus, time) = self.memory.unwrap_or((0.0, 0.0));
        let over = (Complex::new(1.0, 0.0) + s * time).inv();
        [over * (modulus * time) + self.nu, -over * over * (modulus * time * time)]
    }
}

/// Frequency and decay of the first mode of a liquid of kinematic viscosity `nu` (m2/s) in `glass`;
/// `None` where the iteration finds no oscillation.
#[must_use]
pub fn viscous_mode(glass: &Glass, nu: f64, no_slip: bool) -> Option<Tone> {
    let slip_m = if no_slip { 0.0 } else { f64::INFINITY };
    linear_mode(glass, &Linear { nu, slip_m, memory: None })
}

/// Frequency and decay of the first mode of `liquid` in `glass`; `None` where the iteration finds no
/// oscillation.
#[must_use]
pub fn linear_mode(glass: &Glass, liquid: &Linear) -> Option<Tone> {
    let (radius, rate) = (glass.radius_m, (GRAVITY_M_S2 / glass.radius_m).sqrt());
    let problem = Problem::new(glass.fill_m / radius, liquid.slip_m / radius, FINE);
    let viscosity = Viscosity {
        nu: liquid.nu / (radius * radius * rate),
        memory: liquid.memory.map(|(modulus, time)| (modulus / (radius * rate).powi(2), time * rate)),
    };
    let mode = Mode::first(*glass);
    let guess = Complex::new(-mode.layer_decay(liquid.nu), TAU * mode.hz()) / rate;
    let (root, _) = problem.root(guess, viscosity)?;
    let root = root * rate;
    (root.re.is_finite() && root.im > 0.0).then_some(Tone { hz: root.im / TAU, decay: -root.re })
}

impl Problem {
    /// The problem for a depth `h` and a slip length `slip`, in radii.
    pub(super) fn new(h: f64, slip: f64, resolution: Resolution) -> Self {
        let Resolution { degrees, nodes } = resolution;
        let no_slip = slip == 0.0;
        let size = 2 * degrees.0 * degrees.1;
        let (radii, heights) = (gauss_legendre(nodes, 1.0), gauss_legendre(nodes, h));
        let mut velocity = DMatrix::zeros(3 * nodes * nodes, size);
        let mut strain = DMatrix::zeros(6 * nodes * nodes, size);
        let mut weights = Vec::with_capacity(nodes * nodes);
        let mut places = Vec::with_capacity(nodes * nodes);
        let both = radii.iter().flat_map(|r| heights.iter().map(move |z| (*r, *z)));
        for (place, ((r, over_r), (z, over_z))) in both.enumerate() {
            places.push([r, z]);
            let weight = (over_r * over_z * r).sqrt();
            weights.push(weight * weight);
            for (column, shape) in basis(r, z, h, no_slip, degrees).into_iter().enumerate() {
                let (u, d) = flow(shape, r);
                for (k, u) in u.into_iter().enumerate() {
                    velocity[(3 * place + k, column)] = weight * u;
                }
                for (k, d) in d.into_iter().enumerate() {
                    strain[(6 * place + k, column)] = weight * d;
                }
            }
        }
        let mut surface = DMatrix::zeros(nodes, size);
        let mut tilt = DVector::zeros(size);
        for (row, &(r, over_r)) in radii.iter().enumerate() {
            for (column, shape) in basis(r, h, h, no_slip, degrees).into_iter().enumerate() {
                let (u, _) = flow(shape, r);
                surface[(row, column)] = (over_r * r).sqrt() * u[2];
                tilt[column] += over_r * r * r * u[2];
            }
        }
        let mut friction = strain.tr_mul(&strain);
        if slip > 0.0 && slip.is_finite() {
            // Tangential velocities on the side (V, W) and on the bottom (U, V).
            let side = heights.iter().map(|&(z, over)| (1.0, z, over, [1, 2]));
            let bottom = radii.iter().map(|&(r, over)| (r, 0.0, over * r, [0, 1]));
            let mut walls = DMatrix::zeros(4 * nodes, size);
            for (row, (r, z, weight, parts)) in side.chain(bottom).enumerate() {
                for (column, shape) in basis(r, z, h, false, degrees).into_iter().enumerate() {
                    let (u, _) = flow(shape, r);
                    for (k, part) in parts.into_iter().enumerate() {
                        walls[(2 * row + k, column)] = (weight / slip).sqrt() * u[part];
                    }
                }
            }
            friction += walls.tr_mul(&walls);
        }
        let (mass, stiffness) = (velocity.tr_mul(&velocity), surface.tr_mul(&surface));
        Self { mass, friction, stiffness, tilt, velocity, places, strain, weights }
    }

    /// A field `(U, V, W)` of radius and height (in radii) in the rows of `velocity`.
    pub(super) fn field(&self, at: impl Fn(f64, f64) -> [f64; 3]) -> DVector<f64> {
        let places = self.places.iter().zip(&self.weights);
        let rows = places.flat_map(|([r, z], weight)| at(*r, *z).map(|u| u * weight.sqrt()));
        DVector::from_iterator(self.velocity.nrows(), rows)
    }

    /// `s^2 M + s C(s) + K`.
    fn at(&self, s: Complex<f64>, viscosity: Viscosity) -> DMatrix<Complex<f64>> {
        let rub = s * viscosity.at(s)[0];
        DMatrix::from_fn(self.mass.nrows(), self.mass.ncols(), |i, j| {
            s * s * self.mass[(i, j)] + rub * self.friction[(i, j)] + self.stiffness[(i, j)]
        })
    }

    /// `2 s M + C + s C'`, its derivative by `s`.
    fn slope(&self, s: Complex<f64>, viscosity: Viscosity) -> DMatrix<Complex<f64>> {
        let [nu, growth] = viscosity.at(s);
        let rub = nu + s * growth;
        DMatrix::from_fn(self.mass.nrows(), self.mass.ncols(), |i, j| {
            s * 2.0 * self.mass[(i, j)] + rub * self.friction[(i, j)]
        })
    }

    /// The root near `s` and its mode, starting from the answer to a tilt of the glass.
    pub(super) fn root(
        &self,
        mut s: Complex<f64>,
        viscosity: Viscosity,
    ) -> Option<(Complex<f64>, DVector<Complex<f64>>)> {
        let mut x = self.at(s, viscosity).lu().solve(&self.tilt.map(|t| Complex::new(t, 0.0)))?;
        for turn in 0..TURNS.0 + TURNS.1 {
            x /= Complex::new(x.norm(), 0.0);
            let slope = self.slope(s, viscosity);
            if turn >= TURNS.0 {
                // The matrices are symmetric, so that the left vector is the right one.
                s -= (x.transpose() * (self.at(s, viscosity) * &x))[0] / (x.transpose() * (&slope * &x))[0];
            }
            x = self.at(s, viscosity).lu().solve(&(slope * x))?;
        }
        Some((s, x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::glass::WallShape;

    const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };

    #[test]
    fn slip_and_memory_have_their_limits() {
        let nu = 0.950 / 1261.0;
        let tone = |liquid: Linear| linear_mode(&GLASS, &liquid).expect("it oscillates");
        let free = tone(Linear { nu, slip_m: f64::INFINITY, memory: None });
        let nearly = tone(Linear { nu, slip_m: 10.0, memory: None });
        assert!((free.decay / nearly.decay - 1.0).abs() < 5e-3, "{free:?} {nearly:?}");
        let part = tone(Linear { nu, slip_m: 0.005, memory: None });
        let stuck = tone(Linear { nu, slip_m: 0.0, memory: None });
        assert!(part.decay > free.decay && part.decay < stuck.decay, "{part:?}");
        // A branch that forgets at once is a viscosity.
        let quick = tone(Linear { nu: 0.5 * nu, slip_m: 0.0, memory: Some((0.5 * nu / 1e-6, 1e-6)) });
        assert!((quick.decay / stuck.decay - 1.0).abs() < 1e-3 && (quick.hz / stuck.hz - 1.0).abs() < 1e-3);
    }

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
