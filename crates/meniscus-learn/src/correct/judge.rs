//! What a correction is judged by.
//!
//! With two recordings or more the last is held out; of a single one its last part.

use super::Sightings;
use crate::TrainError;
use meniscus::blob::Model;
use meniscus::runtime::{Estimate, Forecast, InputSource, Memory, Mode, Motion};
use meniscus::surface::SurfaceProfile;
use meniscus_score::score::SurfaceError;
use meniscus_virtual::observe_recording::turns_with;

/// Frames that are foretold to judge a model: 0.25 s.
pub(super) const AHEAD: usize = 15;

/// Share of a single recording that is learnt from; the rest is held out.
const LEARNT: f64 = 0.7;

/// What is learnt from and what is held out.
pub(super) struct Side {
    /// Recordings.
    pub(super) all: Vec<Sightings>,
    /// Frames that are learnt from, where it is not all of them.
    pub(super) frames: Option<usize>,
    /// First frame that is judged.
    pub(super) from: usize,
}

/// Which of `recordings` are learnt from and which are held out.
///
/// # Errors
/// [`TrainError::NoRecording`], when there is none.
pub(super) fn split(recordings: &[Sightings]) -> Result<(Side, Side), TrainError> {
    match recordings {
        [] => Err(TrainError::NoRecording),
        [only] => {
            let frames = (LEARNT * only.len() as f64) as usize;
            let all = vec![only.clone()];
            Ok((
                Side { all: all.clone(), frames: Some(frames), from: 0 },
                Side { all, frames: None, from: frames },
            ))
        }
        [learnt @ .., held] => Ok((
            Side { all: learnt.to_vec(), frames: None, from: 0 },
            Side { all: vec![held.clone()], frames: None, from: 0 },
        )),
    }
}

/// Slosh-relative error of what the latents say, `ahead` frames ahead under the motion that the camera saw, against the surface
/// that it then measured, over the points that were seen from frame `from` on. What the decoder misses is left out
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
