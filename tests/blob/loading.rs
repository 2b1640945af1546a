//! Bounds of what a blob may hold: shapes that are wrong in one direction, covariances at the edge of what is one.

use super::{refusal, support};
use meniscus::blob::{LoadError, Model, Tensor};
use meniscus_data::blob_file::write::{Part, blob};
use meniscus_platform::files::AlignedBytes;

/// A random blob whose tensor `tensor` was changed by `change`.
fn changed(tensor: Tensor, change: impl Fn(&mut Part)) -> Vec<u8> {
    let mut parts = support::parts(1, 0.1);
    parts.iter_mut().filter(|part| part.tensor == tensor).for_each(change);
    blob(support::header(), &parts).expect("a blob")
}

fn loads(bytes: &[u8]) -> bool {
    Model::load(&AlignedBytes::copy(bytes)).is_ok()
}

/// A row or a column too few, each alone.
#[test]
fn a_shape_is_refused_for_its_rows_and_for_its_columns() {
    let fewer_rows = |part: &mut Part| {
        part.rows -= 1;
        part.values.truncate(part.rows * part.columns);
    };
    let fewer_columns = |part: &mut Part| {
        part.columns -= 1;
        part.values.truncate(part.rows * part.columns);
    };
    for (tensor, rows, columns) in [
        (Tensor::HeadWeight, 14, 26),
        (Tensor::Transition, 13, 13),
        (Tensor::EnergyLinear, 13, 13),
        (Tensor::SurfaceSlope, 21, 13),
    ] {
        let error = refusal(&changed(tensor, fewer_rows));
        assert_eq!(error, LoadError::Shape { tensor, found: (rows - 1, columns) });
        let error = refusal(&changed(tensor, fewer_columns));
        assert_eq!(error, LoadError::Shape { tensor, found: (rows, columns - 1) });
    }
    // One number too few for the ridges and for the layer that it belongs to.
    for (tensor, rows) in [(Tensor::EnergyBias, 48), (Tensor::EnergyWeight, 48), (Tensor::TrunkBias(0), 64)] {
        let error = refusal(&changed(tensor, fewer_rows));
        assert_eq!(error, LoadError::Shape { tensor, found: (rows - 1, 1) });
    }
}

/// The vectors of a model are those that were written.
#[test]
fn every_number_of_a_vector_arrives() {
    let bytes = support::random_blob(1, 0.1);
    let model = Model::load(&bytes).expect("sound");
    let parts = support::parts(1, 0.1);
    let written = |tensor| &parts.iter().find(|part| part.tensor == tensor).expect("there").values[..];
    assert_eq!(model.generic.potential.bias, written(Tensor::EnergyBias));
    assert_eq!(model.generic.potential.weight, written(Tensor::EnergyWeight));
    assert_eq!(model.decoder.port, written(Tensor::TrunkPort));
    for (layer, dense) in model.decoder.trunk.iter().enumerate() {
        assert_eq!(dense.bias, written(Tensor::TrunkBias(layer as u8)));
    }
    assert_eq!(model.encoder.bias, written(Tensor::HeadBias));
    assert_eq!(model.error_model.surface_misfit, written(Tensor::SurfaceMisfit));
    assert_eq!(model.error_model.group_misfit, written(Tensor::GroupMisfit));
    let port = model.generic.port.iter().zip(written(Tensor::Port));
    assert!(port.into_iter().all(|(a, b)| *a == f64::from(*b)));
}

/// Rounding may leave a covariance asymmetric by a thousandth of its largest entry, in whatever units.
#[test]
fn a_covariance_is_symmetric_to_a_thousandth() {
    for scale in [0.01, 1.0, 100.0] {
        let skewed = |share: f32| {
            changed(Tensor::ReadingSpread, move |part| {
                part.values.iter_mut().for_each(|value| *value *= scale);
                let largest = part.values.iter().fold(0.0_f32, |most, value| most.max(value.abs()));
                part.values[1] += share * largest;
            })
        };
        assert!(loads(&skewed(5e-4)), "{scale}");
        assert_eq!(refusal(&skewed(2e-3)), LoadError::NotACovariance { tensor: Tensor::ReadingSpread });
    }
}

/// No error at all is a covariance, and no misfit a variance.
#[test]
fn errors_of_zero_are_believed() {
    for tensor in [Tensor::ProcessSpread, Tensor::ReadingSpread, Tensor::SurfaceMisfit, Tensor::GroupMisfit] {
        assert!(loads(&changed(tensor, |part| part.values.fill(0.0))), "{tensor:?}");
    }
}
