//! Rates of the study that measure caution, beside those of a program that never commits itself.

use super::checks::checks;
use super::sizes::trial::SizedTrials;
use super::tally::StudyTally;
use meniscus_report::checks::Check;

/// Rates that measure caution, which a program that never commits itself scores as well.
const CAUTION: [&str; 7] = [
    "class_right",
    "named_share",
    "false_names",
    "noise_false_names",
    "wrong_confident_out_of_library",
    "unknown_or_class_out_of_library",
    "two_effects_found_or_unknown",
];

/// Returns the checks of caution, each with the value of a program that answers every trial with `unknown`; not measured
/// where that program states no class at all.
#[must_use]
pub fn always_unknown(study: &StudyTally) -> Vec<(Check, Option<f64>)> {
    let mut silent = study.clone();
    silent.beside.sizes = SizedTrials::default();
    for (_, judged) in &mut silent.lines {
        judged.verdict = "unknown".into();
        judged.names.clear();
        judged.class = None;
        judged.estimate = None;
    }
    let theirs = checks(&silent);
    let of = |name: &str| theirs.iter().find(|check| check.name == name).and_then(|check| check.value);
    let mut out = checks(study);
    out.retain(|check| CAUTION.contains(&check.name.as_str()));
    out.into_iter().map(|check| (of(&check.name), check)).map(|(value, check)| (check, value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::bench::Judged;
    use crate::study::plans::{Answer, Family};

    #[test]
    fn silence_names_nothing_and_is_never_wrong() {
        let answer = Answer {
            family: Family::Fresh,
            effects: vec![("foam".into(), 0.1)],
            size: 1.0,
            glass: "1".into(),
        };
        let judged = Judged {
            verdict: "named".into(),
            names: vec!["foam".into()],
            class: Some("amplitude-dependent damping".into()),
            gain: 300.0,
            bound: Some(40.0),
            best: None,
            misfit: [0.7, 0.5],
            estimate: None,
            gap_mm: None,
            oracle_mm: None,
            suggested: None,
            seconds: 8.0,
        };
        let without = Answer { family: Family::Without, ..answer.clone() };
        let lines = vec![(answer, judged.clone()), (without, judged)];
        let beside = always_unknown(&StudyTally { lines, ..StudyTally::default() });
        let of = |name: &str| {
            beside.iter().find(|(c, _)| c.name == name).map(|(c, theirs)| (c.value, *theirs)).expect("a rate")
        };
        assert_eq!(of("named_share"), (Some(1.0), Some(0.0)));
        assert_eq!(of("unknown_or_class_out_of_library"), (Some(1.0), Some(1.0)));
        assert_eq!(of("class_right"), (Some(1.0), None));
    }
}
