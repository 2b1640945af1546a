//! The whole identification: viscosity, then the law of flow, then the liquid with the sources of its numbers.

use super::by_simulation::BySimulation;
use super::measured::MeasuredRecording;
use super::viscosity::{Value, ViscosityFit, fit_viscosity};
use crate::error::RelearnError;
use crate::law::Law;
use crate::liquid_file::Sources;
use crate::liquid_source::LiquidSource;
use meniscus::reduced::effects::{Active, find};
use meniscus_data::effects::Effects;
use meniscus_data::liquids::{Liquid, Rheology};
use meniscus_data::recording::Glass;
use meniscus_discover::fitting::error::ProblemError;
use meniscus_discover::fitting::fit::{Fitted, Free, fit};
use meniscus_discover::recordings::record::Record;
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};
use serde::{Deserialize, Serialize};

/// Standard deviations on either side of a 90 % interval.
const DEVIATIONS: f64 = 1.645;

/// Identified liquid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Law of flow that was taken.
    pub law: Law,
    /// Viscosity or consistency, Pa s^n.
    pub consistency_pa_sn: Value,
    /// Flow index, where the law has one.
    pub index: Option<Value>,
    /// Yield stress, Pa, where the law has one.
    pub yield_stress_pa: Option<Value>,
    /// Viscosity below which the liquid lies, Pa s, where the recordings and the simulator cannot tell more.
    pub undetermined_below_pa_s: Option<f64>,
    /// Whitened misfit of the fit.
    pub misfit: f64,
    /// Gain in the information criterion over a constant viscosity.
    pub gain: f64,
    /// Recordings that were fitted.
    pub recordings: Vec<String>,
    /// Simulations by which the numbers were found; none where the reduced model alone was fitted.
    #[serde(default)]
    pub by_simulation: Option<BySimulation>,
}

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
        undetermined_below_pa_s: None,
        misfit,
        gain,
        recordings,
        by_simulation: None,
    }
}

impl Identified {
    /// Returns the liquid of `source` with these numbers, and the source of each.
    #[must_use]
    pub fn liquid(&self, source: &LiquidSource) -> Option<(Liquid, Sources)> {
        let LiquidSource::Identified { name, density_kg_m3, stated_viscosity_pa_s, .. } = source else {
            return None;
        };
        let (model, about) = match self.by_simulation {
            Some(_) => ("simulator", ""),
            None => ("reduced model", "roughly "),
        };
        let from = format!("fit of the {model} to {}", self.recordings.join(", "));
        let of =
            |value: &Value| format!("{from}; {about}{:.4} to {:.4}", value.interval[0], value.interval[1]);
        let mut viscosity = (self.consistency_pa_sn.best, of(&self.consistency_pa_sn));
        if let Some(below) = self.undetermined_below_pa_s {
            let undetermined = format!("{from}; undetermined, below {below:.4}");
            viscosity = match stated_viscosity_pa_s.filter(|stated| *stated < below) {
                Some(stated) => (stated, format!("as stated; {undetermined}")),
                None => (viscosity.0, undetermined),
            };
        }
        let rheology = match (self.index, self.yield_stress_pa) {
            (None, None) => Rheology::newtonian(viscosity.0),
            (index, stress) => Rheology {
                consistency: viscosity.0,
                index: index.map_or(1.0, |value| value.best),
                yield_stress: stress.map_or(0.0, |value| value.best),
                largest: Rheology::newtonian(viscosity.0).largest,
            },
        };
        let liquid = Liquid {
            name: name.clone(),
            density_kg_m3: *density_kg_m3,
            rheology,
            effects: Effects::default(),
        };
        let absent = || String::from("not part of the law");
        let sources = Sources {
            density: "as stated".into(),
            viscosity: viscosity.1,
            index: self.index.as_ref().map_or_else(absent, of),
            yield_stress: self.yield_stress_pa.as_ref().map_or_else(absent, of),
        };
        Some((liquid, sources))
    }

    /// Returns the result in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let about = if self.by_simulation.is_some() { "" } else { "roughly " };
        let of = |value: &Value| {
            format!("{:.4} ({about}{:.4} to {:.4})", value.best, value.interval[0], value.interval[1])
        };
        let mut text = match self.undetermined_below_pa_s {
            Some(below) => format!(
                "viscosity undetermined, below {below:.4} Pa s ({:.4} fits best, and is simulated unless a lower one is stated)",
                self.consistency_pa_sn.best
            ),
            None if self.index.is_some() => format!("consistency {} Pa s^n", of(&self.consistency_pa_sn)),
            None => format!("viscosity {} Pa s", of(&self.consistency_pa_sn)),
        };
        text += &self.index.as_ref().map_or(String::new(), |value| format!(", flow index {}", of(value)));
        let stress = self.yield_stress_pa.as_ref();
        text += &stress.map_or(String::new(), |value| format!(", yield stress {} Pa", of(value)));
        if let Some(by) = &self.by_simulation {
            text += &format!(
                ", by {} simulations; the reduced model alone gives {:.4}",
                by.simulations, by.reduced_pa_sn.best
            );
        }
        text
    }
}
