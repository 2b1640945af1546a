//! Errors of the full field by group.

use meniscus::blob::{FieldGroup, Model};
use meniscus::latent::decoder::STRESS_GROUP;
use meniscus::runtime::{Estimate, smoothed_stress};
use meniscus_data::recording::{GROUP_NAMES, Recording, STATE, group_range};

/// Count of the truths that lay within an interval.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    inside: u64,
    all: u64,
}

impl Held {
    /// Takes numbers, what was said of them and the half-widths given.
    pub fn add(&mut self, truth: &[f32], estimate: &[f32], half: &[f32]) {
        for ((truth, estimate), half) in truth.iter().zip(estimate).zip(half) {
            self.inside += u64::from((truth - estimate).abs() <= *half);
            self.all += 1;
        }
    }

    /// The share that lay within; NaN of nothing.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.inside as f64 / self.all as f64
    }
}

/// The full field of an estimate as the decoder gives it, with the groups that the model does not know.
///
/// # Panics
/// When the model has another number of tracers than a recording.
pub fn field_of(model: &Model<'_>, estimate: &Estimate, out: &mut [f32]) {
    assert_eq!(model.field_len(), out.len(), "model and recording have the same tracers");
    let latent = estimate.latent.map(|x| x as f32);
    let coefficients = model.decoder.coefficients(&latent, estimate.port);
    model.decoder.field(&coefficients, estimate.heat_j as f32, out);
}

/// Error of one field group.
#[derive(Clone, Copy, Debug)]
pub struct GroupError {
    /// Group.
    pub group: FieldGroup,
    /// Its name in files.
    pub name: &'static str,
    /// Relative L2 error of its fluctuation.
    pub error: f64,
    /// Numbers that lay within their interval.
    pub held: Held,
}

/// Sums of squares of the field's error and fluctuation, by group.
pub(super) struct FieldSums {
    rest: Vec<f32>,
    truth: Vec<f32>,
    estimate: Vec<f32>,
    pub(super) held: [Held; GROUP_NAMES.len()],
    square: [f64; GROUP_NAMES.len()],
    rest_square: [f64; GROUP_NAMES.len()],
    /// The same two sums of sigma one frame late.
    pub(super) late: [f64; 2],
}

impl FieldSums {
    pub(super) fn new(recording: &Recording) -> Self {
        let mut rest = vec![0.0; STATE];
        recording.state(0, &mut rest);
        let (truth, estimate) = (rest.clone(), rest.clone());
        let (square, rest_square, late) = ([0.0; 5], [0.0; 5], [0.0; 2]);
        Self { rest, truth, estimate, held: [Held::default(); 5], square, rest_square, late }
    }

    pub(super) fn add(
        &mut self,
        model: &Model<'_>,
        recording: &Recording,
        frame: usize,
        estimate: &Estimate,
    ) {
        recording.state(frame, &mut self.truth);
        field_of(model, estimate, &mut self.estimate);
        for group in 0..GROUP_NAMES.len() {
            let range = group_range(group);
            let truth = &self.truth[range.clone()];
            let half = std::iter::repeat_n(estimate.interval.field[group], truth.len());
            self.held[group].add(truth, &self.estimate[range.clone()], &half.collect::<Vec<_>>());
            self.square[group] += distance_square(truth, &self.estimate[range.clone()]);
            self.rest_square[group] += distance_square(truth, &self.rest[range]);
        }
    }

    pub(super) fn add_late(
        &mut self,
        model: &Model<'_>,
        recording: &Recording,
        frame: usize,
        before: &Estimate,
        now: &Estimate,
    ) {
        let range = group_range(STRESS_GROUP);
        recording.state(frame, &mut self.truth);
        if smoothed_stress(model, before, now, &mut self.estimate[range.clone()]) == 0 {
            return;
        }
        let truth = &self.truth[range.clone()];
        self.late[0] += distance_square(truth, &self.estimate[range.clone()]);
        self.late[1] += distance_square(truth, &self.rest[range]);
    }

    pub(super) fn errors(&self) -> [f64; 5] {
        std::array::from_fn(|group| (self.square[group] / self.rest_square[group]).sqrt())
    }
}

fn distance_square(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum()
}
