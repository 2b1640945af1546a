//! The whole identification: viscosity, then the law of flow, then the liquid with the sources of its numbers.

use super::identified::Identified;
use super::measured::MeasuredRecording;
use super::viscosity::{Value, ViscosityFit, fit_viscosity};
use crate::error::RelearnError;
use crate::law::Law;
use meniscus::reduced::effects::{Active, find};
use meniscus_data::recording::Glass;
use meniscus_discover::fitting::error::ProblemError;
use meniscus_discover::fitting::fit::{Fitted, Free, fit};
use meniscus_discover::recordings::record::Record;
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};

/// Standard deviations on either side of a 90 % interval.
const DEVIATIONS: f64 = 1.645;

/// Identifies the liquid in `measured`, of this density, in `glass`.
///
/// # Errors
/// [`RelearnError::Identify`], when the recordings cannot be fitted.
pub fn identify(
    measured: &[MeasuredRecording],
    glass: &Glass,
    density_kg_m3: f64,
    law: Law,
) -> Result<Identified, RelearnError> {
    let records: Vec<Record> = measured.iter().map(|one| one.record.clone()).collect();
    Ok(identify_records(&records, &stated(glass, density_kg_m3), law)?)
}

/// The glass and the density as stated; the viscosity is the unknown.
pub(crate) fn stated(glass: &Glass, density_kg_m3: f64) -> Known {
    Known {
        radius_m: glass.radius_m,
        radius_error_m: CALLIPERS_M,
        fill_m: glass.fill_m,
        density_kg_m3,
        viscosity_pa_s: 1.0,
        motion_share: [1.0; 2],
    }
}

/// Identifies the liquid in `records`; the viscosity of `known` is not used.
pub(super) fn identify_records(
    records: &[Record],
    known: &Known,
    law: Law,
) -> Result<Identified, ProblemError> {
    let density_kg_m3 = known.density_kg_m3;
    let plain = fit_viscosity(records, known)?;
    let count = plain.problem.count();
    let recordings = records.iter().map(|record| record.name.clone()).collect();
    if law == Law::Newtonian {
        return Ok(newtonian(&plain, density_kg_m3, recordings));
    }
    let fitted = with_law(&plain, law);
    // The viscosity is free in both.
    let parameters = fitted.free.len() as f64 - 1.0;
    let gain = plain.cost - fitted.cost - parameters * (count as f64).ln();
    Ok(with_parameters(&plain, law, &fitted, gain, recordings))
}

/// A constant viscosity.
fn newtonian(plain: &ViscosityFit, density_kg_m3: f64, recordings: Vec<String>) -> Identified {
    let value = plain.viscosity_pa_s;
    Identified {
        law: Law::Newtonian,
        consistency_pa_sn: value,
        index: None,
        yield_stress_pa: None,
        stress: None,
        undetermined_below_pa_s: value.bound(density_kg_m3),
        misfit: plain.misfit,
        gain: 0.0,
        recordings,
        by_simulation: None,
    }
}

/// Fits the parameters of `law` beside the viscosity, from where a constant one fits best.
fn with_law(plain: &ViscosityFit, law: Law) -> Fitted {
    let start = |name: &str| {
        let entry = find(name)?;
        let first = match name {
            "shear_thinning" => 0.8,
            "yield_stress" => 1.0,
            _ => entry.parameters[0].neutral,
        };
        Some(Active { entry, values: [first, 0.0] })
    };
    let active: Vec<Active> =
        std::iter::once("viscosity").chain(law.effects().iter().copied()).filter_map(start).collect();
    let free: Vec<Free> = (0..active.len()).map(|effect| (effect, 0)).collect();
    fit(&plain.problem, &plain.theta, &active, &free)
}

/// Values and intervals of a fit with effects.
fn with_parameters(
    plain: &ViscosityFit,
    law: Law,
    fitted: &Fitted,
    gain: f64,
    recordings: Vec<String>,
) -> Identified {
    let misfit = fitted.chi2(plain.problem.count());
    let covariance = fitted.covariance();
    let (stated, density) = (plain.problem.known.stated(), plain.problem.known.density_kg_m3);
    let value = |name: &str| {
        let effect = fitted.active.iter().position(|active| active.entry.name == name)?;
        let parameter = &fitted.active[effect].entry.parameters[0];
        let (best, row) = (fitted.active[effect].values[0], fitted.theta.len() + effect);
        let deviation = covariance.as_ref().map_or(f64::INFINITY, |c| c[(row, row)].max(0.0).sqrt());
        let half = DEVIATIONS * deviation * misfit.max(1.0).sqrt();
        let (least, most) = parameter.range;
        let si = |coordinate: f64| parameter.to_value(coordinate, &stated);
        let interval = [(best - half).max(least), (best + half).min(most)].map(si);
        Some(Value { best: si(best), interval })
    };
    Identified {
        law,
        consistency_pa_sn: value("viscosity")
            .map_or(plain.viscosity_pa_s, |value| value.with_model_error(density)),
        index: value("shear_thinning"),
        yield_stress_pa: value("yield_stress"),
        stress: None,
        undetermined_below_pa_s: None,
        misfit,
        gain,
        recordings,
        by_simulation: None,
    }
}
