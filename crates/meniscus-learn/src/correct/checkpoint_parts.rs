//! A blob taken apart into what a correction changes and what it does not, and put together again.

use super::{Correction, Sightings};
use crate::calibration::blob_parts as parts;
use crate::calibration::error_model::transition;
use crate::correct::residual_covariance::Misses;
use crate::correct::trainable_model::{DYNAMICS, GAIN, GRU, HEAD, Surface};
use crate::correct::training_window::Lesson;
use crate::operators::filter::settle;
use crate::operators::reference_step::{Dynamics, Square};
use crate::operators::unrolled::{dynamics_of, rounded, weights_of};
use crate::TrainError;
use crate::blob_text::fitting;
use meniscus::blob::{Header, Model, Tensor as Name};
use meniscus::latent::encoder::GRU_LAYERS;
use meniscus::latent::generic::{LATENTS, Latent};
use meniscus_data::blob_file::{
    read,
    write::{self, Part},
};
use meniscus_optim::weights::Matrix;

/// A blob taken apart into what a correction changes and what it does not.
pub(super) struct Pupil {
    header: Header,
    parts: Vec<Part>,
    frozen: Vec<Matrix>,
    /// The surface of the decoder.
    pub(super) surface: Surface,
    /// What step and decoder miss of the source liquid.
    pub(super) misses: Misses,
    /// The floor of w.
    floor: f64,
    scale: meniscus::latent::window::Scale,
    /// What Adam changes, in the order of `student`.
    pub(super) weights: Vec<Matrix>,
}

impl Pupil {
    /// Takes `blob` apart.
    ///
    /// # Errors
    /// [`TrainError`], when it is refused.
    pub(super) fn new(blob: &[u8]) -> Result<Self, TrainError> {
        let (header, parts) = read::parts(blob)?;
        if header.named.is_some() {
            return Err(TrainError::Named);
        }
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
        weights.extend(weights_of(&dynamics_from(&numbers, &matrix)?));
        weights.push(matrix(Name::Gain)?);
        let surface = Surface::new(&parts).ok_or(missing.clone())?;
        let misses = Misses::stated(&numbers(Name::ProcessSpread)?, &numbers(Name::SurfaceMisfit)?);
        let floor = numbers(Name::Reach)?.first().copied().unwrap_or_default();
        Ok(Self { header, frozen, surface, misses, floor, scale, weights, parts })
    }

    /// The lesson of a recording.
    pub(super) fn lesson(&self, seen: &Sightings) -> Lesson {
        Lesson::new(seen, &self.scale, &self.surface.rest, &self.frozen)
    }

    /// What step and decoder miss of `lessons` under `weights`, where the filter `stood` there.
    pub(super) fn missed(&self, weights: &[Matrix], lessons: &[Lesson], stood: &[Vec<Latent>]) -> Misses {
        self.misses.measured(
            &rounded(&dynamics_of(&weights[DYNAMICS])),
            (&self.surface, self.floor),
            lessons,
            stood,
        )
    }

    /// The blob with `weights` and `misses` in the place of what was there.
    ///
    /// # Errors
    /// [`TrainError`], when a weight is not finite.
    pub(super) fn blob(
        &self,
        weights: &[Matrix],
        misses: &Misses,
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
        misses.put(&mut parts);
        let mut header = self.header.clone();
        header.liquid = fitting(&how.liquid);
        header.provenance = fitting(&format!("{}; before: {}", how.command, self.header.provenance));
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
    })
}
