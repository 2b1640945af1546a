//! Widening of the intervals of a corrected blob.
//!
//! ```text
//! share of |z - estimate| <= c half over the held-out points is to be 90 %,    1 <= c <= the largest widening
//! ```
//! The truth is not known, but how far a measurement lies from the estimate is. The filter has followed these very heights, so
//! that they may ask for wider intervals and never for narrower ones. The factor c goes to every k of the blob alike, because
//! nothing but the surface has been seen of the new liquid.

use crate::TrainError;
use crate::calibration::ratios::HELD;
use crate::correct::effects::with_effects;
use crate::correct::judge::Subset;
use meniscus::runtime::Mode;

use meniscus_data::blob_file::{factors, read, write};
use meniscus_numerics::statistics::quantile;
use meniscus_platform::files::AlignedBytes;
use meniscus_virtual::observe_recording::turns;

/// Returns `blob` with its intervals widened until they cover the held-out heights as often as they state.
///
/// # Errors
/// [`TrainError`], when the blob is refused.
pub(super) fn rescaled(blob: &[u8], held: &Subset, max_widening: f32) -> Result<Vec<u8>, TrainError> {
    let aligned = AlignedBytes::copy(blob);
    let mut model = with_effects(&aligned)?;
    // How much an interval widens depends on the factors, which are yet to change.
    model.error_model.factors.disagreement = f32::MAX;
    let mut ratios = Vec::new();
    for seen in &held.all {
        for (logged, profile) in turns(&model, seen).iter().zip(seen).skip(held.from) {
            let estimate = &logged.turn.estimate;
            let (Some(profile), Mode::Tracking) = (profile, estimate.mode) else { continue };
            for point in (0..profile.valid.len()).filter(|&point| profile.valid[point]) {
                let miss = (profile.height_m[point] - estimate.surface_m[point]).abs();
                // The factor at which this point is just held.
                ratios.push(miss / estimate.interval.surface_m[point].max(f32::MIN_POSITIVE));
            }
        }
    }
    let Some(factor) = quantile(ratios, HELD) else { return Ok(blob.to_vec()) };
    let (header, mut parts) = read::parts(&aligned)?;
    let wider = factor.clamp(1.0, max_widening);
    factors::change(&mut parts, |of| of.quantiles_mut().for_each(|k| *k *= wider));
    Ok(write::blob(header, &parts)?)
}
