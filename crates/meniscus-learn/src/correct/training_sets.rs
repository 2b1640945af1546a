//! Training sets of a correction: the new liquid, the same stretched, and the source liquid against forgetting.

use super::Sightings;
use crate::correct::checkpoint_parts::CheckpointParts;
use crate::correct::effects::{remembering, with_effects, without_effects};
use crate::correct::judge::Subset;
use crate::correct::parameters::CorrectionParameters;
use crate::correct::training_window::TrainingWindow;
use meniscus::blob::{LoadError, Model};
use meniscus::latent::generic::{Latent, LatentState};
use meniscus::latent::window::WINDOW;
use meniscus::runtime::InputSource;
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus_virtual::observe_recording::turns_with;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Windows of one set, with the profiles that the filter runs over.
pub(super) struct TrainingSet {
    /// Windows to learn from, one a recording.
    pub(super) windows: Vec<TrainingWindow>,
    /// Profiles of the whole recordings.
    sightings: Vec<Sightings>,
    /// Mean square of the heights, m2: the unit of the loss.
    pub(super) mean_square: f32,
}

impl TrainingSet {
    fn new(windows: Vec<TrainingWindow>, sightings: Vec<Sightings>) -> Self {
        let sum: f32 = windows.iter().map(TrainingWindow::mean_square).sum();
        let mean_square = (sum / windows.len().max(1) as f32).max(1e-12);
        Self { windows, sightings, mean_square }
    }

    /// State of the running filter of `model` at every frame of every recording.
    pub(super) fn filter_states(&self, model: &Model<'_>) -> Vec<Vec<LatentState>> {
        let runs = self.sightings.iter().zip(&self.windows);
        runs.map(|(seen, window)| remembering(&model.generic, &latents(model, seen), &window.u)).collect()
    }

    /// Starts of `count` roll-outs of `frames` as (window, frame): anywhere after the first window, of two draws the
    /// livelier.
    pub(super) fn draw(&self, count: usize, frames: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
        draw(&self.windows, count, frames, rng)
    }
}

/// The three sets of a correction.
pub(super) struct TrainingSets {
    /// New liquid.
    pub(super) new: TrainingSet,
    /// New liquid, stretched.
    pub(super) stretched: TrainingSet,
    /// Source liquid.
    pub(super) source: TrainingSet,
}

impl TrainingSets {
    /// Sets from the part `learnt` of the new recordings and from those of the source liquid, as the model `blob` sees them with
    /// its effects and without.
    ///
    /// # Errors
    /// [`LoadError`], when the blob is refused.
    pub(super) fn new(
        blob: &[u8],
        parts: &CheckpointParts,
        learnt: &Subset,
        source: &[Sightings],
        parameters: &CorrectionParameters,
    ) -> Result<Self, LoadError> {
        let straight = |model: Model<'_>, all: &[Sightings]| -> Vec<Sightings> {
            all.iter().map(|seen| in_line(&model, seen)).collect()
        };
        let windows = |all: &[Sightings]| all.iter().map(|seen| parts.window(seen)).collect::<Vec<_>>();
        let seen_new = straight(with_effects(blob)?, &learnt.all);
        let seen_source = straight(without_effects(blob)?, source);
        let (mut new, old) = (windows(&seen_new), windows(&seen_source));
        let (mut strong, mut seen_strong) = (Vec::new(), Vec::new());
        for factor in parameters.stretch {
            let seen: Vec<_> = seen_new.iter().map(|s| stretched(s, factor, &parts.surface.rest)).collect();
            // An error of a stretched height is counted over the factor.
            strong.extend(windows(&seen).into_iter().map(|window| window.counted(1.0 / factor)));
            seen_strong.extend(seen);
        }
        if let Some(frames) = learnt.frames {
            for window in new.iter_mut().chain(&mut strong) {
                *window = window.part(0, frames.min(window.frames()));
            }
        }
        Ok(Self {
            new: TrainingSet::new(new, seen_new),
            stretched: TrainingSet::new(strong, seen_strong),
            source: TrainingSet::new(old, seen_source),
        })
    }
}

/// Latents of the running filter of `model` at every frame of `seen`.
fn latents(model: &Model<'_>, seen: &Sightings) -> Vec<Latent> {
    let mut latents = Vec::with_capacity(seen.len());
    turns_with(model, seen, |_| InputSource::Tracked, |_, _, estimate| latents.push(estimate.latent.into()));
    latents
}

/// Returns `seen` without the cross-axis slosh: the step that is corrected knows none.
fn in_line(model: &Model<'_>, seen: &Sightings) -> Sightings {
    let mut out = seen.clone();
    turns_with(
        model,
        seen,
        |_| InputSource::Tracked,
        |frame, memory, _| {
            if let Some(Some(profile)) = out.get_mut(frame) {
                *profile = model.cross_axis.without(profile, memory.lateral_m());
            }
        },
    );
    out
}

/// Returns `seen` with every height over `rest` and every position of the glass times `factor`.
fn stretched(seen: &Sightings, factor: f32, rest: &[f32]) -> Sightings {
    let stretch = |mut profile: SurfaceProfile| {
        for (height, rest) in profile.height_m.iter_mut().zip(rest) {
            *height = rest + factor * (*height - rest);
        }
        profile.variance_m2.iter_mut().for_each(|variance| *variance *= factor * factor);
        profile.glass_x_m = profile.glass_x_m.map(|x| factor * x);
        profile
    };
    seen.iter().map(|profile| profile.map(stretch)).collect()
}

fn draw(
    windows: &[TrainingWindow],
    count: usize,
    frames: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<(usize, usize)> {
    const FIRST: usize = WINDOW - 1;
    let room = |window: &TrainingWindow| window.frames().saturating_sub(FIRST + frames + 1);
    let total: usize = windows.iter().map(room).sum();
    if total == 0 {
        return Vec::new();
    }
    let mut one = || {
        let mut at = rng.random_range(0..total);
        for (i, window) in windows.iter().enumerate() {
            if at < room(window) {
                return (i, FIRST + at);
            }
            at -= room(window);
        }
        (0, FIRST)
    };
    let life = |&(i, n): &(usize, usize)| {
        let heights = &windows[i].height[n * POINTS..(n + frames) * POINTS];
        heights.iter().map(|h| h * h).sum::<f32>()
    };
    let livelier = |_| {
        let (a, b) = (one(), one());
        if life(&a) > life(&b) { a } else { b }
    };
    (0..count).map(livelier).collect()
}
