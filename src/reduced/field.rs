//! From the modes to the liquid everywhere: the surface, and the velocity of potential flow.
//!
//! ```text
//! eta(r, theta) = sum a_n phi_n(r) cos theta + second order          (phi = 1 at the wall)
//! Phi = sum v_n cosh(kz)/(k sinh kh) phi_n(r) cos theta,   velocity = grad Phi,   z from the bottom
//! ```

use super::model::ReducedModel;
use super::modes::{RADIAL, SloshMode, Wave};
use super::step::ReducedState;
use crate::math::{bessel_j, cosh, sinh, sqrt};

/// Height of the surface over rest at `(x, y)` in the glass, m; `push` is the specific force along x and
/// y, which the modes left out follow at once.
///
/// ```
/// use meniscus::reduced::{Baseline, Cylinder, ReducedModel, ReducedState, Rheology, surface};
///
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
/// let glycerine = Rheology::newtonian(0.95);
/// let model = ReducedModel::new(glass, glycerine, &Baseline::default(), &[], 1.0 / 60.0);
/// // The first mode along x, 5 mm high at the wall: up on one side, down on the other.
/// let mut state = ReducedState::default();
/// state.height[0][0] = 0.005;
/// let at = |x: f64| surface(&model, &state, &[0.0; 2], x, 0.0);
/// assert!((at(0.035) - 0.005).abs() < 1e-9 && (at(-0.035) + 0.005).abs() < 1e-9);
/// assert!(at(0.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn surface(model: &ReducedModel, state: &ReducedState, push: &[f64; 2], x: f64, y: f64) -> f64 {
    let r = sqrt(x * x + y * y).max(1e-12);
    let (cos, sin) = (x / r, y / r);
    let mut height = 0.0;
    for (i, ready) in model.modes.iter().enumerate() {
        let shape = bessel_j(1, ready.mode.k * r) / bessel_j(1, ready.mode.xi);
        let pair = state.height[0].get(i).zip(state.height[1].get(i));
        height += pair.map_or(0.0, |(a, b)| shape * (a * cos + b * sin));
    }
    let share = r / model.glass.radius_m * model.residual_lever_m() / crate::units::GRAVITY_M_S2;
    height += share * (push[0] * cos + push[1] * sin);
    let [ring, along, across] = &state.bound_waves.height;
    let turned = [1.0, cos * cos - sin * sin, 2.0 * sin * cos];
    for n in 0..RADIAL {
        for (wave, heights, turn) in [
            (Wave::Ring(n), ring, turned[0]),
            (Wave::Saddle(n), along, turned[1]),
            (Wave::Saddle(n), across, turned[2]),
        ] {
            let (order, xi) = wave.order();
            let shape = bessel_j(order, xi / model.glass.radius_m * r) / bessel_j(order, xi);
            height += heights.get(n).map_or(0.0, |s| shape * turn * s);
        }
    }
    height
}

/// Heights along the wall as harmonics of the azimuth, m: mean, cos, sin, cos 2, sin 2.
///
/// ```
/// use meniscus::reduced::{Baseline, Cylinder, ReducedModel, ReducedState, Rheology, wall_harmonics};
///
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
/// let glycerine = Rheology::newtonian(0.95);
/// let model = ReducedModel::new(glass, glycerine, &Baseline::default(), &[], 1.0 / 60.0);
/// let mut state = ReducedState::default();
/// state.height[1] = [0.005, -0.001, 0.0];
/// // Along the wall all radial modes add up; a wave along y has the azimuth's sine.
/// let [mean, cos, sin, cos2, sin2] = wall_harmonics(&model, &state, &[0.0; 2]);
/// assert!((sin - 0.004).abs() < 1e-12);
/// assert_eq!([mean, cos, cos2, sin2], [0.0; 4]);
/// ```
#[must_use]
pub fn wall_harmonics(model: &ReducedModel, state: &ReducedState, push: &[f64; 2]) -> [f64; 5] {
    let at_once = model.residual_lever_m() / crate::units::GRAVITY_M_S2;
    let [mean, cos2, sin2] = state.bound_waves.height.map(|row| row.iter().sum());
    let along = |d: usize| state.height[d].iter().sum::<f64>();
    [mean, along(0) + at_once * push[0], along(1) + at_once * push[1], cos2, sin2]
}

/// Velocity of the liquid at `(x, y, z)` in the glass, z from the bottom, m/s: first order.
///
/// ```
/// use meniscus::reduced::{Baseline, Cylinder, ReducedModel, ReducedState, Rheology, velocity};
///
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
/// let glycerine = Rheology::newtonian(0.95);
/// let model = ReducedModel::new(glass, glycerine, &Baseline::default(), &[], 1.0 / 60.0);
/// let mut state = ReducedState::default();
/// state.rate[0][0] = 0.1;
/// // At the wall the surface rises as fast as the liquid below it; at the bottom nothing moves up or down.
/// let [_, _, up] = velocity(&model, &state, [0.035, 0.0, 0.07]);
/// assert!((up - 0.1).abs() < 1e-9);
/// let [along, _, up] = velocity(&model, &state, [0.01, 0.0, 0.0]);
/// assert!(along > 0.0 && up == 0.0);
/// ```
#[must_use]
pub fn velocity(model: &ReducedModel, state: &ReducedState, point_m: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = point_m;
    let r = sqrt(x * x + y * y).max(1e-9);
    let (cos, sin) = (x / r, y / r);
    let mut out = [0.0; 3];
    for (i, ready) in model.modes.iter().enumerate() {
        let SloshMode { k, xi, .. } = ready.mode;
        let wall = bessel_j(1, xi);
        let over = bessel_j(1, k * r) / (k * r);
        let slope = bessel_j(0, k * r) - over;
        let depth = k * model.glass.depth_m;
        let (flat, up) = (cosh(k * z) / sinh(depth), sinh(k * z) / sinh(depth));
        let Some((vx, vy)) = state.rate[0].get(i).zip(state.rate[1].get(i)) else { continue };
        let (along, across) = (vx * cos + vy * sin, vy * cos - vx * sin);
        let (radial, around) = (flat * slope / wall * along, flat * over / wall * across);
        out[0] += radial * cos - around * sin;
        out[1] += radial * sin + around * cos;
        out[2] += up * bessel_j(1, k * r) / wall * along;
    }
    out
}
