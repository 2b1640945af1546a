//! The surface under a force along the wall: linear theory, in as many modes as the force excites.
//!
//! A line of force at the wall does not push the first mode alone: the surface gives way where it is pushed, the wall moves
//! less than the first mode would, and less is held or rubbed. A force that is not linear in the velocity pushes waves of
//! three periods around the wall, too. With `eta = sum_n a_n J_m(xi_n r/R)/J_m(xi_n) cos m phi`, `m` of 1 and 3,
//! `K_n = rho g pi R^2/2 (1 - m^2/xi_n^2)` and the velocity `v = sum_n b_n a_n' cos m phi` of the wall's surface
//! ```text
//! a_n'' = -w_n^2 a_n - 2 gamma_n a_n' - (w_n^2/K_n) b_n int f(v) cos m phi R dphi,      gamma_n = gamma_1 (xi_n/xi_1)^2
//! ```
//! The simulator's wall knows the surface by its least-squares fit in polynomials of degree 4; of odd m these are `r` and `r^3` times cos phi
//! and `r^3` times cos 3 phi, so that a mode whose height at the wall is 1 is known there by
//! ```text
//! b_n = sum_j (G^-1 M)_j,    M_j = int r^(p_j) J_m(xi_n r)/J_m(xi_n) r dr,    G_ij = 1/(p_i + p_j + 2)
//! ```
//! With b_n = 1 the first mode would feel ever less with the number of modes, because a surface without tension gives way
//! under a line of force without bound; with the fit a spring has settled to 1 part in 2000 at [`MODES`] modes.

use super::ring_down::{GLASS, GLYCERINE};
use meniscus::math::bessel_j;
use meniscus::units::GRAVITY_M_S2;
use meniscus_numerics::quadrature::gauss_legendre;
use nalgebra::{DMatrix, Matrix2, Vector2};
use std::f64::consts::{PI, TAU};

/// Radial modes of each azimuthal number.
const MODES: usize = 12;

/// Sectors of half the wall; the other half mirrors them.
const SECTORS: usize = 32;

/// Step of the integration, s: a hundredth of a radian of the fastest mode.
const STEP_S: f64 = 1e-4;

/// A mode: azimuthal number, zero of J_m', what the wall knows of it, `w^2` and `w^2/K`.
#[derive(Clone, Copy, Debug)]
struct Wave {
    order: i32,
    xi: f64,
    known: f64,
    square: f64,
    answer: f64,
}

/// The zero of J_m' near `x`, by Newton's method.
fn zero_of_slope(order: i32, mut x: f64) -> f64 {
    let m = f64::from(order);
    for _ in 0..8 {
        let slope = bessel_j(order - 1, x) - m * bessel_j(order, x) / x;
        // Bessel's equation.
        let bend = -slope / x - (1.0 - m * m / (x * x)) * bessel_j(order, x);
        x -= slope / bend;
    }
    x
}

/// The modes of azimuthal number `order`, 1 or 3, by frequency.
fn waves(order: i32) -> [Wave; MODES] {
    let m = f64::from(order);
    let nodes = gauss_legendre(48, 1.0);
    // Near the first zero (Abramowitz and Stegun 9.5.16); the others follow a little more than pi apart.
    let mut near = m + 0.81 * m.cbrt();
    std::array::from_fn(|n| {
        let xi = zero_of_slope(order, near);
        near = xi + if n == 0 { 3.65 } else { 3.25 };
        let shape = |r: f64| bessel_j(order, xi * r) / bessel_j(order, xi);
        let moment = |power: i32| nodes.iter().map(|(r, w)| w * r.powi(power + 1) * shape(*r)).sum::<f64>();
        let known = if order == 1 {
            let gram = Matrix2::new(1.0 / 4.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 8.0);
            gram.lu().solve(&Vector2::new(moment(1), moment(3))).map_or(f64::NAN, |fit| fit.sum())
        } else {
            8.0 * moment(3)
        };
        let k = xi / GLASS.radius_m;
        let square = GRAVITY_M_S2 * k * (k * GLASS.fill_m).tanh();
        let area = 0.5 * PI * GLASS.radius_m.powi(2) * (1.0 - (m / xi).powi(2));
        Wave { order, xi, known, square, answer: square / (GLYCERINE.0 * GRAVITY_M_S2 * area) }
    })
}

/// `w^2` of the first mode with a spring of `spring` N/m2 along the wall over without.
pub(super) fn sprung(spring: f64) -> f64 {
    let modes = waves(1);
    let matrix = DMatrix::from_fn(MODES, MODES, |i, j| {
        let (a, b) = (modes[i], modes[j]);
        let own = if i == j { a.square } else { 0.0 };
        own + spring * PI * GLASS.radius_m * a.known * b.known * (a.answer * b.answer).sqrt()
    });
    matrix.symmetric_eigenvalues().min() / modes[0].square
}

/// Rate of the first mode's height over its first value, every [`STEP_S`] for `seconds`, from `speed_m_s` at the wall with
/// the decay `gamma`, under the force per length `law(sector, velocity)` N/m, which may remember (it is asked once a step).
pub(super) fn rubbed(
    speed_m_s: f64,
    gamma: f64,
    seconds: f64,
    mut law: impl FnMut(usize, f64) -> f64,
) -> Vec<(f64, f64)> {
    let modes = [waves(1), waves(3)].concat();
    let turn = |k: usize| PI * (k as f64 + 0.5) / SECTORS as f64;
    let cosines: [[f64; 2]; SECTORS] = std::array::from_fn(|k| [turn(k).cos(), (3.0 * turn(k)).cos()]);
    let (mut height, mut rate) = ([0.0; 2 * MODES], [0.0; 2 * MODES]);
    rate[0] = speed_m_s;
    let steps = (seconds / STEP_S).ceil() as usize;
    let series = (0..steps).map(|step| {
        let told = (step as f64 * STEP_S, rate[0] / speed_m_s);
        let wall = |order: i32| {
            let parts = modes.iter().zip(&rate).filter(|(mode, _)| mode.order == order);
            parts.map(|(mode, rate)| mode.known * rate).sum::<f64>()
        };
        let (one, three) = (wall(1), wall(3));
        let mut force = [0.0; 2];
        for (s, [first, third]) in cosines.iter().enumerate() {
            let f = law(s, one * first + three * third) * TAU * GLASS.radius_m / SECTORS as f64;
            force[0] += f * first;
            force[1] += f * third;
        }
        for ((mode, height), rate) in modes.iter().zip(&mut height).zip(&mut rate) {
            let damping = 2.0 * gamma * (mode.xi / modes[0].xi).powi(2);
            // Semi-implicit Euler: of the energy it keeps all but the second order of the step.
            *rate = (*rate
                - STEP_S
                    * (mode.square * *height
                        + mode.answer * mode.known * force[usize::from(mode.order > 1)]))
                / (1.0 + STEP_S * damping);
            *height += STEP_S * *rate;
        }
        told
    });
    series.collect()
}

/// The law of a line that slides at `force` N/m after `reach_m` (Dahl 1968), for [`rubbed`].
pub(super) fn sliding(force: f64, reach_m: f64) -> impl FnMut(usize, f64) -> f64 {
    let mut z = [0.0; SECTORS];
    move |sector, v| {
        let z = &mut z[sector];
        *z = (*z + STEP_S * v) / (1.0 + STEP_S * v.abs() / reach_m);
        force / reach_m * *z
    }
}

/// The law of foam of the coefficient `beta` (see the simulator's effect), for [`rubbed`].
pub(super) fn foaming(beta: f64) -> impl FnMut(usize, f64) -> f64 {
    move |_, v| beta * v * (v * v + 1e-6).powf(-1.0 / 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spring_at_the_wall_raises_the_first_mode_as_settled_sums_have_it() {
        // 0.06524 from 20 modes by another program; one rigid mode would give 0.0983.
        let more = sprung(15.0) - 1.0;
        assert!((more - 0.0652).abs() < 1e-4, "{more}");
        // Abramowitz and Stegun, table 9.5.
        for (order, zeros) in [(1, [1.84118, 5.33144, 8.53632]), (3, [4.20119, 8.01524, 11.34592])] {
            for (found, known) in waves(order).iter().zip(zeros) {
                assert!((found.xi - known).abs() < 1e-5, "{}", found.xi);
            }
        }
    }

    #[test]
    fn a_weak_line_takes_what_the_first_mode_alone_would_lose() {
        // V' = -c with c = 8 F R b^... of one mode: 8 F R w^2/(pi K) times what the wall knows of it.
        let (force, speed) = (1e-5, 0.1);
        let first = waves(1)[0];
        let series = rubbed(speed, 0.0, 2.0, sliding(force, 1e-6));
        let peak = |from: f64, to: f64| {
            let inside = series.iter().filter(|(t, _)| (from..to).contains(t));
            inside.map(|(_, v)| speed * v.abs()).fold(0.0, f64::max)
        };
        let period = TAU / first.square.sqrt();
        let lost = peak(0.5 * period, period) - peak(5.5 * period, 6.0 * period);
        let c = 8.0 * force * GLASS.radius_m * first.answer / PI * first.known;
        let ratio = lost / (5.0 * period * c);
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    }

    #[test]
    fn a_spring_in_the_integration_has_the_frequency_of_the_matrix() {
        let spring = 15.0;
        let mut z = [0.0; SECTORS];
        let series = rubbed(0.1, 0.0, 3.0, |s, v| {
            z[s] += STEP_S * v;
            spring * z[s]
        });
        let crossings: Vec<f64> =
            series.windows(2).filter(|w| w[0].1 * w[1].1 < 0.0).map(|w| w[0].0).collect();
        // The other modes ripple on the first, so that single crossings jitter.
        let half = (crossings[20] - crossings[0]) / 20.0;
        let ratio = (PI / half).powi(2) / waves(1)[0].square;
        assert!((ratio / sprung(spring) - 1.0).abs() < 0.01, "{ratio} for {}", sprung(spring));
    }
}
