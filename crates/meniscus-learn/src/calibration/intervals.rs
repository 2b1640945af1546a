//! Calibration of the intervals from runs of a blob: g from one that has none, then the factors k from one with k = 1, then theta
//! from one that has k.
//!
//! ```text
//! g^2   = mean of (truth - estimate)^2 - half^2 over the heights while H < REST, nought at least
//! k     = 90 % quantile of |truth - estimate| / half over all numbers of all recordings held out
//! theta = 90 % quantile of rho over all turns of theirs (`meniscus::uncertainty::disagreement`)
//! ```
//! (Split conformal prediction: Lei et al., J. Am. Stat. Assoc. 113 (2018) 1094.) What is exchangeable is the
//! recording and not the number: errors of one slosh go together, so that a quantile over the numbers of two recordings held
//! 82 % of a third. Of fewer than [`MANY`] recordings k is therefore the largest of their own quantiles, and of as many it is
//! reported what a recording has held by the k of all others. Of forecasts without a plan it is the largest always: what they
//! miss is how the glass was moved on, and kinds of motion are few. The runs are those of the camera side behind the rendered camera, so that everything
//! between glass and estimate is counted.

use crate::calibration::camera_views::CameraView;
use crate::calibration::error_model::REST;
use crate::calibration::ratios::{Ratios, quantile, ratios_by_recording, share};
use crate::data::errors::percent;
use meniscus::blob::{LoadError, Model};
use meniscus::runtime::{InputSource, Mode};
use meniscus::uncertainty::error_factors::{ErrorFactors, LEADS};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::GROUP_NAMES;
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::score;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::{turns, turns_with};

/// Smallest number of recordings for a quantile over all of them.
const MANY: usize = 10;

/// Errors of an estimate over all recordings: q, v, sigma, tau and, relative to the slosh, the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EstimateErrors([f64; 5]);

impl EstimateErrors {
    /// Slosh-relative error of the surface.
    pub(crate) fn surface(&self) -> f64 {
        let [.., surface] = self.0;
        surface
    }

    /// One check for each error, named `name: group`, against `targets` in per cent.
    pub(crate) fn checks(&self, name: &str, targets: [Option<f64>; 5]) -> Vec<Check> {
        let names = ["q", "v", "sigma", "tau", "surface slosh-rel"];
        let all = names.iter().zip(self.0).zip(targets);
        all.map(|((group, error), target)| percent(format!("{name}: {group}"), error, target)).collect()
    }
}

/// Errors of surface and field of the estimates of `blob`: roots of the mean squares over the recordings.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn errors(blob: &[u8], views: &[CameraView<'_>]) -> Result<EstimateErrors, LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    // The internal energy is left out: no latent carries it.
    let mut squares = [0.0; 5];
    for (recording, seen) in views {
        let linear = linear_with_motion(recording);
        let score = score(&model, recording, &linear, &turns(&model, seen), START);
        let [q, v, _, sigma, tau] = score.field;
        for (sum, error) in squares.iter_mut().zip([q, v, sigma, tau, score.estimate.slosh_rel()]) {
            *sum += error * error / views.len() as f64;
        }
    }
    Ok(EstimateErrors(squares.map(f64::sqrt)))
}

/// Returns the rest noise g in metres, for the blob whose k are all one and which has no g.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn rest_noise_m(blob: &[u8], views: &[CameraView<'_>]) -> Result<f32, LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let (mut square, mut count) = (0.0, 0.0_f64);
    for (recording, seen) in views {
        for (frame, logged) in turns(&model, seen).iter().enumerate() {
            let estimate = &logged.turn.estimate;
            if estimate.mode != Mode::Tracking
                || model.generic.potential.value(&estimate.latent.into()) > REST
            {
                continue;
            }
            let said = estimate.surface_m.iter().zip(estimate.interval.surface_m);
            for (truth, (said, half)) in recording.profile(frame).iter().zip(said) {
                square += f64::from(truth - said).powi(2) - f64::from(half).powi(2);
                count += 1.0;
            }
        }
    }
    Ok((square / count.max(1.0)).max(0.0).sqrt() as f32)
}

/// Factors of all intervals, and their coverage of recordings left out.
pub(crate) struct IntervalFactors {
    /// k of all intervals, in the order of [`ErrorFactors::quantiles`].
    pub(crate) k: [f32; ErrorFactors::QUANTILES],
    /// Coverage of a recording's present heights by the k of all others, least and mean, of [`MANY`] recordings or more.
    pub(crate) left_out: Vec<Check>,
}

/// Returns the factors for the blob whose k are all one.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn interval_factors(blob: &[u8], views: &[CameraView<'_>]) -> Result<IntervalFactors, LoadError> {
    let mut k = [if views.is_empty() { 1.0_f32 } else { 0.0 }; ErrorFactors::QUANTILES];
    let by_recording = ratios_by_recording(blob, views)?;
    let left_out = left_out(&by_recording);
    let mut together: [Vec<f32>; ErrorFactors::QUANTILES] = Default::default();
    for of_one in by_recording {
        let all = of_one.by_interval();
        for (index, ((k, together), ratios)) in k.iter_mut().zip(&mut together).zip(all).enumerate() {
            if views.len() < MANY || is_unplanned(index) {
                *k = k.max(quantile(ratios));
            } else {
                together.extend(ratios);
            }
        }
    }
    for (k, ratios) in k.iter_mut().zip(together).filter(|(_, ratios)| !ratios.is_empty()) {
        *k = quantile(ratios);
    }
    Ok(IntervalFactors { k, left_out })
}

/// Returns theta for the blob with its k, and without a theta: that of all turns, or the largest of fewer than [`MANY`] recordings.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn disagreement(blob: &[u8], views: &[CameraView<'_>]) -> Result<f32, LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let (mut largest, mut together) = (ErrorFactors::LEAST_DISAGREEMENT, Vec::new());
    for (_, seen) in views {
        let mut of_one = Vec::new();
        turns_with(
            &model,
            seen,
            |_| InputSource::Tracked,
            |_, memory, estimate| {
                if estimate.mode == Mode::Tracking {
                    of_one.push(memory.disagreement() as f32);
                }
            },
        );
        if views.len() < MANY {
            largest = largest.max(quantile(of_one));
        } else {
            together.extend(of_one);
        }
    }
    Ok(largest.max(quantile(together)))
}

/// Whether the factor at `index` is that of a forecast without a plan.
fn is_unplanned(index: usize) -> bool {
    (1..LEADS.len()).contains(&index)
}

/// Shares of each recording's heights that the k of all others hold: the least, and the mean.
fn left_out(by_recording: &[Ratios]) -> Vec<Check> {
    if by_recording.len() < MANY {
        return Vec::new();
    }
    let now = |ratios: &Ratios| -> Vec<f32> { ratios.surface[0].clone() };
    let shares = (0..by_recording.len()).map(|one| {
        let others = by_recording.iter().enumerate().filter(|(other, _)| *other != one);
        let k = quantile(others.flat_map(|(_, ratios)| now(ratios)).collect());
        share(&now(&by_recording[one]), k)
    });
    let shares: Vec<f64> = shares.collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    vec![
        Check::informational(
            "interval: surface held of a recording left out, least",
            shares.iter().copied().fold(100.0, f64::min),
            "%",
        ),
        Check::informational("interval: surface held of a recording left out, mean", mean, "%"),
    ]
}

/// Returns the coverage of the intervals of a calibrated blob.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn coverage(blob: &[u8], views: &[CameraView<'_>]) -> Result<Vec<Check>, LoadError> {
    let mut together: [Vec<f32>; ErrorFactors::QUANTILES] = Default::default();
    for of_one in ratios_by_recording(blob, views)? {
        together.iter_mut().zip(of_one.by_interval()).for_each(|(all, of_one)| all.extend(of_one));
    }
    let shares = interval_names().into_iter().zip(&together).filter(|(_, ratios)| !ratios.is_empty());
    Ok(shares.map(|(name, ratios)| Check::informational(name, share(ratios, 1.0), "%")).collect())
}

/// Names of the coverages, in the order of [`ErrorFactors::quantiles`].
fn interval_names() -> Vec<String> {
    let ahead = |lead: &usize| format!("interval, {:.2} s ahead", *lead as f64 * FRAME_INTERVAL_S);
    let unplanned = LEADS.iter().map(|lead| format!("{}: surface held", ahead(lead)));
    let groups = GROUP_NAMES.iter().map(|name| format!("interval: {name} held"));
    let planned = LEADS[1..].iter().map(|lead| format!("{}, motion planned: surface held", ahead(lead)));
    let crest = "interval, next crest, motion planned: height held".to_owned();
    unplanned.chain(groups).chain(planned).chain([crest]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nine alike hold what one of them holds; the tenth, whose errors are twice as large, is held as far as theirs go.
    #[test]
    fn a_recording_left_out_is_judged_by_the_others() {
        let one = |times: f32| {
            let mut ratios = Ratios::default();
            ratios.surface[0] = (1..=100).map(|k| times * k as f32).collect();
            ratios
        };
        let mut all: Vec<_> = (1..MANY).map(|_| one(1.0)).collect();
        assert!(left_out(&all).is_empty(), "nine recordings are too few");
        all.push(one(2.0));
        let shares = left_out(&all);
        let [least, mean] = [0, 1].map(|index| shares[index].value);
        // Of 800 numbers up to 100 and 100 up to 200 nine in ten are at most 96, of 900 up to 100 at most 90.
        assert_eq!(least, Some(45.0));
        assert!((mean.unwrap_or_default() - (9.0 * 96.0 + 45.0) / 10.0).abs() < 1e-9, "{mean:?}");
        assert!(
            is_unplanned(1)
                && is_unplanned(LEADS.len() - 1)
                && !is_unplanned(0)
                && !is_unplanned(LEADS.len())
        );
        assert_eq!(interval_names().len(), ErrorFactors::QUANTILES);
    }
}
