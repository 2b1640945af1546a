//! A weight blob of random numbers: everything that no training has touched.

use meniscus::blob::{FilterConfig, Header, KnownGroups, Tensor, Variant};
use meniscus_data::blob_file::write::{Part, blob};
use meniscus_platform::files::AlignedBytes;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Tracers of the random model: few, as nothing here depends on their number.
pub(crate) const PARTICLES: usize = 50;

/// The header of the random model, without its tensors.
pub(crate) fn header() -> Header {
    Header {
        liquid: "noise".try_into().expect("short"),
        provenance: "random weights of a test".try_into().expect("short"),
        particles: PARTICLES as u32,
        dt_s: 1.0 / 60.0,
        radius_m: 0.035,
        fill_m: 0.070,
        rim_m: 0.110,
        height_scale_m: 0.01,
        acceleration_scale: 2.0,
        energy_scale_j: 0.01,
        validation_slosh_rel: 1.0,
        sections: heapless::Vec::new(),
        embedded: None,
        model_version: 1,
        stated_known: KnownGroups::ALL,
        filter: FilterConfig::REFERENCE,
        variant: Variant::Full,
    }
}

/// Random tensors of every kind; `size` scales the weights of the GENERIC part.
pub(crate) fn parts(seed: u64, size: f32) -> Vec<Part> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut parts = Vec::new();
    let mut add = |tensor, rows: usize, columns: usize, scale: f32| {
        let values = (0..rows * columns).map(|_| scale * (2.0 * random.random::<f32>() - 1.0)).collect();
        parts.push(Part { tensor, rows, columns, values });
    };
    for layer in 0..3 {
        let inputs = if layer == 0 { 43 } else { 26 };
        add(Tensor::GruInput(layer), 78, inputs, 0.3);
        add(Tensor::GruHidden(layer), 78, 26, 0.3);
        add(Tensor::GruInputBias(layer), 78, 1, 0.3);
        add(Tensor::GruHiddenBias(layer), 78, 1, 0.3);
    }
    add(Tensor::HeadWeight, 14, 26, 0.5);
    add(Tensor::HeadBias, 14, 1, 0.5);
    add(Tensor::SkewLower, 78, 1, 10.0 * size);
    add(Tensor::FrictionFactor, 91, 1, size);
    add(Tensor::EnergyLinear, 13, 13, size);
    add(Tensor::EnergyIn, 48, 13, size);
    add(Tensor::EnergyBias, 48, 1, size);
    add(Tensor::EnergyWeight, 48, 1, size);
    add(Tensor::Port, 13, 1, 3.0 * size);
    add(Tensor::Preconditioner, 13, 13, 1.0);
    add(Tensor::Gain, 13, 13, 0.1);
    add(Tensor::TrunkLinear, 12, 13, 1.0);
    add(Tensor::TrunkPort, 12, 1, 1.0);
    for (layer, (rows, columns)) in [(64, 13), (64, 64), (12, 64)].into_iter().enumerate() {
        add(Tensor::TrunkWeight(layer as u8), rows, columns, 0.3);
        add(Tensor::TrunkBias(layer as u8), rows, 1, 0.3);
    }
    for (group, components) in [3, 3, 1, 3, 3].into_iter().enumerate() {
        // Of e one is for the heat itself.
        let rank = if group == 2 { 3 } else { 2 };
        add(Tensor::GroupRest(group as u8), components * PARTICLES, 1, 1.0);
        add(Tensor::GroupBasis(group as u8), components * PARTICLES, rank, 1.0);
    }
    add(Tensor::GroupRest(5), 21, 1, 0.1);
    add(Tensor::GroupBasis(5), 21, 2, 0.01);
    for tensor in [Tensor::Transition, Tensor::ProcessSpread, Tensor::ReadingSpread] {
        add(tensor, 13, 13, 0.3);
    }
    add(Tensor::SurfaceSlope, 21, 13, 0.01);
    add(Tensor::GroupSlope, 52, 13, 1.0);
    add(Tensor::SurfaceMisfit, 21, 1, 1e-6);
    add(Tensor::GroupMisfit, 4, 1, 1.0);
    add(Tensor::Reach, 9, 1, 2.0);
    // What tells errors is no noise: covariances are M M^T, variances and factors positive.
    for part in &mut parts {
        match part.tensor {
            Tensor::ProcessSpread | Tensor::ReadingSpread => {
                let row = |i: usize| &part.values[13 * i..13 * (i + 1)];
                let dot = |k: usize| row(k / 13).iter().zip(row(k % 13)).map(|(a, b)| a * b).sum();
                part.values = (0..13 * 13).map(dot).collect();
            }
            Tensor::SurfaceMisfit | Tensor::GroupMisfit | Tensor::Reach => {
                part.values.iter_mut().for_each(|value| *value = value.abs());
            }
            _ => {}
        }
    }
    parts
}

/// A whole blob of random weights.
pub(crate) fn random_blob(seed: u64, size: f32) -> AlignedBytes {
    AlignedBytes::copy(&blob(header(), &parts(seed, size)).expect("the parts fit a blob"))
}
