//! The filter against laws that it does not contain: kinematics, Bayes' rule in its other form, numbers computed by hand.

mod prediction;
mod updates;

use super::covariance::ErrorCovariance;
use super::kalman::Filter;
use super::state::{StateIndex, StateMatrix, StateVector};
use crate::blob::{FilterConfig, Model};
use crate::math::pow;

#[repr(align(64))]
struct Aligned<T: ?Sized>(T);

static BLOB: &Aligned<[u8]> =
    &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));

/// The shipped model with the filter settings `config`.
fn model(config: FilterConfig) -> Model<'static> {
    let mut model = Model::load(&BLOB.0).expect("the shipped model");
    model.header.filter = config;
    model
}

/// Settings under which an input stays as it is and no gate closes.
fn steady() -> FilterConfig {
    FilterConfig {
        input_recursion: [1.0, 0.0, 0.0],
        innovation_gate: 1e6,
        position_gate: 1e6,
        ..FilterConfig::REFERENCE
    }
}

/// A filter at rest whose errors are those of `covariance`.
fn filter(config: &FilterConfig, covariance: StateMatrix) -> Filter {
    Filter { covariance: ErrorCovariance::new(covariance), ..Filter::new(config) }
}

/// A covariance without structure: variances of `scale` squared, correlations between all numbers.
fn correlated(scale: f64) -> StateMatrix {
    StateMatrix::from_fn(|i, j| scale * scale * pow(0.7, i.abs_diff(j) as f64))
}

/// All numbers of the filter's state but the latents, at their positions.
fn behind_the_latents(filter: &Filter) -> StateVector {
    let numbers = filter.input.iter().chain(&filter.glass_mm).chain(&filter.lateral_mm);
    let mut state = StateVector::zeros();
    for (index, number) in StateIndex::ALL.into_iter().zip(numbers) {
        state[index.index()] = *number;
    }
    state
}

#[track_caller]
fn close(value: f64, due: f64) {
    assert!((value - due).abs() <= 1e-9 * due.abs(), "{value} for {due}");
}
