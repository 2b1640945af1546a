//! How wide the intervals of a corrected blob must be.
//!
//! ```text
//! share of |z - estimate|^2 <= (c half)^2 + (1.645 s)^2 over the held-out points is to be 90 %
//! ```
//! with s the standard deviation of each measured height: the truth is not known, but how far a measurement
//! lies from it is. The factor c goes to every k of the blob alike, because nothing but the surface has been
//! seen of the new liquid.

use super::Sightings;
use crate::host::files::AlignedBytes;
use crate::interval::REACH;
use crate::model::{Model, Tensor};
use crate::offline::prelude::*;
use crate::offline::train::TrainError;
use crate::offline::train::calibrate::HELD;
use crate::offline::watching::turns;
use crate::offline::{export, import};
use crate::runtime::Mode;

/// Standard deviations that hold 90 % of a normal variable.
const NORMAL: f64 = 1.645;

/// `blob` with its intervals scaled to what `held` shows from frame `from` on.
///
/// # Errors
/// [`TrainError`], when the blob is refused.
pub(super) fn rescaled(blob: &[u8], held: &[Sightings], from: usize) -> Result<Vec<u8>, TrainError> {
    let aligned = AlignedBytes::copy(blob);
    let model = Model::load(&aligned)?;
    let mut factors = Vec::new();
    for seen in held {
        for (logged, profile) in turns(&model, seen).iter().zip(seen).skip(from) {
            let estimate = &logged.turn.estimate;
            let (Some(profile), Mode::Tracking) = (profile, estimate.mode) else { continue };
            for point in (0..profile.valid.len()).filter(|&point| profile.valid[point]) {
                let miss = f64::from(profile.height_m[point] - estimate.surface_m[point]);
                let noise2 = NORMAL * NORMAL * f64::from(profile.variance_m2[point]);
                let half = f64::from(estimate.interval.surface_m[point]);
                // The factor at which this point is just held.
                factors.push((miss * miss - noise2).max(0.0).sqrt() / half.max(f64::MIN_POSITIVE));
            }
        }
    }
    if factors.is_empty() {
        return Ok(blob.to_vec());
    }
    let at = ((factors.len() as f64 * HELD).ceil() as usize).clamp(1, factors.len()) - 1;
    let (_, factor, _) = factors.select_nth_unstable_by(at, f64::total_cmp);
    let (header, mut parts) = import::parts(&aligned)?;
    for part in parts.iter_mut().filter(|part| part.tensor == Tensor::Reach) {
        // The first number is the floor of w.
        part.values.iter_mut().take(REACH).skip(1).for_each(|k| *k *= factor.clamp(0.25, 20.0) as f32);
    }
    Ok(export::blob(header, &parts)?)
}
