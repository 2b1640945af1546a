//! Heights of the free surface as smooth sums over the particles, and the forces that belong to them.
//!
//! Over the cross-section A, with polynomials `psi_j = (r/R)^(m+2k) cos/sin m phi` up to degree 5 and
//! `V_i = m_i/rho0`, the volume of liquid under a surface of height `eta` weighs
//! ```text
//! M_j = sum_i V_i psi_j(x_i, y_i) = int psi_j eta dA,     eta = sum_j c_j psi_j,   c = G^-1 (M - M_rest)
//! ```
//! with `G_jl = int psi_j psi_l dA`. No surface has to be found. Whatever acts on the surface by
//! generalised forces `q_j = dE/dc_j` (or friction of that form) acts on the particles by virtual work:
//! ```text
//! m_i a_i = -V_i grad p_s(x_i, y_i),     p_s = sum_j psi_j (G^-1 q)_j
//! ```
//! a horizontal body force with a potential, which in a liquid of constant density is the same as the
//! pressure `p_s` on its free surface. Energy is thus exchanged without loss: `sum v_i.m_i a_i = -q.c'`.
//! Within a step `c'` answers to `q` by `-B q dt` with the mobility
//! ```text
//! B = G^-1 [ sum_i V_i/rho0 grad psi.grad psi ] G^-1
//! ```
//! which stiff friction needs for its implicit step. Higher degrees see more of the grain than of waves.

use crate::particles::{Fluid, Particle};
use nalgebra::{DMatrix, SMatrix, SVector};
use rayon::prelude::*;

/// Degree of the polynomials.
pub(super) const DEGREE: usize = 5;

/// Number of polynomials, `(d + 1)(d + 2)/2`.
pub(super) const COUNT: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// From generalised forces to rates, or the like.
pub(super) type Square = SMatrix<f64, COUNT, COUNT>;

/// One number for each polynomial.
pub(super) type Coefficients = SVector<f64, COUNT>;

/// One polynomial's value and slope along x and y (1/m).
pub(super) type Value = [f64; 3];

/// Every polynomial at `(x, y)` in a circle of radius `radius_m`.
pub(super) fn basis(x: f64, y: f64, radius_m: f64) -> [Value; COUNT] {
    let (x, y, over) = (x / radius_m, y / radius_m, 1.0 / radius_m);
    let r2 = x * x + y * y;
    let mut out = [[0.0; 3]; COUNT];
    let mut slots = out.iter_mut();
    // (x + i y)^m and its predecessor.
    let (mut power, mut before) = ([1.0, 0.0], [0.0, 0.0]);
    for m in 0..=DEGREE {
        let order = m as f64;
        let (mut ring, mut inner) = (1.0, 0.0);
        for k in 0..=(DEGREE - m) / 2 {
            // d(r^2k)/dx = 2 k x r^(2k-2); d(x + i y)^m/dx = m (x + i y)^(m-1), by y the same times i.
            let turn = 2.0 * k as f64 * inner;
            let cosine = [
                ring * power[0],
                over * (turn * x * power[0] + ring * order * before[0]),
                over * (turn * y * power[0] - ring * order * before[1]),
            ];
            let sine = [
                ring * power[1],
                over * (turn * x * power[1] + ring * order * before[1]),
                over * (turn * y * power[1] + ring * order * before[0]),
            ];
            for (part, slot) in [cosine, sine].iter().take(1 + m.min(1)).zip(slots.by_ref()) {
                *slot = *part;
            }
            inner = ring;
            ring *= r2;
        }
        before = power;
        power = [power[0] * x - power[1] * y, power[1] * x + power[0] * y];
    }
    out
}

/// The surface as the particles have it.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    radius_m: f64,
    rest_density: f64,
    /// `G^-1`.
    inverse: Square,
    /// `B`, m/s per N s.
    pub(super) mobility: Square,
    rest: Coefficients,
    /// Deflection from rest, m.
    pub(super) height: Coefficients,
    /// Its rate, m/s.
    pub(super) rate: Coefficients,
}

impl Columns {
    /// The columns of a liquid at rest, with the polynomials up to `degree` alone; `None` where they are
    /// not independent.
    pub(super) fn new(radius_m: f64, rest_density: f64, fluid: &Fluid, degree: usize) -> Option<Self> {
        // The degree and the azimuthal number (cosine m >= 0, sine -m) of each polynomial, in order.
        let mut kinds = Vec::new();
        for m in 0..=DEGREE as i32 {
            for k in 0..=(DEGREE as i32 - m) / 2 {
                kinds.push((m + 2 * k, m));
                if m > 0 {
                    kinds.push((m + 2 * k, -m));
                }
            }
        }
        let left = |i: usize| kinds[i].0 as usize > degree;
        // int r^(a+b) cos^2 m phi dA over the unit circle = (2 pi or pi)/(a + b + 2).
        let gram = DMatrix::from_fn(COUNT, COUNT, |i, j| {
            let ((a, m), (b, n)) = (kinds[i], kinds[j]);
            let angle = if m == 0 { std::f64::consts::TAU } else { std::f64::consts::PI };
            // Those left out stand alone, and are cut out of the inverse.
            match (m == n && left(i) == left(j), left(i)) {
                (true, false) => radius_m * radius_m * angle / f64::from(a + b + 2),
                _ => f64::from(u8::from(i == j)),
            }
        });
        let inverse = gram.try_inverse()?;
        let inverse = Square::from_fn(|i, j| if left(i) { 0.0 } else { inverse[(i, j)] });
        let mut inertia = Square::zeros();
        for (p, m) in fluid.particle.iter().zip(&fluid.mass) {
            let values = basis(p.x[0], p.x[1], radius_m);
            for axis in [1, 2] {
                let slope = Coefficients::from_fn(|j, _| values[j][axis]);
                inertia.ger(m / (rest_density * rest_density), &slope, &slope, 1.0);
            }
        }
        let zero = Coefficients::zeros();
        let mobility = inverse * inertia * inverse;
        let mut columns =
            Self { radius_m, rest_density, inverse, mobility, rest: zero, height: zero, rate: zero };
        columns.rest = columns.moments(fluid).0;
        Some(columns)
    }

    /// `M` and its rate.
    fn moments(&self, fluid: &Fluid) -> (Coefficients, Coefficients) {
        let (mut sum, mut rate) = (Coefficients::zeros(), Coefficients::zeros());
        for (p, m) in fluid.particle.iter().zip(&fluid.mass) {
            let volume = m / self.rest_density;
            let values = basis(p.x[0], p.x[1], self.radius_m);
            for ((value, sum), rate) in values.iter().zip(sum.iter_mut()).zip(rate.iter_mut()) {
                *sum += volume * value[0];
                *rate += volume * (value[1] * p.v[0] + value[2] * p.v[1]);
            }
        }
        (sum, rate)
    }

    /// Takes heights and rates of the present state.
    pub(super) fn follow(&mut self, fluid: &Fluid) {
        let (sum, rate) = self.moments(fluid);
        self.height = self.inverse * (sum - self.rest);
        self.rate = self.inverse * rate;
    }

    /// `p_s` under the generalised forces `q` (N), by its polynomials, Pa.
    pub(super) fn pressure(&self, q: &Coefficients) -> Coefficients {
        self.inverse * q
    }

    /// Fills `out` with `p_s` and the accelerations along x and y that stand for it.
    pub(super) fn push(&self, pressure: &Coefficients, fluid: &Fluid, out: &mut Vec<[f64; 3]>) {
        let at = |p: &Particle| {
            let mut sum = [0.0; 3];
            for (value, p_j) in basis(p.x[0], p.x[1], self.radius_m).iter().zip(pressure) {
                sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += p_j * value);
            }
            [sum[0], -sum[1] / self.rest_density, -sum[2] / self.rest_density]
        };
        fluid.particle.par_iter().with_min_len(128).map(at).collect_into_vec(out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_derivatives() {
        let (x, y, radius, h) = (0.011, -0.017, 0.035, 1e-7);
        let at = basis(x, y, radius);
        let [right, left, up, down] =
            [(x + h, y), (x - h, y), (x, y + h), (x, y - h)].map(|(x, y)| basis(x, y, radius));
        for j in 0..COUNT {
            let slope = [(right[j][0] - left[j][0]) / (2.0 * h), (up[j][0] - down[j][0]) / (2.0 * h)];
            assert!((at[j][1] - slope[0]).abs() + (at[j][2] - slope[1]).abs() < 1e-5, "{j}");
        }
        // The last but one is r^5 cos 5 phi.
        let angle = 5.0 * y.atan2(x);
        assert!((at[COUNT - 2][0] - (x.hypot(y) / radius).powi(5) * angle.cos()).abs() < 1e-12);
    }
}
