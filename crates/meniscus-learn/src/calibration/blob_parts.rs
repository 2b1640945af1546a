//! A trained model as the tensors of a blob.

use crate::calibration::learnt_model::LearntModel;
use crate::data::groups::{SIGMA, TRUNK};
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::blob::Tensor;
use meniscus::latent::encoder::GRU_LAYERS as LAYERS;
use meniscus::latent::generic::LATENTS;
use meniscus_data::blob_file::write::Part;
use meniscus_data::recording::{TRACERS, group_range};
use meniscus_optim::weights::Matrix;

fn part(tensor: Tensor, matrix: &Matrix) -> Part {
    Part { tensor, rows: matrix.rows, columns: matrix.columns, values: matrix.values.clone() }
}

fn vector(tensor: Tensor, values: Vec<f32>) -> Part {
    Part { tensor, rows: values.len(), columns: 1, values }
}

fn square(tensor: Tensor, m: &Square) -> Part {
    let values = m.transpose().iter().map(|&v| v as f32).collect();
    Part { tensor, rows: LATENTS, columns: LATENTS, values }
}

/// The lower triangle of `m`, rows first, up to `shift` below the diagonal.
fn triangle(tensor: Tensor, m: &Square, shift: usize) -> Part {
    let entries = (0..LATENTS).flat_map(|i| (0..(i + 1).saturating_sub(shift)).map(move |j| (i, j)));
    vector(tensor, entries.map(|ij| m[ij] as f32).collect())
}

fn encoder(model: &LearntModel) -> Vec<Part> {
    let (recurrent, head) = model.encoder.weights.split_at(4 * LAYERS);
    let mut parts = Vec::new();
    for (layer, weights) in (0..).zip(recurrent.chunks_exact(4)) {
        parts.push(part(Tensor::GruInput(layer), &weights[0]));
        parts.push(part(Tensor::GruHidden(layer), &weights[1]));
        parts.push(vector(Tensor::GruInputBias(layer), weights[2].values.clone()));
        parts.push(vector(Tensor::GruHiddenBias(layer), weights[3].values.clone()));
    }
    parts.push(part(Tensor::HeadWeight, &head[0]));
    parts.push(vector(Tensor::HeadBias, head[1].values.clone()));
    parts
}

/// The operators, the energy, the port and the preconditioner of the GENERIC step.
pub(crate) fn operators(d: &Dynamics, preconditioner: &Square) -> Vec<Part> {
    let mut parts = vec![
        triangle(Tensor::SkewLower, &d.skew, 1),
        triangle(Tensor::FrictionFactor, &d.friction, 0),
        square(Tensor::EnergyLinear, &d.linear),
        part(Tensor::EnergyIn, &Matrix::from_f64(&d.inner)),
        vector(Tensor::EnergyBias, d.bias.iter().map(|&v| v as f32).collect()),
        vector(Tensor::EnergyWeight, d.weight.iter().map(|&v| v as f32).collect()),
        vector(Tensor::Port, d.port.iter().map(|&v| v as f32).collect()),
        square(Tensor::Preconditioner, preconditioner),
    ];
    let numbers = d.law.map(|law| law.numbers().map(|v| v as f32).to_vec());
    parts.extend(numbers.map(|numbers| vector(Tensor::FrictionLaw, numbers)));
    parts
}

fn dynamics(model: &LearntModel) -> Vec<Part> {
    let mut parts = operators(&model.dynamics, &model.preconditioner);
    parts.push(square(Tensor::Gain, &model.gain));
    parts
}

fn decoder(model: &LearntModel) -> Vec<Part> {
    let trunk = model.autoencoder.trunk(&model.frame);
    let mut parts =
        vec![part(Tensor::TrunkLinear, &trunk[0]), vector(Tensor::TrunkPort, model.frame.feed.clone())];
    for (layer, weights) in (0..).zip(trunk[1..].chunks_exact(2)) {
        parts.push(part(Tensor::TrunkWeight(layer), &weights[0]));
        parts.push(vector(Tensor::TrunkBias(layer), weights[1].values.clone()));
    }
    // The coefficients of e lie between those of v and sigma: linear in x, nothing of the port or of the net.
    let (before, moved) = (model.frame.ranges()[SIGMA].start, &model.heat.coefficients);
    for part in &mut parts {
        let rows = match part.tensor {
            Tensor::TrunkLinear => moved.values.clone(),
            Tensor::TrunkPort | Tensor::TrunkWeight(2) | Tensor::TrunkBias(2) => {
                vec![0.0; moved.rows * part.columns]
            }
            _ => continue,
        };
        let at = before * part.columns;
        part.values.splice(at..at, rows);
        part.rows += moved.rows;
    }
    parts
}

/// Rest state and basis of each group, q, v, e, sigma, tau, surface.
fn groups(model: &LearntModel) -> Vec<Part> {
    const HEAT: u8 = 2;
    const BLOB: [u8; TRUNK.len()] = [0, 1, 3, 4, 5];
    let frame = &model.frame;
    let mut parts = Vec::new();
    for (group, basis) in BLOB.into_iter().zip(&frame.bases) {
        let rest = if group < 5 { &frame.rest_state[group_range(group.into())] } else { &frame.rest_profile };
        parts.push(vector(Tensor::GroupRest(group), rest.to_vec()));
        // nalgebra is column-major: the transpose iterates row by row.
        let values = basis.modes.transpose().iter().copied().collect();
        let (rows, columns) = basis.modes.shape();
        parts.push(Part { tensor: Tensor::GroupBasis(group), rows, columns, values });
        if group == 1 {
            let rest = &frame.rest_state[group_range(HEAT.into())];
            debug_assert_eq!(rest.len(), TRACERS);
            parts.push(vector(Tensor::GroupRest(HEAT), rest.to_vec()));
            parts.push(part(Tensor::GroupBasis(HEAT), &model.heat.basis));
        }
    }
    parts
}

/// All tensors of `model`, in the order of the format.
#[must_use]
pub(crate) fn parts(model: &LearntModel) -> Vec<Part> {
    [encoder(model), dynamics(model), decoder(model), groups(model)].concat()
}
