//! Verdicts of the program in the end: those of the reduced model, as the simulator leaves them where it sized the trial.

use super::bench::Judged;
use super::plans::Answer;
use super::sizes::trial::SizedTrials;
use super::tally::StudyTally;

impl StudyTally {
    /// Returns the study with the verdicts in the end. Fits, gains and gaps stay those of the reduced model.
    #[must_use]
    pub fn in_the_end(&self) -> Self {
        let mut out = self.clone();
        for (answer, judged) in &mut out.lines {
            set_final_verdict(answer, judged, &self.beside.sizes);
        }
        out
    }
}

/// Replaces verdict, names and class of the trial of `answer` by those that it has in `sizes`, where it is there.
fn set_final_verdict(answer: &Answer, judged: &mut Judged, sizes: &SizedTrials) {
    let mut all = sizes.trials.iter().chain(&sizes.without);
    let Some(sized) = all.find(|sized| sized.answer == *answer) else { return };
    judged.verdict.clone_from(&sized.verdict);
    judged.names.clone_from(&sized.names);
    judged.class.clone_from(&sized.class);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::checks::checks;
    use crate::study::plans::Family;
    use crate::study::run::JudgedTrial;
    use crate::study::sizes::trial::SizedTrial;

    fn trial(family: Family, hidden: &str, named: &str, class: &str) -> JudgedTrial {
        let answer =
            Answer { family, effects: vec![(hidden.into(), 0.5)], size: 1.0, glass: "packing 7".into() };
        let judged = Judged {
            verdict: "named".into(),
            names: vec![named.into()],
            class: Some(class.into()),
            gain: 4000.0,
            bound: Some(40.0),
            best: None,
            misfit: [2.6, 1.0],
            estimate: None,
            gap_mm: None,
            oracle_mm: None,
            suggested: None,
            seconds: 8.0,
        };
        (answer, judged)
    }

    fn sized(answer: &Answer, verdict: &str, class: Option<&str>) -> SizedTrial {
        SizedTrial {
            answer: answer.clone(),
            truth: 0.5,
            absent: 1.0,
            unit: "1".into(),
            reduced: None,
            simulated: None,
            verdict: verdict.into(),
            class: class.map(String::from),
            names: vec!["viscosity".into()],
            held_out_mm: None,
            said: vec![],
            simulations: 30,
            seconds: 120.0,
        }
    }

    #[test]
    fn a_name_that_the_simulator_takes_back_counts_as_unknown_beside_that_of_the_reduced_model() {
        let lines = vec![
            trial(Family::Without, "shear_thinning", "viscosity", "linear damping"),
            trial(Family::Without, "viscoelastic", "radius", "view and stand"),
            trial(Family::Fresh, "viscosity", "viscosity", "linear damping"),
        ];
        let mut study = StudyTally { lines, ..StudyTally::default() };
        let answers = [0, 2].map(|which: usize| study.lines[which].0.clone());
        study.beside.sizes.without.push(sized(&answers[0], "unknown", None));
        study.beside.sizes.trials.push(sized(&answers[1], "named", Some("linear damping")));
        let checks = checks(&study);
        let value = |name: &str| checks.iter().find(|c| c.name == name).and_then(|c| c.value);
        assert_eq!(value("wrong_confident_out_of_library"), Some(1.0));
        assert_eq!(value("wrong_confident_out_of_library_reduced_model"), Some(2.0));
        assert_eq!(value("unknown_or_class_out_of_library"), Some(0.5));
        assert_eq!(value("named_share"), Some(1.0));
        // One that is taken back is named no more, whoever was right.
        study.beside.sizes.trials[0].verdict = "unknown".into();
        let checks = crate::study::checks::checks(&study);
        let value = |name: &str| checks.iter().find(|c| c.name == name).and_then(|c| c.value);
        assert_eq!((value("named_share"), value("named_share_reduced_model")), (Some(0.0), Some(1.0)));
    }
}
