//! Blob taken apart into trainable weights and the rest, and put together again.

use super::{Correction, Sightings, known_after};
use crate::TrainError;
use crate::blob_text::fitting;
use crate::calibration::blob_parts as parts;
use crate::calibration::error_model::transition;
use crate::correct::parameters::ResidualParameters;
use crate::correct::residual_covariance::{FilterRun, ResidualCovariance};
use crate::correct::surface_decoder::SurfaceDecoder;
use crate::correct::trainable_model::{DYNAMICS, GAIN, GRU, HEAD};
use crate::correct::training_window::TrainingWindow;
use crate::operators::filter::settle;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::unrolled::{dynamics_of, rounded, weights_of};
use meniscus::blob::{BEFORE, Header, Model, Tensor as Name};
use meniscus::latent::encoder::GRU_LAYERS;
use meniscus::latent::generic::{FrictionLaw, Generic, LATENTS, Latent};
use meniscus_data::blob_file::{
    factors, read,
    write::{self, Part},
};
use meniscus_optim::weights::Matrix;

/// Blob taken apart into the weights that a correction changes and the rest.
pub(super) struct CheckpointParts {
    header: Header,
    parts: Vec<Part>,
    frozen: Vec<Matrix>,
    /// The surface of the decoder.
    pub(super) surface: SurfaceDecoder,
    /// Residuals of step and decoder on the source liquid.
    pub(super) residuals: ResidualCovariance,
    /// The floor of w.
    floor: f64,
    scale: meniscus::latent::window::Scale,
    /// Weights that Adam changes, in the order of `trainable_model`.
    pub(super) weights: Vec<Matrix>,
}

impl CheckpointParts {
    /// Takes `blob` apart.
    ///
    /// # Errors
    /// [`TrainError`], when it is refused.
    pub(super) fn new(blob: &[u8]) -> Result<Self, TrainError> {
        let (header, parts) = read::parts(blob)?;
        let scale = Model::load(blob)?.scale();
        // A loaded blob has every tensor.
        let missing = TrainError::Singular("the tensors of the blob");
        let part = |name: Name| parts.iter().find(|p| p.tensor == name).ok_or(missing.clone());
        let matrix = |name: Name| part(name).map(|p| Matrix::new(p.rows, p.columns, p.values.clone()));
        let row = |name: Name| part(name).map(|p| Matrix::new(1, p.rows, p.values.clone()));
        let mut frozen = Vec::new();
        let mut weights = Vec::new();
        for layer in 0..GRU_LAYERS as u8 {
            let into = if usize::from(layer) + 1 == GRU_LAYERS { &mut weights } else { &mut frozen };
            into.push(matrix(Name::GruInput(layer))?);
            into.push(matrix(Name::GruHidden(layer))?);
            into.push(row(Name::GruInputBias(layer))?);
            into.push(row(Name::GruHiddenBias(layer))?);
        }
        weights.push(matrix(Name::HeadWeight)?);
        weights.push(row(Name::HeadBias)?);
        let numbers =
            |name: Name| part(name).map(|p| p.values.iter().map(|&v| f64::from(v)).collect::<Vec<_>>());
        weights.push(matrix(Name::Gain)?);
        weights.extend(weights_of(&dynamics_from(&numbers, &matrix)?));
        let surface = SurfaceDecoder::new(&parts).ok_or(missing.clone())?;
        let residuals =
            ResidualCovariance::stated(&numbers(Name::ProcessSpread)?, &numbers(Name::SurfaceMisfit)?);
        let floor = f64::from(factors::of(&parts).ok_or(missing.clone())?.weight_floor);
        Ok(Self { header, frozen, surface, residuals, floor, scale, weights, parts })
    }

    /// Training window of a recording.
    pub(super) fn window(&self, seen: &Sightings) -> TrainingWindow {
        TrainingWindow::new(seen, &self.scale, &self.surface.rest, &self.frozen)
    }

    /// Residuals of step and decoder over `run` under `generic`, the step of a candidate.
    pub(super) fn measured_residuals(
        &self,
        generic: &Generic<'_>,
        run: &FilterRun<'_>,
        parameters: &ResidualParameters,
    ) -> ResidualCovariance {
        self.residuals.measured(generic, &self.surface, self.floor, run, parameters)
    }

    /// The blob with `weights` and `residuals` in the place of what was there.
    ///
    /// # Errors
    /// [`TrainError`], when a weight is not finite.
    pub(super) fn blob(
        &self,
        weights: &[Matrix],
        residuals: &ResidualCovariance,
        how: &Correction,
    ) -> Result<Vec<u8>, TrainError> {
        let mut parts = self.parts.clone();
        let mut put = |name: Name, values: Vec<f32>| {
            if let Some(part) = parts.iter_mut().find(|part| part.tensor == name) {
                part.values = values;
            }
        };
        let last = GRU_LAYERS as u8 - 1;
        let names = [
            Name::GruInput(last),
            Name::GruHidden(last),
            Name::GruInputBias(last),
            Name::GruHiddenBias(last),
            Name::HeadWeight,
            Name::HeadBias,
        ];
        for (name, matrix) in names.into_iter().zip(&weights[GRU.start..HEAD.end]) {
            put(name, matrix.values.clone());
        }
        let dynamics = rounded(&dynamics_of(&weights[DYNAMICS]));
        for part in parts::operators(&dynamics, &dynamics.preconditioner()) {
            put(part.tensor, part.values);
        }
        let gain = Square::from_row_iterator(weights[GAIN].values.iter().map(|&v| f64::from(v)));
        let gain = settle(&dynamics, gain);
        put(Name::Gain, gain.transpose().iter().map(|&v| v as f32).collect());
        let forward = transition(&dynamics).transpose();
        put(Name::Transition, forward.iter().map(|&v| v as f32).collect());
        residuals.put(&mut parts);
        let mut header = self.header.clone();
        header.liquid = fitting(&how.liquid);
        header.model_version = header.model_version.saturating_add(1);
        header.stated_known = known_after(header.stated_known, how.same_liquid);
        header.provenance = fitting(&format!("{}{BEFORE}{}", how.command, self.header.provenance));
        Ok(write::blob(header, &parts)?)
    }
}

/// The dynamics of a blob in double precision.
fn dynamics_from(
    numbers: &dyn Fn(Name) -> Result<Vec<f64>, TrainError>,
    matrix: &dyn Fn(Name) -> Result<Matrix, TrainError>,
) -> Result<Dynamics, TrainError> {
    let triangle = |values: &[f64], shift: usize| {
        let mut m = Square::zeros();
        let entries = (0..LATENTS).flat_map(|i| (0..(i + 1).saturating_sub(shift)).map(move |j| (i, j)));
        entries.zip(values).for_each(|(ij, v)| m[ij] = *v);
        m
    };
    let lower = triangle(&numbers(Name::SkewLower)?, 1);
    Ok(Dynamics {
        skew: lower - lower.transpose(),
        friction: triangle(&numbers(Name::FrictionFactor)?, 0),
        linear: Square::from_row_iterator(numbers(Name::EnergyLinear)?),
        inner: matrix(Name::EnergyIn)?.to_f64(),
        bias: numbers(Name::EnergyBias)?.into(),
        weight: numbers(Name::EnergyWeight)?.into(),
        port: Latent::from_iterator(numbers(Name::Port)?),
        // A blob without one has a friction that is linear.
        law: numbers(Name::FrictionLaw).ok().and_then(|law| FrictionLaw::new(law.try_into().ok()?)),
    })
}
