//! Judgement of the trials by the workflow, and comparison of the law that is found with the hidden one.

use super::laws::HiddenLaw;
use super::recordings::{glass, known, records};
use super::solver::Glass;
use super::trials::{LawTrial, Library, Purpose, VISCOSITY_PA_S};
use crate::baseline::group::Group;
use crate::decision::settings::Settings;
use crate::decision::thresholds::{Thresholds, thresholds};
use crate::decision::verdict::Verdict;
use crate::law::band::{Bands, CALIBRATION, Calibrated};
use crate::law::draw::{Drawn, drawn};
use crate::study::error::StudyError;
use crate::workflow::discover;
use meniscus::reduced::effects::{Entry, LIBRARY};
use serde::{Deserialize, Serialize};

/// Viscosities of the references, Pa s.
const REFERENCES_PA_S: [f64; 7] = [0.2, 0.2, 0.17, 0.235, 0.2, 0.17, 0.235];

/// Outcome of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawOutcome {
    /// Purpose.
    pub purpose: Purpose,
    /// Name of the hidden law; nothing where none is hidden.
    pub law: String,
    /// Its size.
    pub size: f64,
    /// Library.
    pub library: Library,
    /// Verdict in one word, and its names.
    pub verdict: String,
    /// Names of the verdict.
    pub names: Vec<String>,
    /// Whether the workflow drew a law.
    pub is_drawn: bool,
    /// Reason for which no law is drawn, where the verdict is unknown.
    pub refused: Option<String>,
    /// Law that was found, whatever the verdict is.
    pub found: Option<FoundLaw>,
}

/// A law that was found, beside the hidden one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FoundLaw {
    /// Errors on the held-out recording, mm: untouched, refitted, black box, with the law.
    pub gap_mm: [f64; 4],
    /// Largest distance of the true force and of the true drag from the middle of the bands, in half-widths.
    pub distance: [f64; 2],
    /// Mean half-width of the bands, as a part of the largest force and of the largest drag of the truth.
    pub width: [f64; 2],
    /// Least friction at any rate, N s/m.
    pub least_friction: f64,
    /// Misfit with the law.
    pub misfit: f64,
    /// Nearest formula.
    pub nearest: Option<String>,
    /// Whether the law departs from it by more than a band.
    pub departs: bool,
}

/// References of the other solver with the thresholds that they set.
pub struct LawBench {
    groups: Vec<Group>,
    limits: Thresholds,
}

impl LawBench {
    /// Fits all references.
    ///
    /// # Errors
    /// [`StudyError`], when one cannot be fitted.
    pub fn new() -> Result<Self, StudyError> {
        let one = |(number, viscosity_pa_s): (usize, &f64)| {
            let seed = 1 + number as u64;
            Ok(Group::new(
                known(*viscosity_pa_s),
                records(&glass(*viscosity_pa_s, seed), None, 1.0, seed),
                None,
            )?)
        };
        let groups: Vec<Group> =
            REFERENCES_PA_S.iter().enumerate().map(one).collect::<Result<_, StudyError>>()?;
        let limits = thresholds(&groups.iter().collect::<Vec<_>>(), &Settings::default())?;
        Ok(Self { groups, limits })
    }

    /// Judges `trial`.
    ///
    /// # Errors
    /// [`StudyError`], when the recordings cannot be fitted.
    pub fn judge(&self, trial: &LawTrial) -> Result<LawOutcome, StudyError> {
        let same = trial.law.map_or(&[][..], |law| law.same);
        let wanted = |entry: &&'static Entry| {
            !same.contains(&entry.name) && (trial.library == Library::Whole || !entry.class.in_liquid())
        };
        let library = LIBRARY.iter().filter(wanted).collect();
        let settings = Settings { library, ..Settings::default() };
        let groups: Vec<&Group> = self.groups.iter().collect();
        let mine = glass(trial.viscosity_pa_s, trial.seed);
        let recordings = records(&mine, trial.law.as_ref(), trial.gain, trial.seed);
        let findings = discover(&recordings, known(VISCOSITY_PA_S), &groups, &self.limits, &settings)?;
        let is_unknown = matches!(findings.assessment.verdict, Verdict::Unknown(_));
        let by_workflow = is_unknown.then(|| drawn(&findings, &settings, CALIBRATION));
        // Bands are measured without a factor where the factor is to be found.
        let factors = match trial.purpose {
            Purpose::Calibration => Calibrated { force: 1.0, drag: 1.0 },
            Purpose::Judged | Purpose::Clean | Purpose::Named => CALIBRATION,
        };
        let any = if trial.law.is_some() { drawn(&findings, &settings, factors).ok() } else { None };
        let gap = findings.gap.as_ref().map(|measured| measured.gap);
        let found = any.as_ref().zip(gap).zip(trial.law).map(|((law, gap), hidden)| {
            let law_m = law.gap.as_ref().map_or(f64::NAN, |gap| gap.law_m);
            let gap_mm = [gap.untouched, gap.refitted, gap.black_box, law_m].map(|m| 1e3 * m);
            found(law, gap_mm, &hidden, &mine)
        });
        let verdict = &findings.assessment.verdict;
        Ok(LawOutcome {
            purpose: trial.purpose,
            law: trial.law.map_or_else(String::new, |law| law.name.into()),
            size: trial.law.map_or(0.0, |law| law.size),
            library: trial.library,
            verdict: verdict.word().into(),
            names: verdict.names().iter().map(|name| String::from(*name)).collect(),
            is_drawn: matches!(by_workflow, Some(Ok(_))),
            refused: by_workflow.and_then(Result::err).map(|why| why.to_string()),
            found,
        })
    }
}

/// Compares the law `drawn` with the one that is `hidden` in `glass`.
fn found(drawn: &Drawn, gap_mm: [f64; 4], hidden: &HiddenLaw, glass: &Glass) -> FoundLaw {
    let mode = glass.first_mode();
    let Bands { force, drag } = &drawn.bands;
    let true_force: Vec<f64> = force.at.iter().map(|a| hidden.force_n(&mode, *a)).collect();
    let true_drag: Vec<f64> = drag.at.iter().map(|u| hidden.drag_n(&mode, *u)).collect();
    let unit = mode.mass_kg * mode.frequency.powi(2) * drawn.fit.extent.reach_m;
    let width = |half: &[f64]| half.iter().sum::<f64>() / half.len() as f64 / unit;
    let rates = (0..=400).map(|i| drawn.fit.extent.fastest_m_s * f64::from(i) / 300.0);
    FoundLaw {
        gap_mm,
        distance: [force.largest_distance(&true_force), drag.largest_distance(&true_drag)],
        width: [width(&force.half), width(&drag.half)],
        least_friction: rates.map(|u| drawn.fit.law.friction(u)).fold(f64::INFINITY, f64::min),
        misfit: drawn.misfit,
        nearest: drawn.nearest.as_ref().map(|near| near.name.into()),
        departs: drawn
            .nearest
            .as_ref()
            .is_some_and(|near| !near.heights.is_empty() || !near.rates.is_empty()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::unnamed::trials::law_trials;

    #[test]
    fn a_law_of_no_library_is_drawn_and_closes_most_of_the_gap_and_a_clean_glass_gets_none() {
        let bench = LawBench::new().expect("references");
        let trials = law_trials();
        let hidden = |name: &str| {
            let mine =
                |t: &&LawTrial| t.library == Library::WithoutForces && t.law.is_some_and(|l| l.name == name);
            bench.judge(trials.iter().find(mine).expect("there")).expect("judged")
        };
        for name in ["quadratic drag", "drag of power 1.5"] {
            let outcome = hidden(name);
            let found = outcome.found.clone().expect("a law");
            assert!(outcome.verdict == "unknown" && outcome.is_drawn, "{outcome:?}");
            assert!(found.gap_mm[3] < 0.4 * found.gap_mm[0], "{outcome:?}");
            assert!(found.least_friction >= 0.0 && found.distance.iter().all(|d| *d < 2.0), "{outcome:?}");
        }
        let clean = trials.iter().find(|t| t.purpose == Purpose::Clean).expect("there");
        let outcome = bench.judge(clean).expect("judged");
        assert!(outcome.verdict == "none" && !outcome.is_drawn && outcome.refused.is_none(), "{outcome:?}");
        let named = trials.iter().find(|t| t.purpose == Purpose::Named).expect("there");
        let outcome = bench.judge(named).expect("judged");
        assert!(outcome.verdict != "unknown" && outcome.names.contains(&"viscosity".into()), "{outcome:?}");
        assert!(!outcome.is_drawn);
    }
}
