//! Correction: a model of one liquid learns another from what a camera saw of its free surface.
//!
//! The paper's algorithm (section "correction"), with exact degeneracy instead of a penalty for it: the
//! last GRU layer with its head, operators, energy and port of the GENERIC step, and a constant
//! gain that joins the two learn by Adam from the free surface alone. Decoder and lower layers stay.
//!
//! ```text
//! blob A --import--> weights --Adam on batches of (new, source)--> candidate blob --judge--> best --> blob B
//! ```
//! Every look is taken by the camera side itself: a candidate is exported, loaded and run over what is learnt from, which
//! tells where the next forecasts begin (`student`) and what step and decoder miss of this liquid (`misses`), and over what is held
//! out. It counts only if
//! - what its latents say of the source liquid has not become worse than the bound (against forgetting), and
//! - what it foretells of the held-out recording, the surface a quarter of a second ahead under the motion that the camera
//!   saw, is better than of every one before (against learning noise). The estimate itself tells models apart no more: it
//!   follows the heights of any liquid.
//!
//! A camera has seen only so strong a slosh. Small sloshes are linear, so that the recordings are also learnt
//! from stretched, heights and way of the glass by the same factor, each error counted over that factor.
//!
//! A hand does not keep to a line; what stands across it by the model's own estimate (`meniscus::uncertainty::cross_axis`) is taken off the
//! heights first.
//!
//! The intervals of the new blob are as much wider as the held-out surface asks for (`interval`).
//!
//! The laws need no guard: they hold for any weights, and the gain is pulled back until its loop is stable.

mod checkpoint_parts;
mod interval;
mod judge;
mod residual_covariance;
mod trainable_model;
mod training_window;

use crate::TrainError;
use crate::correct::checkpoint_parts::Pupil;
use crate::correct::trainable_model::{Batch, DYNAMICS, FLIGHT, Flights, HORIZON, Student};
use crate::correct::training_window::Lesson;
use crate::operators::unrolled::dynamics_of;
use burn::tensor::{Device, Tensor};
use judge::{AHEAD, error, split};
use meniscus::blob::{LoadError, Model};
use meniscus::latent::generic::Latent;
use meniscus::runtime::Drive;
use meniscus::surface::SurfaceProfile;
use meniscus_optim::progress::{Session, annealed};
use meniscus_optim::weights::{Adam, leaves, scalar};
use meniscus_platform::files::AlignedBytes;
use meniscus_virtual::observe_recording::turns_with;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::atomic::AtomicBool;

/// Roll-outs of one step: of the new liquid, of the same stretched, of the source liquid.
const BATCH: [usize; 3] = [40, 16, 16];

/// Steps between two looks.
const LOOK: usize = 10;

/// Learning rate of the first step.
const RATE: f64 = 2e-3;

/// Factors by which what was learnt from is stretched, heights and way of the glass alike: small sloshes are
/// linear, and a stronger one than any that was recorded is then not met for the first time.
const STRETCHED: [f32; 2] = [1.6, 2.4];

/// What a camera saw, frame by frame.
pub type Sightings = Vec<Option<SurfaceProfile>>;

/// How to correct.
#[derive(Clone, Debug)]
pub struct Correction {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Steps of Adam.
    pub steps: usize,
    /// By how much the slosh-relative error on the source recordings may grow.
    pub forgetting: f64,
    /// Name of the liquid, for the blob.
    pub liquid: String,
    /// The command, for the blob's provenance.
    pub command: String,
    /// No bar.
    pub quiet: bool,
}

impl Default for Correction {
    /// Half a minute on two cores.
    fn default() -> Self {
        Self {
            seed: 1,
            steps: 300,
            forgetting: 0.05,
            liquid: String::from("corrected"),
            command: String::new(),
            quiet: false,
        }
    }
}

/// A corrected blob and how it came about; errors are slosh-relative, of the measured surface.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// The bytes of the blob.
    pub blob: Vec<u8>,
    /// Error of what is foretold 0.25 s ahead of the held-out part, before and after.
    pub held: [f64; 2],
    /// Error of what is said of the source recordings, before and after.
    pub source: [f64; 2],
    /// Step and both errors of every look.
    pub looks: Vec<(usize, f64, f64)>,
    /// Looks whose candidate was better on the held-out part but had forgotten too much.
    pub refused: usize,
}

/// Corrects `blob` by `recordings` of another liquid, with `source` as recordings of its own.
///
/// With two recordings or more the last is held out; of a single one its last three tenths.
///
/// # Errors
/// [`TrainError`], when the blob is refused or the recordings do not suffice.
pub fn correct(
    blob: &[u8],
    recordings: &[Sightings],
    source: &[Sightings],
    how: &Correction,
    stop: &AtomicBool,
) -> Result<Corrected, TrainError> {
    let blob = AlignedBytes::copy(blob);
    let pupil = Pupil::new(&blob)?;
    let (learnt, held) = split(recordings)?;
    let model = Model::load(&blob)?;
    let straight = |all: &[Sightings]| all.iter().map(|seen| in_line(&model, seen)).collect::<Vec<_>>();
    let lessons = |all: &[Sightings]| all.iter().map(|seen| pupil.lesson(seen)).collect::<Vec<_>>();
    let seen_new = straight(&learnt.all);
    let (mut new, old) = (lessons(&seen_new), lessons(&straight(source)));
    let (mut strong, mut seen_strong) = (Vec::new(), Vec::new());
    for factor in STRETCHED {
        let seen: Vec<_> = seen_new.iter().map(|s| stretched(s, factor, &pupil.surface.rest)).collect();
        strong.extend(lessons(&seen).into_iter().map(|lesson| lesson.counted(1.0 / factor)));
        seen_strong.extend(seen);
    }
    if let Some(frames) = learnt.frames {
        for lesson in new.iter_mut().chain(&mut strong) {
            *lesson = lesson.part(0, frames.min(lesson.frames()));
        }
    }
    let judge = |blob: &[u8]| -> Result<(f64, f64), LoadError> {
        let blob = AlignedBytes::copy(blob);
        let model = Model::load(&blob)?;
        Ok((error(&model, &held.all, held.from, AHEAD), error(&model, source, 0, 0)))
    };
    let stand = |blob: &[u8]| -> Result<[Vec<Vec<Latent>>; 2], LoadError> {
        let blob = AlignedBytes::copy(blob);
        let model = Model::load(&blob)?;
        Ok([&seen_new, &seen_strong].map(|all| all.iter().map(|seen| stood(&model, seen)).collect()))
    };
    let device = Device::flex().autodiff();
    let session = Session::new(how.quiet, stop);
    let mut rng = ChaCha8Rng::seed_from_u64(how.seed);
    let mut weights = pupil.weights.clone();
    let mut adam = Adam::new(&weights, 1.0);
    let before = judge(&blob)?;
    let bound = before.1 + how.forgetting;
    let (mut best, mut least) = ((blob.to_vec(), before), before.0);
    let (mut looks, mut refused) = (vec![(0, before.0, before.1)], 0);
    let size = |all: &[Lesson]| {
        let sum: f32 = all.iter().map(Lesson::mean_square).sum();
        (sum / all.len().max(1) as f32).max(1e-12)
    };
    let sets = [&new, &strong, &old].map(|all| (all.iter().collect::<Vec<_>>(), size(all)));
    let (mut stood, mut misses) = (stand(&blob)?, pupil.misses);
    let bar = session.bar("correction", how.steps);
    for step in 0..how.steps {
        let tensors = leaves(&weights, &device);
        let p = dynamics_of(&weights[DYNAMICS]).preconditioner();
        let student = Student::new(&tensors, &pupil.surface, &p, &device);
        let mut losses: Vec<Tensor<1>> = Vec::new();
        for ((lessons, size), count) in sets.iter().zip(BATCH) {
            let starts = draw(lessons, count, HORIZON, &mut rng);
            if !starts.is_empty() {
                losses.push(student.following(&Batch::new(lessons, &starts, &device), *size));
            }
        }
        // The source, the last of the sets, is not foretold: its motion is another.
        for (((lessons, size), stood), count) in sets.iter().zip(&stood).zip(BATCH) {
            let starts = draw(lessons, count, FLIGHT, &mut rng);
            if !starts.is_empty() {
                losses.push(student.foretelling(&Flights::new((lessons, stood), &starts, &device), *size));
            }
        }
        let total = losses.into_iter().reduce(|sum, part| sum + part).ok_or(TrainError::NoMotion)?;
        let value = f64::from(scalar(total.clone()));
        adam.step(&mut weights, &tensors, total.backward(), annealed(RATE, step, how.steps));
        if step % LOOK == LOOK - 1 || step + 1 == how.steps {
            let follows = misses.following_like(&pupil.misses);
            stood = stand(&pupil.blob(&weights, &follows, how)?)?;
            let [of_new, _] = &stood;
            misses = pupil.missed(&weights, &new, of_new);
            let candidate = pupil.blob(&weights, &misses, how)?;
            let now = judge(&candidate)?;
            looks.push((step + 1, now.0, now.1));
            if now.0 < least && now.1 <= bound {
                (best, least) = ((candidate, now), now.0);
            } else if now.0 < least {
                refused += 1;
            }
            bar.show(step + 1, value.max(0.0).sqrt(), now.0);
            if session.stopped() {
                break;
            }
        }
    }
    bar.finish();
    let (chosen, after) = best;
    // A model that nothing was learnt by keeps its intervals too: it is the same to the byte.
    let unchanged = chosen[..] == blob[..];
    let blob = if unchanged { chosen } else { interval::rescaled(&chosen, &held.all, held.from)? };
    Ok(Corrected { blob, held: [before.0, after.0], source: [before.1, after.1], looks, refused })
}

/// Where the running filter of `model` stood at every frame of `seen`.
fn stood(model: &Model<'_>, seen: &Sightings) -> Vec<Latent> {
    let mut latents = Vec::with_capacity(seen.len());
    turns_with(model, seen, |_| Drive::Seen, |_, _, estimate| latents.push(estimate.latent.into()));
    latents
}

/// `seen` without the slosh across the line: the step that is corrected knows none.
fn in_line(model: &Model<'_>, seen: &Sightings) -> Sightings {
    let mut out = seen.clone();
    turns_with(
        model,
        seen,
        |_| Drive::Seen,
        |frame, memory, _| {
            if let Some(Some(profile)) = out.get_mut(frame) {
                *profile = model.transverse.in_line(profile, memory.aside_m());
            }
        },
    );
    out
}

/// `seen` with every height over `rest` and every place of the glass times `factor`.
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

/// Starts of `count` roll-outs of `frames` as (lesson, frame): anywhere after the first window, of two draws the livelier.
fn draw(lessons: &[&Lesson], count: usize, frames: usize, rng: &mut ChaCha8Rng) -> Vec<(usize, usize)> {
    const FIRST: usize = meniscus::latent::window::WINDOW - 1;
    let room = |lesson: &Lesson| lesson.frames().saturating_sub(FIRST + frames + 1);
    let total: usize = lessons.iter().map(|lesson| room(lesson)).sum();
    if total == 0 {
        return Vec::new();
    }
    let mut one = || {
        let mut at = rng.random_range(0..total);
        for (i, lesson) in lessons.iter().enumerate() {
            if at < room(lesson) {
                return (i, FIRST + at);
            }
            at -= room(lesson);
        }
        (0, FIRST)
    };
    let life = |&(i, n): &(usize, usize)| {
        let heights =
            &lessons[i].height[n * meniscus::surface::POINTS..(n + frames) * meniscus::surface::POINTS];
        heights.iter().map(|h| h * h).sum::<f32>()
    };
    let livelier = |_| {
        let (a, b) = (one(), one());
        if life(&a) > life(&b) { a } else { b }
    };
    (0..count).map(livelier).collect()
}
