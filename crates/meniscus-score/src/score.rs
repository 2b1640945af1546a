//! Errors of a run against the truth of its recording, beside those of trivial estimates.
//!
//! ```text
//! slosh-rel  = |z - estimate| / |z - z_rest|     norms over points and frames; a flat surface scores 1
//! error      = |z - estimate| / z                per point, height from the bottom of the glass
//! field      = |s - estimate| / |s - s_rest|     norms over tracers and frames, by group
//! ```
//! The paper's relative error flatters: a flat surface already scores about 2 % mean.

use crate::field_error::{FieldSums, GroupError};
pub use crate::field_error::{Held, field_of};
use meniscus::blob::{FieldGroup, KnownGroups, Model};
use meniscus::runtime::{Estimate, Mode};
use meniscus::surface::POINTS;
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_data::recording::{GROUP_NAMES, Recording, frame_of};
use meniscus_service::timed_turn::TimedTurn;

/// Sums behind one slosh-relative error, with the mean and the maximum of the error of the height.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfaceError {
    square: f64,
    rest_square: f64,
    relative: f64,
    points: f64,
    /// Largest error relative to the height.
    pub max: f64,
}

impl SurfaceError {
    /// Takes one profile.
    pub fn add(&mut self, truth: &[f32], estimate: &[f32], rest_m: f64) {
        for (&z, &estimate) in truth.iter().zip(estimate) {
            let (z, error) = (f64::from(z), f64::from(z) - f64::from(estimate));
            self.square += error * error;
            self.rest_square += (z - rest_m) * (z - rest_m);
            self.relative += error.abs() / z;
            self.points += 1.0;
            self.max = self.max.max(error.abs() / z);
        }
    }

    /// |z - estimate| / |z - z_rest|.
    #[must_use]
    pub fn slosh_rel(&self) -> f64 {
        (self.square / self.rest_square).sqrt()
    }

    /// Mean of |z - estimate| / z.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.relative / self.points
    }
}

/// The score of a run.
#[derive(Clone, Debug)]
pub struct Score {
    /// Turns that had an estimate and a truth.
    pub frames: usize,
    /// The estimate.
    pub estimate: SurfaceError,
    /// A flat surface.
    pub flat: SurfaceError,
    /// The true surface of one frame before.
    pub persistence: SurfaceError,
    /// The linear model with the true motion.
    pub linear: SurfaceError,
    /// Groups that the model knows. A report has the errors of no others ([`Score::known_field`]).
    pub known: KnownGroups,
    /// Relative L2 error of the fluctuation of q, v, e, sigma, tau, as the decoder gives them.
    pub field: [f64; 5],
    /// Of sigma, one frame late (see [`meniscus::runtime::smoothed_stress`]); not a number where it is not known.
    pub late_sigma: f64,
    /// Heights that lay within their interval.
    pub held: Held,
    /// Of these, those of turns without heights of their own; none where no turn was without.
    pub held_coasting: Option<Held>,
    /// Numbers of q, v, e, sigma, tau that did.
    pub field_held: [Held; 5],
    /// Seconds and mean error of the height, of the estimate and of the linear model.
    pub curves: [Vec<(f64, f64)>; 2],
}

impl Score {
    /// Returns the errors of the groups that the model knows.
    pub fn known_field(&self) -> impl Iterator<Item = GroupError> {
        let all = FieldGroup::ALL.into_iter().zip(GROUP_NAMES).zip(self.field).zip(self.field_held);
        let all = all.map(|(((group, name), error), held)| GroupError { group, name, error, held });
        all.filter(|one| self.known.contains(one.group))
    }
}

/// Scores the turns of a run on `recording`; turns that had no estimate to give do not count.
#[must_use]
pub fn score(
    model: &Model<'_>,
    recording: &Recording,
    linear: &[f32],
    turns: &[TimedTurn],
    start: Micros,
) -> Score {
    let mut score = Score {
        frames: 0,
        estimate: SurfaceError::default(),
        flat: SurfaceError::default(),
        persistence: SurfaceError::default(),
        linear: SurfaceError::default(),
        known: model.header.known(),
        field: [0.0; 5],
        late_sigma: 0.0,
        held: Held::default(),
        held_coasting: None,
        field_held: [Held::default(); 5],
        curves: [vec![], vec![]],
    };
    let mut sums = FieldSums::new(recording);
    let mut before: Option<(usize, &Estimate)> = None;
    let rest_m = recording.glass.fill_m;
    for logged in turns {
        let frame = frame_of(logged.turn.time, start);
        let estimate = &logged.turn.estimate;
        if frame >= recording.frames() || !matches!(estimate.mode, Mode::Tracking | Mode::Coasting) {
            continue;
        }
        let truth = recording.profile(frame);
        let driven = &linear[frame * POINTS..(frame + 1) * POINTS];
        let mut now = [SurfaceError::default(); 2];
        now[0].add(truth, &estimate.surface_m, rest_m);
        now[1].add(truth, driven, rest_m);
        for (curve, now) in score.curves.iter_mut().zip(now) {
            curve.push((frame as f64 * FRAME_INTERVAL_S, 100.0 * now.mean()));
        }
        score.estimate.add(truth, &estimate.surface_m, rest_m);
        score.held.add(truth, &estimate.surface_m, &estimate.interval.surface_m);
        if !logged.turn.profile.as_ref().is_some_and(Result::is_ok) {
            let held = score.held_coasting.get_or_insert_default();
            held.add(truth, &estimate.surface_m, &estimate.interval.surface_m);
        }
        score.flat.add(truth, &[rest_m as f32; POINTS], rest_m);
        score.persistence.add(truth, recording.profile(frame.saturating_sub(1)), rest_m);
        score.linear.add(truth, driven, rest_m);
        sums.add(model, recording, frame, estimate);
        if let Some((_, before)) = before.filter(|(earlier, _)| earlier + 1 == frame) {
            sums.add_late(model, recording, frame - 1, before, estimate);
        }
        before = Some((frame, estimate));
        score.frames += 1;
    }
    score.field = sums.errors();
    score.late_sigma = (sums.late[0] / sums.late[1]).sqrt();
    score.field_held = sums.held;
    score
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_estimate_scores_one() {
        let mut error = SurfaceError::default();
        error.add(&[0.08, 0.06], &[0.07, 0.07], 0.07);
        assert!((error.slosh_rel() - 1.0).abs() < 1e-6);
        assert!((error.max - 1.0 / 6.0).abs() < 1e-6);
        assert!((error.mean() - 0.5 * (1.0 / 8.0 + 1.0 / 6.0)).abs() < 1e-6);
    }

    #[test]
    fn times_fall_on_their_frames() {
        let start = Micros(1_000_000);
        assert_eq!(frame_of(start, start), 0);
        assert_eq!(frame_of(Micros(1_000_000 + 599 * 16_667), start), 599);
    }
}
