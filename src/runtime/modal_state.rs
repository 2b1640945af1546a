//! First modes of the surface with their covariance: the state that a controller of the slosh works on.
//!
//! ```text
//! z(s) = sum_k a_k cos(k t),  cos t = s = x / R       heights along the wall that the camera sees
//! a = M z = M (z0 + C dx + D du)                      M: least squares on k = 0 .. 3; a_1 and a_2 are kept
//! a' = M C (F grad H(x) + B u)                        without the change of the input, which is not known
//! cov = (k / 1.645)^2 T P T^T + misfit                T = [M C, M D; M C F H'', M C B], P of latents and input
//! ```
//! k is the conformal factor of the surface ([`crate::uncertainty::intervals`]), 1.645 the 90 % quantile of a normal error.
//! The misfit is that of the decoder and of a surface at rest, w d + g^2, taken as one error along the wall; in the rates it
//! counts with the frequency of the mode. Radial modes of one azimuth stand alike on the wall, and are one number here.
//! Across the line the cross-axis mode has one amplitude; the model knows no more of it.

use crate::blob::Model;
use crate::latent::generic::{LATENTS, Latent};
use crate::math::sqrt;
use crate::runtime::Memory;
use crate::surface::{POINTS, profile_abscissa};
use crate::units::GRAVITY_M_S2;
use nalgebra::{Matrix2, SVector};
use serde::{Deserialize, Serialize};

/// Modes along the line: azimuths 1 and 2.
pub const MODES_ALONG: usize = 2;

/// Numbers of their state: amplitudes, then rates.
pub const ALONG_STATES: usize = 2 * MODES_ALONG;

/// 90 % quantile of the size of a standard normal error.
const QUANTILE_90: f64 = 1.645;

/// First roots of J1' and J2', of which the frequencies of the modes follow (Ibrahim, Liquid Sloshing Dynamics, 2005).
const ROOTS: [f64; MODES_ALONG] = [1.841_184, 3.054_237];

/// Latents, then the input.
type Inputs = SVector<f64, { LATENTS + 1 }>;

/// Amplitude of a mode at the wall and its rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModeState {
    /// Amplitude, m.
    pub amplitude_m: f32,
    /// Its rate, m/s.
    pub rate_m_s: f32,
}

/// Modal state of the surface.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{Memory, ModalState};
///
/// // Before the first frame the liquid is taken to be at rest, and next to nothing is known.
/// let state = ModalState::of(&model, &Memory::default());
/// assert!(state.along[0].amplitude_m.abs() < 1e-3 && state.along_covariance[0][0] > 1e-6);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModalState {
    /// Modes of azimuth 1 and 2 along the line of motion.
    pub along: [ModeState; MODES_ALONG],
    /// Covariance of both amplitudes (m) and both rates (m/s).
    pub along_covariance: [[f32; ALONG_STATES]; ALONG_STATES],
    /// Mode of azimuth 1 across the line; `None` where the model has none.
    pub across: Option<ModeState>,
    /// Covariance of its amplitude and its rate.
    pub across_covariance: [[f32; 2]; 2],
}

impl ModalState {
    /// Returns the modal state of `memory` after its last turn.
    #[must_use]
    pub fn of(model: &Model<'_>, memory: &Memory) -> Self {
        let [surface_k, ..] = model.error_model.factors.surface;
        let scale = f64::from(surface_k) / QUANTILE_90;
        let latent: [f64; LATENTS] = memory.state.latent.into();
        let input = memory.filter.input();
        let surface = model.decoder.linearise(&latent.map(|x| x as f32), input as f32);
        let (rate, rate_slope) = model.generic.rate(&memory.state, input);
        let weight = model.error_model.weight(model.generic.potential.value(&memory.state.latent));
        let mut along = [ModeState::default(); MODES_ALONG];
        let (mut amplitudes, mut rates) = ([Inputs::zeros(); MODES_ALONG], [Inputs::zeros(); MODES_ALONG]);
        let mut misfits = [0.0; MODES_ALONG];
        let places = along.iter_mut().zip(amplitudes.iter_mut().zip(&mut rates)).zip(&mut misfits);
        for (((mode, (amplitude, rated)), misfit), row) in places.zip(azimuths()) {
            let along_latents =
                Latent::from_fn(|i, _| surface.latent_slopes_m.get(i).map_or(0.0, |z| project(&row, z)));
            *amplitude = join(&along_latents, project(&row, &surface.input_slopes_m));
            *rated = join(&rate_slope.tr_mul(&along_latents), along_latents.dot(&model.generic.port));
            mode.amplitude_m = project(&row, &surface.heights_m) as f32;
            mode.rate_m_s = along_latents.dot(&rate) as f32;
            *misfit = misfit_m2(model, &row, weight);
        }
        // omega^2 = g xi / R: a glass is deep for its modes.
        let rate_misfits = ROOTS.map(|root| GRAVITY_M_S2 * root / model.header.radius_m);
        let ([m1, m2], [w1, w2]) = (misfits, rate_misfits);
        let own = [m1, m2, w1 * m1, w2 * m2];
        let ([c1, c2], [r1, r2]) = (amplitudes, rates);
        let slopes = [c1, c2, r1, r2];
        let joint = memory.filter.latents_and_input() * (scale * scale);
        let mut along_covariance = [[0.0; ALONG_STATES]; ALONG_STATES];
        for (i, ((row, left), own)) in along_covariance.iter_mut().zip(&slopes).zip(own).enumerate() {
            let carried = joint * left;
            for (j, (slot, right)) in row.iter_mut().zip(&slopes).enumerate() {
                *slot = (carried.dot(right) + if i == j { own } else { 0.0 }) as f32;
            }
        }
        let (across, across_covariance) = across(model, memory, scale);
        Self { along, along_covariance, across, across_covariance }
    }
}

/// State of the cross-axis mode: its rate is the central difference of the recursion, (Y(n+1) - Y(n-1)) / 2 dt.
fn across(model: &Model<'_>, memory: &Memory, scale: f64) -> (Option<ModeState>, [[f32; 2]; 2]) {
    let [k1, k2] = model.cross_axis.recursion;
    if k1 == 0.0 && k2 == 0.0 {
        return (None, [[0.0; 2]; 2]);
    }
    let lateral = memory.filter.lateral(model);
    let per_turn = 0.5 / model.generic.dt_s;
    let map = Matrix2::new(1.0, 0.0, k1 * per_turn, (k2 - 1.0) * per_turn);
    let [now, before] = lateral.amplitude_m;
    let state = map * SVector::<f64, 2>::new(now, before);
    let covariance = map * lateral.covariance * map.transpose() * (scale * scale);
    let mode = ModeState { amplitude_m: state.x as f32, rate_m_s: state.y as f32 };
    (Some(mode), covariance.transpose().data.0.map(|row| row.map(|value| value as f32)))
}

/// M w d M^T of the row of a mode, with w d + g^2 as one error along the wall, m2.
fn misfit_m2(model: &Model<'_>, row: &[f64; POINTS], weight: f64) -> f64 {
    let rest = f64::from(model.error_model.factors.rest_noise_std_m);
    let [surface_k, ..] = model.error_model.factors.surface;
    let scale = f64::from(surface_k) / QUANTILE_90;
    let errors = row.iter().zip(model.error_model.surface_misfit);
    let std: f64 =
        errors.map(|(m, d)| m.abs() * scale * sqrt((weight * f64::from(*d)).max(0.0) + rest * rest)).sum();
    std * std
}

/// Joins slopes in the latents and in the input.
fn join(latents: &Latent, input: f64) -> Inputs {
    Inputs::from_fn(|i, _| latents.get(i).copied().unwrap_or(input))
}

/// Returns the product of a row of M and 21 heights.
fn project(row: &[f64; POINTS], heights: &[f32; POINTS]) -> f64 {
    row.iter().zip(heights).map(|(m, z)| m * f64::from(*z)).sum()
}

/// Rows of M for a_1 and a_2. Even and odd azimuths are orthogonal on the symmetric points, so that each is a fit of two.
fn azimuths() -> [[f64; POINTS]; MODES_ALONG] {
    let of = |k: usize, s: f64| match k {
        0 => 1.0,
        1 => s,
        2 => 2.0 * s * s - 1.0,
        _ => (4.0 * s * s - 3.0) * s,
    };
    let row = |wanted: usize, other: usize| {
        let (mut p, mut q, mut r) = (0.0, 0.0, 0.0);
        for index in 0..POINTS {
            let s = profile_abscissa(index);
            let (f, g) = (of(wanted, s), of(other, s));
            p += f * f;
            q += f * g;
            r += g * g;
        }
        let determinant = p * r - q * q;
        core::array::from_fn(|index| {
            let s = profile_abscissa(index);
            (r * of(wanted, s) - q * of(other, s)) / determinant
        })
    };
    [row(1, 3), row(2, 0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_of_azimuths_are_distinguished() {
        let rows = azimuths();
        for (a1, a2) in [(0.004, 0.0), (0.0, -0.002), (0.003, 0.001)] {
            let heights = core::array::from_fn(|index| {
                let s = profile_abscissa(index);
                (0.07 + a1 * s + a2 * (2.0 * s * s - 1.0)) as f32
            });
            let [is1, is2] = rows.map(|row| project(&row, &heights));
            assert!((is1 - a1).abs() < 1e-7 && (is2 - a2).abs() < 1e-7, "{is1} {is2}");
        }
    }
}
