//! Correction: a model of one liquid learns another from what a camera saw of its free surface.
//!
//! The paper's algorithm (section "correction"), with exact degeneracy instead of a penalty for it: the
//! last GRU layer with its head, operators, energy and port of the GENERIC step, and a constant
//! gain that joins the two learn by Adam from the free surface alone. Decoder and lower layers stay.
//!
//! ```text
//! blob A --import--> weights --Adam on batches of (new, source)--> candidate blob --judge--> best --> blob B
//! ```
//! Every candidate is judged by the camera side itself. It is exported, loaded and run over the training recordings, which
//! gives the states where the next forecasts begin (`adaptation`) and the residuals of step and decoder
//! (`residual_covariance`). Then it is run over the held-out recordings (`judge`), and it counts only if
//! - the error of its estimate of the source liquid has not grown above the bound (against forgetting), and
//! - its forecast of the held-out recording, the surface a quarter of a second ahead under the motion that the camera
//!   saw, is better than that of every one before (against overfitting). The estimate itself does not distinguish models:
//!   it follows the heights of any liquid.
//!
//! A camera has seen only so strong a slosh. Small sloshes are linear, so that the recordings are also learnt
//! from stretched, heights and travel of the glass by the same factor, each error counted over that factor.
//!
//! A hand does not keep to a line. The cross-axis slosh by the model's own estimate
//! (`meniscus::uncertainty::cross_axis`) is taken off the heights first.
//!
//! The intervals of the new blob are widened until they cover the held-out surface (`interval`).
//!
//! The free surface does not teach the inside: of another liquid than its own the new blob knows surface and positions
//! ([`meniscus::blob::KnownGroups::KINEMATICS`]).
//!
//! A model that carries named effects keeps them, and learns what they leave (module `effects`).
//!
//! The laws need no guard: they hold for any weights, and the gain is pulled back until its loop is stable.

mod adaptation;
mod checkpoint_parts;
mod effects;
mod interval;
mod judge;
pub mod liquid;
mod parameters;
mod residual_covariance;
mod surface_decoder;
mod trainable_model;
mod training_sets;
mod training_window;

pub use parameters::{CorrectionParameters, ResidualParameters};

use crate::TrainError;
use adaptation::Adaptation;
use checkpoint_parts::CheckpointParts;
use effects::freed;
use judge::{Choice, Judge, split};
use meniscus::blob::KnownGroups;
use meniscus::surface::SurfaceProfile;
use meniscus_optim::progress::{Session, looks_at};
use meniscus_platform::files::AlignedBytes;
use std::sync::atomic::AtomicBool;
use training_sets::TrainingSets;

/// Profiles that a camera saw, frame by frame.
pub type Sightings = Vec<Option<SurfaceProfile>>;

/// Inputs of a correction beside its recordings.
#[derive(Clone, Debug)]
pub struct Correction {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Lengths, rates and bounds.
    pub parameters: CorrectionParameters,
    /// Name of the liquid, for the blob.
    pub liquid: String,
    /// Whether the recordings are of the liquid that the model was trained on. The model then knows as much as before; of
    /// another liquid it has learned the surface and the positions ([`KnownGroups::KINEMATICS`]).
    pub same_liquid: bool,
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
            parameters: CorrectionParameters::default(),
            liquid: String::from("corrected"),
            same_liquid: false,
            command: String::new(),
            quiet: false,
        }
    }
}

/// Corrected blob with its record; errors are slosh-relative, of the measured surface.
#[derive(Clone, Debug)]
pub struct Corrected {
    /// The bytes of the blob.
    pub blob: Vec<u8>,
    /// Error of the forecast of the held-out part 0.25 s ahead, before and after.
    pub held: [f64; 2],
    /// Error of the estimate of the source recordings, before and after.
    pub source: [f64; 2],
    /// Step and both errors of every candidate.
    pub looks: Vec<(usize, f64, f64)>,
    /// Candidates that were better on the held-out part but had forgotten too much.
    pub refused: usize,
}

/// Returns the groups that a model with the groups `before` knows after a correction.
fn known_after(before: KnownGroups, same_liquid: bool) -> KnownGroups {
    if same_liquid { before } else { before.both(KnownGroups::KINEMATICS) }
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
    let (blob, parameters) = (AlignedBytes::copy(blob), &how.parameters);
    let parts = CheckpointParts::new(&blob)?;
    let (learnt, held_out) = split(&freed(&blob, recordings)?, parameters.learnt_share)?;
    let sets = TrainingSets::new(&blob, &parts, &learnt, source, parameters)?;
    let judge = Judge { held_out: &held_out, source, frames: parameters.judged_frames };
    let mut choice = Choice::new(&blob, judge.errors(&blob)?, parameters.forgetting);
    let mut adaptation = Adaptation::new(&blob, &parts, &sets, how)?;

    let session = Session::new(how.quiet, stop);
    let bar = session.bar("correction", parameters.steps);
    for step in 0..parameters.steps {
        let loss = adaptation.step(step)?;
        if !looks_at(step, parameters.judge_every, parameters.steps) {
            continue;
        }
        let candidate = adaptation.candidate()?;
        let errors = judge.errors(&candidate)?;
        choice.consider(step + 1, candidate, errors);
        bar.show(step + 1, loss.max(0.0).sqrt(), errors.held_out);
        if session.stopped() {
            break;
        }
    }
    bar.finish();

    let Choice { blob: chosen, before, after, looks, refused, .. } = choice;
    // A model that nothing was learnt by keeps its intervals too: it is the same to the byte.
    let unchanged = chosen[..] == blob[..];
    let blob =
        if unchanged { chosen } else { interval::rescaled(&chosen, &held_out, parameters.max_widening)? };
    let (held, source) = ([before.held_out, after.held_out], [before.source, after.source]);
    Ok(Corrected { blob, held, source, looks, refused })
}
