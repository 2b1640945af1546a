//! Coverage of intervals: data drawn from the model itself, with effects drawn over their usual sizes, baseline and
//! errors from prior and covariance (Talts et al. 2018).

use super::error::StudyError;
use crate::baseline::calibrate::Calibration;
use crate::baseline::group::Group;
use crate::fitting::fit::{fit, fit_beside};
use crate::fitting::problem::Problem;
use crate::fitting::search::search;
use crate::recordings::load::load;
use meniscus::reduced::effects::{Active, Effect, EffectKind, LIBRARY};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::path::Path;

/// Draws of the test of intervals.
const DRAWS: usize = 160;

/// Returns the coverage of 90 % intervals by draws from the model as the references under `out` calibrate it, and the
/// number of draws; none where there are no references.
///
/// # Errors
/// [`StudyError`], when a reference cannot be used.
pub fn reference_coverage(out: &Path, seed: u64) -> Result<Option<(f64, usize)>, StudyError> {
    let mut groups = Vec::new();
    for index in 0.. {
        let path = out.join(format!("references/single-{index}"));
        if !path.join("setup.toml").exists() {
            break;
        }
        let folder = load(&path)?;
        groups.push(Group::new(folder.known, folder.records, None)?);
    }
    let Some((first, others)) = groups.split_first() else { return Ok(None) };
    let records = &first.split.fitted;
    let others: Vec<&Group> = others.iter().collect();
    let calibration = Calibration::from(&others, &first.known, records, None);
    let problem = Problem::new(records, first.known, &calibration, 1.0)?;
    Ok(Some((coverage(&problem, DRAWS, seed), DRAWS)))
}

/// Returns the place of an effect in the cycle of draws; `None` is not drawn. Drawn are effects of every class whose fit is smooth
/// over their usual sizes.
fn place(kind: EffectKind) -> Option<usize> {
    match kind {
        EffectKind::Viscosity => Some(0),
        EffectKind::WallSlip => Some(1),
        EffectKind::YieldStress => Some(2),
        EffectKind::Foam => Some(3),
        EffectKind::SurfaceTension => Some(4),
        EffectKind::ActuationGain => Some(5),
        EffectKind::CameraPitch => Some(6),
        EffectKind::CameraLatency => Some(7),
        EffectKind::SurfaceFilm
        | EffectKind::StuckLine
        | EffectKind::ShearThinning
        | EffectKind::ContactLine
        | EffectKind::PinnedLine
        | EffectKind::HeldTension
        | EffectKind::Viscoelastic
        | EffectKind::Detuning
        | EffectKind::Swirl
        | EffectKind::ContainerTilt
        | EffectKind::VerticalAcceleration
        | EffectKind::ActuationDelay
        | EffectKind::Fill
        | EffectKind::Radius
        | EffectKind::DepthScale
        | EffectKind::CameraSlope => None,
    }
}

/// Returns the effects whose first parameter is drawn, in the order of the cycle.
fn drawn() -> Vec<&'static Effect> {
    let mut all: Vec<_> = LIBRARY.iter().filter_map(|effect| Some((place(effect.kind)?, effect))).collect();
    all.sort_by_key(|(place, _)| *place);
    all.into_iter().map(|(_, effect)| effect).collect()
}

/// Returns the share of `trials` draws in which the 90 % interval of the effect's parameter held the truth.
#[must_use]
pub fn coverage(problem: &Problem, trials: usize, seed: u64) -> f64 {
    let drawn = drawn();
    let trial = |n: usize| usize::from(one(problem, drawn[n % drawn.len()], n, seed));
    let held: usize = (0..trials).into_par_iter().map(trial).sum();
    held as f64 / trials.max(1) as f64
}

/// Returns whether the interval of `entry` holds the truth in draw `n`.
fn one(problem: &Problem, entry: &'static Effect, n: usize, seed: u64) -> bool {
    let mut random = ChaCha8Rng::seed_from_u64(seed.wrapping_mul(0x9e37_79b9).wrapping_add(n as u64));
    let mut normal = move || meniscus_numerics::random::normal(&mut random);
    let parameter = &entry.parameters[0];
    let theta: Vec<f64> =
        problem.mean.iter().zip(&problem.deviation).map(|(m, s)| m + s * normal()).collect();
    let mut values = entry.neutral();
    values[0] += parameter.typical * (1.0 + 0.3 * normal().clamp(-2.0, 2.0));
    let truth = values[0];
    let drawn = problem.redraw(&theta, &[Active { entry, values }], &mut normal);
    let plain = fit(&drawn, &drawn.mean, &[], &[]);
    let (_, start, _) = search(&drawn, &plain, entry);
    let fitted = fit_beside(&drawn, &plain, entry, &start);
    let place = fitted.theta.len();
    let deviation = fitted.covariance().map_or(f64::INFINITY, |c| c[(place, place)].max(0.0).sqrt());
    (fitted.active[0].values[0] - truth).abs() <= 1.645 * deviation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_has_no_gap() {
        let places: Vec<_> = drawn().into_iter().filter_map(|effect| place(effect.kind)).collect();
        assert_eq!(places, (0..places.len()).collect::<Vec<_>>());
    }
}
