//! Judgement of the second laboratory's trials by the workflow, against references of the same laboratory.

use super::camera::{Faults, records};
use super::glass::{DENSITY_KG_M3, FILL_M, LaboratoryGlass, RADIUS_M};
use super::trials::{LaboratoryTrial, TrialPurpose, VISCOSITY_PA_S, motions, references};
use crate::baseline::group::Group;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::recordings::stated::{CALLIPERS_M, Known};
use crate::study::error::StudyError;
use crate::workflow::discover;
use meniscus::reduced::effects::LIBRARY;
use serde::{Deserialize, Serialize};

/// Outcome of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaboratoryOutcome {
    /// TrialPurpose.
    pub purpose: TrialPurpose,
    /// Name of the effect or force; empty where nothing is hidden.
    pub hidden: String,
    /// Its size in reference sizes.
    pub size: f64,
    /// Its coordinate in the library.
    pub truth: Option<f64>,
    /// Verdict in one word.
    pub verdict: String,
    /// Names of the verdict.
    pub names: Vec<String>,
    /// Class of the verdict.
    pub class: Option<String>,
    /// Value, least and largest value of the first effect's first coordinate, meant for 90 %.
    pub estimate: Option<[f64; 3]>,
    /// Errors on the held-out recording, mm: untouched, and with the verdict's effect.
    pub gap_mm: Option<[f64; 2]>,
    /// Misfit with the verdict's effect.
    pub misfit: f64,
}

/// References of the laboratory with the thresholds that they set.
pub struct LaboratoryBench {
    groups: Vec<Group>,
    limits: Thresholds,
}

impl LaboratoryBench {
    /// Makes and fits all references.
    ///
    /// # Errors
    /// [`StudyError`], when one cannot be fitted.
    pub fn new() -> Result<Self, StudyError> {
        Self::of(&references())
    }

    /// Makes and fits the references in `glasses`, each with the seed of its noise.
    fn of(glasses: &[(LaboratoryGlass, u64)]) -> Result<Self, StudyError> {
        let plans = motions();
        let mut groups = Vec::new();
        for (glass, seed) in glasses {
            let stated = known(glass.liquid.consistency);
            groups.push(Group::new(stated, records(glass, &plans, &Faults::NONE, FILL_M, *seed), None)?);
        }
        let limits = thresholds(&groups.iter().collect::<Vec<_>>(), &Settings::default())?;
        Ok(Self { groups, limits })
    }

    /// Judges `trial`.
    ///
    /// # Errors
    /// [`StudyError`], when the recordings cannot be fitted.
    pub fn judge(&self, trial: &LaboratoryTrial) -> Result<LaboratoryOutcome, StudyError> {
        let library = LIBRARY.iter().filter(|entry| !trial.same.contains(&entry.name)).collect();
        let settings = Settings { library, ..Settings::default() };
        let groups: Vec<&Group> = self.groups.iter().collect();
        let recordings = records(&trial.glass, &motions(), &trial.faults, FILL_M, trial.seed);
        let found = discover(&recordings, known(VISCOSITY_PA_S), &groups, &self.limits, &settings)?;
        let verdict = &found.assessment.verdict;
        let gap = found.gap.as_ref().map(|measured| measured.gap);
        Ok(LaboratoryOutcome {
            purpose: trial.purpose,
            hidden: trial.name.into(),
            size: trial.size,
            truth: trial.truth,
            verdict: verdict.word().into(),
            names: verdict.names().iter().map(|name| String::from(*name)).collect(),
            class: verdict.class().map(|class| class.words().into()),
            estimate: found.estimates.first().map(|estimate| {
                let (value, (least, largest)) = estimate.coordinate;
                [value, least, largest]
            }),
            gap_mm: gap.map(|gap| [gap.untouched, gap.effect].map(|m| 1e3 * m)),
            misfit: verdict.misfit(),
        })
    }
}

/// Returns glass and liquid as they are stated.
fn known(viscosity_pa_s: f64) -> Known {
    Known {
        radius_m: RADIUS_M,
        radius_error_m: CALLIPERS_M,
        fill_m: FILL_M,
        density_kg_m3: DENSITY_KG_M3,
        viscosity_pa_s,
        motion_share: [1.0; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::super::trials::laboratory_trials;
    use super::*;

    #[test]
    fn a_tension_is_named_at_its_size_and_a_clean_glass_is_none() {
        let bench = LaboratoryBench::of(&references()[..4]).expect("references");
        let trials = laboratory_trials();
        let judged = |wanted: &dyn Fn(&&LaboratoryTrial) -> bool| {
            bench.judge(trials.iter().find(wanted).expect("there")).expect("judged")
        };
        let tension = judged(&|trial| trial.name == "surface_tension" && trial.size == 2.0);
        assert!(tension.verdict == "named" && tension.names == ["surface_tension"], "{tension:?}");
        let [value, ..] = tension.estimate.expect("a size");
        assert!((value / 0.3 - 1.0).abs() < 0.15, "{value} N/m for 0.3");
        let [untouched, effect] = tension.gap_mm.expect("a gap");
        assert!(effect < 0.2 * untouched, "{untouched} to {effect} mm");
        let clean = judged(&|trial| trial.purpose == TrialPurpose::Clean);
        assert_eq!(clean.verdict, "none", "{clean:?}");
    }
}
