//! The model linearised at the present state, as a controller takes it.
//!
//! ```text
//! x+ = next + A (x - x0) + B a + w,    <w w^T> = Q        a: acceleration of the glass in the step, m/s2
//! z  = z0 + C (x - x0) + D (a - a0)                       z: 21 heights, a0 the acceleration of this instant
//! ```
//! x0 is the corrected state and `next` the step from it without acceleration. A and B are the Jacobian of the GENERIC
//! step there, C and D the slopes of the decoder. Q is that of the filter: noise scale times w Q of the error model.
//!
//! The step bends within a few turns, so that for longer the model is linearised along a course x^ of accelerations a^:
//!
//! ```text
//! x_k+1 = x^_k+1 + A_k (x_k - x^_k) + B_k (a_k - a^_k)
//! z_k+1 = z^_k+1 + C_k+1 (x_k+1 - x^_k+1)                 without the inertial part, D a of that instant
//! ```

use crate::blob::Model;
use crate::latent::generic::LATENTS;
use crate::latent::linearisation::Linearisation;
use crate::runtime::Memory;
use crate::surface::POINTS;
use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

/// Rows of a matrix on latent space.
pub type LatentRows = [[f32; LATENTS]; LATENTS];

/// Linearised model.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::runtime::{LinearModel, Memory};
///
/// // At rest the next state is rest, and the surface lies at the fill height.
/// let linear = LinearModel::at(&model, &Memory::default());
/// assert!(linear.next.iter().all(|x| x.abs() < 1e-9));
/// assert!((f64::from(linear.heights_m[10]) - model.header.fill_m).abs() < 2e-3);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinearModel {
    /// Time of a step, s.
    pub dt_s: f64,
    /// x0.
    pub latent: [f64; LATENTS],
    /// State behind a step from x0 without acceleration.
    pub next: [f64; LATENTS],
    /// A, row by row.
    pub a: LatentRows,
    /// B, per m/s2.
    pub b: [f32; LATENTS],
    /// Q, row by row.
    pub q: LatentRows,
    /// Acceleration a0 at which `heights_m` stands, m/s2.
    pub acceleration_m_s2: f32,
    /// z0, m.
    pub heights_m: [f32; POINTS],
    /// C, one row a height, m.
    pub c: [[f32; LATENTS]; POINTS],
    /// D, m per m/s2.
    pub d: [f32; POINTS],
}

/// Step of the model linearised along a course.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinearStep {
    /// a^ of the step, m/s2.
    pub acceleration_m_s2: f32,
    /// x^ behind the step.
    pub latent: [f32; LATENTS],
    /// A of the step, row by row.
    pub a: LatentRows,
    /// B of the step, per m/s2.
    pub b: [f32; LATENTS],
    /// z^ behind the step, m.
    pub heights_m: [f32; POINTS],
    /// C behind the step, one row a height, m.
    pub c: [[f32; LATENTS]; POINTS],
}

impl LinearModel {
    /// Hands the steps of the course from `memory`'s state under `accelerations` (m/s2) to `visit`, each with its turn, from 1
    /// on.
    pub fn along(
        model: &Model<'_>,
        memory: &Memory,
        accelerations: &[f64],
        mut visit: impl FnMut(usize, &LinearStep),
    ) {
        let generic = &model.generic;
        let per_m_s2 = input_per_m_s2(model);
        let mut state = memory.state;
        for (turn, acceleration) in (1..).zip(accelerations) {
            let input = acceleration * per_m_s2;
            let jacobian = generic.jacobian(&state, input);
            generic.step(&mut state, input);
            let latent: [f64; LATENTS] = state.latent.into();
            let latent = latent.map(|x| x as f32);
            let surface = model.decoder.linearise(&latent, 0.0);
            visit(
                turn,
                &LinearStep {
                    acceleration_m_s2: *acceleration as f32,
                    latent,
                    a: rows(&jacobian.latent),
                    b: (jacobian.input * per_m_s2).map(|b| b as f32).into(),
                    heights_m: surface.heights_m,
                    c: slopes_of_heights(&surface),
                },
            );
        }
    }

    /// Returns the model of `memory`'s state after its last turn.
    #[must_use]
    pub fn at(model: &Model<'_>, memory: &Memory) -> Self {
        let generic = &model.generic;
        let per_m_s2 = input_per_m_s2(model);
        let state = memory.state;
        let mut next = state;
        generic.step(&mut next, 0.0);
        let jacobian = generic.jacobian(&state, 0.0);
        let covariance = memory.filter.covariance();
        let noise =
            covariance.process_noise_scale * model.error_model.weight(generic.potential.value(&state.latent));
        let latent: [f64; LATENTS] = state.latent.into();
        let input = memory.filter.input();
        let surface = model.decoder.linearise(&latent.map(|x| x as f32), input as f32);
        Self {
            dt_s: generic.dt_s,
            latent,
            next: next.latent.into(),
            a: rows(&jacobian.latent),
            b: (jacobian.input * per_m_s2).map(|b| b as f32).into(),
            q: rows(&(model.error_model.process * noise)),
            acceleration_m_s2: (input / per_m_s2) as f32,
            heights_m: surface.heights_m,
            c: slopes_of_heights(&surface),
            d: surface.input_slopes_m.map(|d| (f64::from(d) * per_m_s2) as f32),
        }
    }
}

/// Port value of a stated acceleration of 1 m/s2.
fn input_per_m_s2(model: &Model<'_>) -> f64 {
    let gain = model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
    gain / f64::from(model.header.acceleration_scale)
}

/// Slopes of the heights, one row a height.
fn slopes_of_heights(surface: &Linearisation) -> [[f32; LATENTS]; POINTS] {
    let mut rows = [[0.0; LATENTS]; POINTS];
    for (column, slopes) in surface.latent_slopes_m.iter().enumerate() {
        for (row, slope) in rows.iter_mut().zip(slopes) {
            if let Some(slot) = row.get_mut(column) {
                *slot = *slope;
            }
        }
    }
    rows
}

/// Rows of a matrix in single precision.
fn rows(matrix: &SMatrix<f64, LATENTS, LATENTS>) -> LatentRows {
    // Columns of the transpose are rows.
    matrix.transpose().data.0.map(|row| row.map(|value| value as f32))
}
