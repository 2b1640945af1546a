//! The model linearised at the present state, as a controller takes it.
//!
//! ```text
//! x+ = next + A (x - x0) + B a + w,    <w w^T> = Q        a: acceleration of the glass in the step, m/s2
//! z  = z0 + C (x - x0) + D (a - a0)                       z: 21 heights, a0 the acceleration of this instant
//! ```
//! x0 is the corrected state and `next` the step from it without acceleration. A and B are the Jacobian of the GENERIC
//! step there, C and D the slopes of the decoder. Q is that of the filter: noise scale times w Q of the error model.

use crate::blob::Model;
use crate::latent::generic::LATENTS;
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

impl LinearModel {
    /// Returns the model of `memory`'s state after its last turn.
    #[must_use]
    pub fn at(model: &Model<'_>, memory: &Memory) -> Self {
        let generic = &model.generic;
        let per_m_s2 = 1.0 / f64::from(model.header.acceleration_scale);
        let gain = model.observation_model.as_ref().map_or(1.0, |observation_model| observation_model.gain);
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
        let mut c = [[0.0; LATENTS]; POINTS];
        for (column, slopes) in surface.latent_slopes_m.iter().enumerate() {
            for (row, slope) in c.iter_mut().zip(slopes) {
                if let Some(slot) = row.get_mut(column) {
                    *slot = *slope;
                }
            }
        }
        Self {
            dt_s: generic.dt_s,
            latent,
            next: next.latent.into(),
            a: rows(&jacobian.latent),
            b: (jacobian.input * (gain * per_m_s2)).map(|b| b as f32).into(),
            q: rows(&(model.error_model.process * noise)),
            acceleration_m_s2: (input / (gain * per_m_s2)) as f32,
            heights_m: surface.heights_m,
            c,
            d: surface.input_slopes_m.map(|d| (f64::from(d) * gain * per_m_s2) as f32),
        }
    }
}

/// Rows of a matrix in single precision.
fn rows(matrix: &SMatrix<f64, LATENTS, LATENTS>) -> LatentRows {
    // Columns of the transpose are rows.
    matrix.transpose().data.0.map(|row| row.map(|value| value as f32))
}
