//! The surface under a force along the wall: linear theory, in as many modes as the simulator lets it act on.
//!
//! A line of force at the wall does not push the first mode alone: the surface gives way where it is pushed, the wall moves
//! less than the first mode would, and less is held or rubbed. A force that is not linear in the velocity pushes waves of
//! three, five and seven periods around the wall, too. With `eta = sum_n a_n J_m(xi_n r/R)/J_m(xi_n) cos m phi`, odd `m`,
//! `K_n = rho g pi R^2/2 (1 - m^2/xi_n^2)` and the velocity `v = sum_n a_n' cos m phi` of the wall's surface
//! ```text
//! a_n'' = -w_n^2 a_n - 2 gamma_n a_n' - (w_n^2/K_n) int f(v) cos m phi R dphi,      gamma_n = gamma_1 (xi_n/xi_1)^2
//! ```
//! A surface without tension gives way under a line of force without bound, by `2/(rho g R)` of it for each radial mode. The
//! simulator's line acts on the modes of `effects::waves` and no others, and so it does here.

use super::ring_down::{GLASS, GLYCERINE};
use crate::effects::waves::{RADIAL, zeros};
use meniscus::units::GRAVITY_M_S2;
use nalgebra::DMatrix;
use std::f64::consts::{PI, TAU};

/// Azimuthal numbers of the modes.
const ORDERS: [i32; 4] = [1, 3, 5, 7];

/// Sectors of half the wall; the other half mirrors them.
const SECTORS: usize = 32;

/// Step of the integration, s: a hundredth of a radian of the fastest mode.
const STEP_S: f64 = 1e-4;

/// A mode: place of its azimuthal number in [`ORDERS`], zero of J_m', `w^2` and `w^2/K`.
#[derive(Clone, Copy, Debug)]
struct Wave {
    order: usize,
    xi: f64,
    square: f64,
    answer: f64,
}

/// The modes of the azimuthal number `ORDERS[order]`, by frequency.
fn waves(order: usize) -> Vec<Wave> {
    let m = ORDERS[order];
    let wave = |xi: f64| {
        let k = xi / GLASS.radius_m;
        let square = GRAVITY_M_S2 * k * (k * GLASS.fill_m).tanh();
        let area = 0.5 * PI * GLASS.radius_m.powi(2) * (1.0 - (f64::from(m) / xi).powi(2));
        Wave { order, xi, square, answer: square / (GLYCERINE.0 * GRAVITY_M_S2 * area) }
    };
    zeros(m, RADIAL[m as usize]).into_iter().map(wave).collect()
}

/// `w^2` of the first mode with a spring of `spring` N/m2 along the wall over without.
pub(super) fn sprung(spring: f64) -> f64 {
    let modes = waves(0);
    let matrix = DMatrix::from_fn(modes.len(), modes.len(), |i, j| {
        let (a, b) = (modes[i], modes[j]);
        let own = if i == j { a.square } else { 0.0 };
        own + spring * PI * GLASS.radius_m * (a.answer * b.answer).sqrt()
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
    let modes: Vec<Wave> = (0..ORDERS.len()).flat_map(waves).collect();
    let turn = |k: usize| PI * (k as f64 + 0.5) / SECTORS as f64;
    let cosines: [[f64; ORDERS.len()]; SECTORS] =
        std::array::from_fn(|k| ORDERS.map(|m| (f64::from(m) * turn(k)).cos()));
    let (mut height, mut rate) = (vec![0.0; modes.len()], vec![0.0; modes.len()]);
    rate[0] = speed_m_s;
    let steps = (seconds / STEP_S).ceil() as usize;
    let series = (0..steps).map(|step| {
        let sample = (step as f64 * STEP_S, rate[0] / speed_m_s);
        let mut wall = [0.0; ORDERS.len()];
        modes.iter().zip(&rate).for_each(|(mode, rate)| wall[mode.order] += rate);
        let mut force = [0.0; ORDERS.len()];
        for (s, cosines) in cosines.iter().enumerate() {
            let v = wall.iter().zip(cosines).map(|(v, cosine)| v * cosine).sum();
            let f = law(s, v) * TAU * GLASS.radius_m / SECTORS as f64;
            force.iter_mut().zip(cosines).for_each(|(force, cosine)| *force += f * cosine);
        }
        for ((mode, height), rate) in modes.iter().zip(&mut height).zip(&mut rate) {
            let damping = 2.0 * gamma * (mode.xi / modes[0].xi).powi(2);
            // Semi-implicit Euler: of the energy it keeps all but the second order of the step.
            *rate = (*rate - STEP_S * (mode.square * *height + mode.answer * force[mode.order]))
                / (1.0 + STEP_S * damping);
            *height += STEP_S * *rate;
        }
        sample
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
        // 1 + 1/x_1 + 1/x_2 + 1/x_3 = 0 with x_n = (w_n^2 - W^2)/(s w_n^2/K_n), by bisection, in place of a matrix.
        let spring = 15.0 * PI * GLASS.radius_m;
        let modes = waves(0);
        let secular = |square: f64| {
            1.0 + modes.iter().map(|mode| spring * mode.answer / (mode.square - square)).sum::<f64>()
        };
        let (mut low, mut high) = (modes[0].square * (1.0 + 1e-9), modes[1].square * (1.0 - 1e-9));
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if secular(middle) < 0.0 { low = middle } else { high = middle }
        }
        assert!((sprung(15.0) * modes[0].square / low - 1.0).abs() < 1e-9, "{}", sprung(15.0));
        // One rigid mode alone would give this, and two radial modes that give way each take their part.
        let alone = spring * modes[0].answer / modes[0].square;
        assert!(sprung(15.0) - 1.0 < 0.9 * alone && sprung(15.0) - 1.0 > 0.7 * alone, "{}", sprung(15.0));
    }

    #[test]
    fn a_weak_line_takes_what_the_first_mode_alone_would_lose() {
        // V' = -c with c of one mode: 4 F R (4/pi)/2 w^2/K.
        let (force, speed) = (1e-5, 0.1);
        let first = waves(0)[0];
        let series = rubbed(speed, 0.0, 2.0, sliding(force, 1e-6));
        let peak = |from: f64, to: f64| {
            let inside = series.iter().filter(|(t, _)| (from..to).contains(t));
            inside.map(|(_, v)| speed * v.abs()).fold(0.0, f64::max)
        };
        let period = TAU / first.square.sqrt();
        let lost = peak(0.5 * period, period) - peak(5.5 * period, 6.0 * period);
        let c = 8.0 * force * GLASS.radius_m * first.answer / PI;
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
        let ratio = (PI / half).powi(2) / waves(0)[0].square;
        assert!((ratio / sprung(spring) - 1.0).abs() < 0.01, "{ratio} for {}", sprung(spring));
    }
}
