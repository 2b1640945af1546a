//! Judge of a correction: forecasts of the held-out part, and estimates of the source liquid.
//!
//! With two recordings or more the last is held out; of a single one its last part.

use super::Sightings;
use crate::TrainError;
use crate::correct::effects::{with_effects, without_effects};
use meniscus::blob::{LoadError, Model};
use meniscus::runtime::{Estimate, Forecast, InputSource, Memory, Mode, Motion};
use meniscus::surface::SurfaceProfile;
use meniscus_platform::files::AlignedBytes;
use meniscus_score::score::SurfaceError;
use meniscus_virtual::observe_recording::turns_with;

/// Recordings that are learnt from, or that are held out.
pub(super) struct Subset {
    /// Recordings.
    pub(super) all: Vec<Sightings>,
    /// Frames that are learnt from, where it is not all of them.
    pub(super) frames: Option<usize>,
    /// First frame that is judged.
    pub(super) from: usize,
}

/// Splits `recordings` into those that are learnt from and those that are held out.
///
/// # Errors
/// [`TrainError::NoRecording`], when there is none.
pub(super) fn split(recordings: &[Sightings], learnt_share: f64) -> Result<(Subset, Subset), TrainError> {
    match recordings {
        [] => Err(TrainError::NoRecording),
        [only] => {
            let frames = (learnt_share * only.len() as f64) as usize;
            let all = vec![only.clone()];
            Ok((
                Subset { all: all.clone(), frames: Some(frames), from: 0 },
                Subset { all, frames: None, from: frames },
            ))
        }
        [learnt @ .., held] => Ok((
            Subset { all: learnt.to_vec(), frames: None, from: 0 },
            Subset { all: vec![held.clone()], frames: None, from: 0 },
        )),
    }
}

/// Slosh-relative errors that a candidate is judged by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CandidateErrors {
    /// Error of the forecast of the held-out part.
    pub(super) held_out: f64,
    /// Error of the estimate of the source recordings.
    pub(super) source: f64,
}

/// Recordings that candidates are judged on.
pub(super) struct Judge<'a> {
    /// New recordings that nothing is learnt from.
    pub(super) held_out: &'a Subset,
    /// Recordings of the source liquid.
    pub(super) source: &'a [Sightings],
    /// Frames that are forecast.
    pub(super) frames: usize,
}

impl Judge<'_> {
    /// Runs `blob` over both.
    ///
    /// # Errors
    /// [`LoadError`], when the blob is refused.
    pub(super) fn errors(&self, blob: &[u8]) -> Result<CandidateErrors, LoadError> {
        let blob = AlignedBytes::copy(blob);
        let (new, old) = (with_effects(&blob)?, without_effects(&blob)?);
        Ok(CandidateErrors {
            held_out: error(&new, &self.held_out.all, self.held_out.from, self.frames),
            source: error(&old, self.source, 0, 0),
        })
    }
}

/// Best candidate so far, and the record of all.
pub(super) struct Choice {
    /// Bytes of the best.
    pub(super) blob: Vec<u8>,
    /// Errors of the blob that is corrected.
    pub(super) before: CandidateErrors,
    /// Errors of the best.
    pub(super) after: CandidateErrors,
    /// Step and both errors of every candidate.
    pub(super) looks: Vec<(usize, f64, f64)>,
    /// Candidates that were better on the held-out part and had forgotten too much.
    pub(super) refused: usize,
    forgetting: f64,
}

impl Choice {
    /// Starts from `blob`, whose error on the source may grow by `forgetting`.
    pub(super) fn new(blob: &[u8], before: CandidateErrors, forgetting: f64) -> Self {
        let looks = vec![(0, before.held_out, before.source)];
        Self { blob: blob.to_vec(), before, after: before, looks, refused: 0, forgetting }
    }

    /// Takes the candidate `blob` of `step` if it is better on the held-out part and has not forgotten too much.
    pub(super) fn consider(&mut self, step: usize, blob: Vec<u8>, errors: CandidateErrors) {
        self.looks.push((step, errors.held_out, errors.source));
        let better = errors.held_out < self.after.held_out;
        let remembers = errors.source <= self.before.source + self.forgetting;
        if better && remembers {
            (self.blob, self.after) = (blob, errors);
        } else if better {
            self.refused += 1;
        }
    }
}

/// Slosh-relative error of what the latents say, `ahead` frames ahead under the motion that the camera saw, against the surface
/// that it then measured, over the points that were seen from frame `from` on. The misfit of the decoder is left out
/// ([`meniscus::uncertainty::discrepancy`]): it was taken from these very heights.
pub(super) fn error(model: &Model<'_>, recordings: &[Sightings], from: usize, ahead: usize) -> f64 {
    let mut sums = SurfaceError::default();
    let rest = model.decoder.surface.rest;
    for seen in recordings {
        let mut motion = Motion::default();
        let place = |profile: &Option<SurfaceProfile>| profile.and_then(|p| p.glass_x_m).map(f64::from);
        let plan: Vec<f64> = seen.iter().map(|profile| motion.update(place(profile))).collect();
        let look = |frame: usize, memory: &Memory, estimate: &Estimate| {
            let then = frame + ahead;
            let Some(Some(profile)) = seen.get(then).filter(|_| then >= from) else { return };
            if !matches!(estimate.mode, Mode::Tracking | Mode::Coasting) {
                return;
            }
            let plan = plan.get(frame + 1..=then).unwrap_or_default();
            let said = Forecast::new(model, memory, ahead, plan).surface_m;
            let points = profile.valid.iter().zip(&profile.height_m).zip(&said).zip(rest);
            for (((valid, truth), said), rest) in points {
                if *valid {
                    sums.add(&[*truth], &[*said], f64::from(*rest));
                }
            }
        };
        turns_with(model, seen, |_| InputSource::Tracked, look);
    }
    let error = sums.slosh_rel();
    if error.is_finite() { error } else { f64::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The better candidate stays unless it has forgotten too much, and a NaN is never better.
    #[test]
    fn a_choice_takes_the_better_and_refuses_the_forgetful() {
        let errors = |held_out: f64, source: f64| CandidateErrors { held_out, source };
        let mut choice = Choice::new(&[0], errors(0.5, 0.1), 0.05);
        choice.consider(10, vec![1], errors(0.4, 0.2));
        choice.consider(20, vec![2], errors(0.3, 0.12));
        choice.consider(30, vec![3], errors(0.35, 0.1));
        choice.consider(40, vec![4], errors(f64::NAN, 0.1));
        // The bound is that of the first blob, and a source error of NaN is above it.
        choice.consider(50, vec![5], errors(0.1, f64::NAN));
        assert_eq!((choice.blob, choice.after, choice.refused), (vec![2], errors(0.3, 0.12), 2));
        assert_eq!(choice.looks.len(), 6);
    }
}
