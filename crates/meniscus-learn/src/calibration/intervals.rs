//! What the intervals take from runs of a blob: g from one that has none, then the factors k from one with k = 1.
//!
//! ```text
//! g^2 = mean of (truth - estimate)^2 - half^2 over the heights while H < REST, nought at least
//! k   = 90 % quantile of |truth - estimate| / half over all numbers of all recordings held out
//! ```
//! (Split conformal prediction: Lei et al., J. Am. Stat. Assoc. 113 (2018) 1094.) What is exchangeable is the
//! recording and not the number: errors of one slosh go together, so that a quantile over the numbers of two recordings held
//! 82 % of a third. Of fewer than [`MANY`] recordings k is therefore the largest of their own quantiles, and of as many it is
//! told what a recording has held by the k of all others. Of the forecasts it is the largest always: what they miss is how the
//! glass was moved on, and kinds of motion are few. The runs are those of the camera side behind the rendered camera, so that everything
//! between glass and estimate is counted.

use crate::calibration::error_model::{REST, UNIT};
use crate::calibration::measure::percent;
use crate::calibration::ratios::{Ratios, quantile, ratios_by_recording, share};
use meniscus::blob::{LoadError, Model};
use meniscus::runtime::Mode;
use meniscus::surface::{ConfigError, SurfaceProfile};
use meniscus::uncertainty::error_model::{LEADS, REACH};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::{GROUP_NAMES, Recording};
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::score;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, sightings, turns};
use meniscus_virtual::render::SceneSettings;

/// Recordings from which on a quantile over all of them is believed.
const MANY: usize = 10;

/// A recording and what the camera saw of it.
pub(crate) type Look<'r> = (&'r Recording, Vec<Option<SurfaceProfile>>);

/// What the camera sees of `recordings` with `times` the noise that estimates are judged by, 2 mm of depth.
///
/// # Errors
/// [`ConfigError`], when the glass of a recording cannot be looked at.
pub(crate) fn looks(recordings: &[Recording], times: f64, seed: u64) -> Result<Vec<Look<'_>>, ConfigError> {
    let disparity_rms_px = times * DISPARITY_RMS_PX;
    let mut all = Vec::new();
    for recording in recordings {
        let scene = SceneSettings { disparity_rms_px, seed, ..SceneSettings::of(&recording.glass) };
        all.push((recording, sightings(recording, scene)?));
    }
    Ok(all)
}

/// Errors of surface and field of the estimates of `blob`, under `name`, and the slosh-relative error of the surface: the
/// root of the mean square over the recordings.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn errors(
    blob: &[u8],
    looks: &[Look<'_>],
    (name, targets): (&str, [Option<f64>; 5]),
) -> Result<(Vec<Check>, f64), LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    // q, v, sigma, tau, surface; the internal energy is nothing that a latent carries.
    let mut squares = [0.0; 5];
    for (recording, seen) in looks {
        let linear = linear_with_motion(recording);
        let score = score(&model, recording, &linear, &turns(&model, seen), START);
        let [q, v, _, sigma, tau] = score.field;
        for (sum, error) in squares.iter_mut().zip([q, v, sigma, tau, score.estimate.slosh_rel()]) {
            *sum += error * error / looks.len() as f64;
        }
    }
    let errors = squares.map(f64::sqrt);
    let names = ["q", "v", "sigma", "tau", "surface slosh-rel"];
    let checks = names.iter().zip(errors).zip(targets);
    let checks = checks.map(|((group, error), target)| percent(format!("{name}: {group}"), error, target));
    let [.., surface] = errors;
    Ok((checks.collect(), surface))
}

/// g, m, for the blob whose k are all one and which has no g.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn grain(blob: &[u8], looks: &[Look<'_>]) -> Result<f32, LoadError> {
    let blob = AlignedBytes::copy(blob);
    let model = Model::load(&blob)?;
    let (mut square, mut count) = (0.0, 0.0_f64);
    for (recording, seen) in looks {
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

/// What [`reach`] has found.
pub(crate) struct Reach {
    /// k of the surface at each lead and of q, v, e, sigma, tau.
    pub(crate) k: [f32; REACH - 1],
    /// What a recording's heights of the present are held by the k of all others: least and mean; of [`MANY`] recordings.
    pub(crate) left_out: Vec<Check>,
}

/// The factors for the blob whose k are all one.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn reach(blob: &[u8], looks: &[Look<'_>]) -> Result<Reach, LoadError> {
    let mut k = if looks.is_empty() { UNIT } else { [0.0_f32; REACH - 1] };
    let by_recording = ratios_by_recording(blob, looks)?;
    let left_out = left_out(&by_recording);
    let mut together: [Vec<f32>; REACH - 1] = Default::default();
    for of_one in by_recording {
        let all = of_one.surface.into_iter().chain(of_one.field);
        for (index, ((k, together), ratios)) in k.iter_mut().zip(&mut together).zip(all).enumerate() {
            if looks.len() < MANY || foretells(index) {
                *k = k.max(quantile(ratios));
            } else {
                together.extend(ratios);
            }
        }
    }
    for (k, ratios) in k.iter_mut().zip(together).filter(|(_, ratios)| !ratios.is_empty()) {
        *k = quantile(ratios);
    }
    Ok(Reach { k, left_out })
}

/// Whether the factor at `index` is that of a forecast.
fn foretells(index: usize) -> bool {
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
        Check::told(
            "interval: surface held of a recording left out, least",
            shares.iter().copied().fold(100.0, f64::min),
            "%",
        ),
        Check::told("interval: surface held of a recording left out, mean", mean, "%"),
    ]
}

/// Shares of the truth that the intervals of a finished blob hold.
///
/// # Errors
/// [`LoadError`], when the blob is refused.
pub(crate) fn held(blob: &[u8], looks: &[Look<'_>]) -> Result<Vec<Check>, LoadError> {
    let mut ratios = Ratios::default();
    for of_one in ratios_by_recording(blob, looks)? {
        ratios.surface.iter_mut().zip(of_one.surface).for_each(|(all, of_one)| all.extend(of_one));
        ratios.field.iter_mut().zip(of_one.field).for_each(|(all, of_one)| all.extend(of_one));
    }
    let leads = LEADS.iter().zip(&ratios.surface).map(|(lead, ratios)| {
        (
            format!("interval, {:.2} s ahead: surface held", *lead as f64 * FRAME_INTERVAL_S),
            share(ratios, 1.0),
        )
    });
    let groups = GROUP_NAMES.iter().zip(&ratios.field);
    let groups = groups.map(|(name, ratios)| (format!("interval: {name} held"), share(ratios, 1.0)));
    Ok(leads.chain(groups).map(|(name, share)| Check::told(name, share, "%")).collect())
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
        assert!(left_out(&all).is_empty(), "of nine nothing is told");
        all.push(one(2.0));
        let told = left_out(&all);
        let [least, mean] = [0, 1].map(|index| told[index].value);
        // Of 800 numbers up to 100 and 100 up to 200 nine in ten are at most 96, of 900 up to 100 at most 90.
        assert_eq!(least, Some(45.0));
        assert!((mean.unwrap_or_default() - (9.0 * 96.0 + 45.0) / 10.0).abs() < 1e-9, "{mean:?}");
        assert!(foretells(1) && foretells(LEADS.len() - 1) && !foretells(0) && !foretells(LEADS.len()));
    }
}
