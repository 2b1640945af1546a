//! Checks of the study. Rates of verdicts are of those in the end; `_reduced_model` marks those of the reduced model.

use super::against_simulator::simulator_checks;
use super::bench::Judged;
use super::laboratory::checks::laboratory_checks;
use super::measured::MeasuredResult;
use super::plans::{Answer, Family, twins};
use super::run::JudgedTrial;
use super::sizes::checks::size_checks;
use super::tally::{Beside, StudyTally, class_right, right};
use super::unnamed::checks::law_checks;
use meniscus::reduced::effects::EffectKind;
use meniscus_numerics::statistics::median;
use meniscus_report::checks::Check;
use std::collections::BTreeSet;

/// Returns the checks of the study.
#[must_use]
pub fn checks(study: &StudyTally) -> Vec<Check> {
    let beside = &study.beside;
    let longest = study.lines.iter().map(|(_, j)| j.seconds).fold(f64::NAN, f64::max);
    let mut out = verdict_checks(&study.in_the_end());
    out.extend(reduced_model_checks(study));
    out.extend(size_checks(&beside.sizes));
    out.extend(measured_checks(beside));
    out.extend(law_checks(&beside.laws));
    out.extend(laboratory_checks(&beside.laboratory));
    out.extend(simulator_checks(&beside.against));
    out.push(Check::informational("seconds_per_short_discovery", longest, "s"));
    out.push(Check::at_most("seconds_per_discovery", beside.long_s.unwrap_or(f64::NAN), "s", 180.0));
    out
}

/// Returns the checks on the verdicts of `study`.
fn verdict_checks(study: &StudyTally) -> Vec<Check> {
    let all = Found::of(study.reference());
    let fresh = Found::of(study.of(Family::Fresh));
    let looked_at = study.of(Family::Hidden).filter(|(answer, _)| answer.size == 1.0);
    let looked_at = Found::of(looked_at);
    let asked: Vec<&JudgedTrial> = study.of(Family::Asked).collect();
    let after = looked_at.right + asked.iter().filter(|(a, j)| right(a, j)).count();
    let after = if asked.is_empty() { f64::NAN } else { share(after, looked_at.trials) };
    let names = |family: Family| {
        let (mut named, mut trials) = (0, 0);
        for (_, judged) in study.of(family) {
            named += usize::from(judged.verdict == "named");
            trials += 1;
        }
        (named, trials)
    };
    let (false_names, cleans) = names(Family::Clean);
    let (noise_names, noises) = names(Family::Noise);
    let glasses: BTreeSet<&String> = study.of(Family::Clean).map(|(answer, _)| &answer.glass).collect();
    let none = study.of(Family::Clean).filter(|(_, j)| j.verdict == "none").count();
    let pairs: Vec<&JudgedTrial> = study.of(Family::Pair).collect();
    let honest = pairs.iter().filter(|(a, j)| found_both(a, j) || j.verdict == "unknown").count();
    let withouts = study.of(Family::Without).count();
    vec![
        Check::at_least("class_right", share(all.class_right, all.stated), "share", 0.97),
        Check::informational("class_stated", share(all.stated, all.trials), "share"),
        Check::at_least("decided_share", share(all.right, all.trials), "share", 0.60),
        Check::informational("decided_share_fresh", share(fresh.right, fresh.trials), "share"),
        Check::at_least("decided_share_after_asking", after, "share", 0.80),
        Check::at_least("right_of_decided", share(all.right, all.named), "share", 0.95),
        Check::at_least("named_share", named_share(study), "share", 0.88),
        Check::at_least("right_of_named", share(fresh.right, fresh.named), "share", 0.97),
        Check::at_most("false_names", count(false_names, cleans), "trials", 0.0),
        Check::at_least("clean_trials", cleans as f64, "trials", 118.0),
        Check::at_least("clean_glasses", glasses.len() as f64, "glasses", 60.0),
        Check::informational("clean_none", share(none, cleans), "share"),
        Check::at_most("noise_false_names", count(noise_names, noises), "trials", 0.0),
        Check::exactly(
            "wrong_confident_out_of_library",
            count(wrong_without(study), withouts),
            "trials",
            0.0,
        ),
        Check::at_least(
            "unknown_or_class_out_of_library",
            share(honest_without(study), withouts),
            "share",
            0.95,
        ),
        Check::at_least("two_effects_found_or_unknown", share(honest, pairs.len()), "share", 0.9),
    ]
}

/// Returns the checks on the reduced model alone: its verdicts, gaps and intervals.
fn reduced_model_checks(study: &StudyTally) -> Vec<Check> {
    let withouts = study.of(Family::Without).count();
    let rights: Vec<&JudgedTrial> = study.reference().filter(|(a, j)| right(a, j)).collect();
    let shrink = rights.iter().filter_map(|(_, j)| j.gap_mm).map(|g| 1.0 - g[3] / g[0]).collect();
    let over = rights.iter().filter_map(|(_, j)| Some(j.gap_mm?[3] / j.oracle_mm?)).collect();
    let inside = |(answer, judged): &&&JudgedTrial| {
        let (_, _, least, largest) = judged.estimate.as_ref()?;
        Some((*least..=*largest).contains(&answer.effects[0].1))
    };
    let held: Vec<bool> = rights.iter().filter_map(|line| inside(&line)).collect();
    let self_test = study.beside.coverage.map_or(f64::NAN, |c| c.0);
    vec![
        Check::informational("named_share_reduced_model", named_share(study), "share"),
        Check::informational(
            "wrong_confident_out_of_library_reduced_model",
            count(wrong_without(study), withouts),
            "trials",
        ),
        Check::informational(
            "unknown_or_class_out_of_library_reduced_model",
            share(honest_without(study), withouts),
            "share",
        ),
        Check::at_least("gap_shrink_median", finite_median(shrink), "share", 0.60),
        Check::at_most("gap_over_oracle", finite_median(over), "ratio", 1.25),
        Check::within("interval_self_test", self_test, "share", 0.85, 0.95),
        Check::informational(
            "interval_coverage_reduced_model",
            share(held.iter().filter(|h| **h).count(), held.len()),
            "share",
        ),
    ]
}

/// Returns the checks on measured water.
fn measured_checks(beside: &Beside) -> Vec<Check> {
    let measured = beside.measured.as_deref().unwrap_or_default();
    let [tilt, vertical, control] = [0, 1, 2].map(|i| measured.get(i));
    let means = |result: Option<&MeasuredResult>| result.map_or([f64::NAN; 2], MeasuredResult::means_mm);
    let lifted = EffectKind::VerticalAcceleration.name();
    let free = |result: &MeasuredResult| f64::from(u8::from(!result.names.iter().any(|name| name == lifted)));
    vec![
        Check::informational("antisloshing_tilt_before", means(tilt)[0], "mm"),
        Check::at_most("antisloshing_tilt_after", means(tilt)[1], "mm", 3.5),
        Check::informational("antisloshing_vertical_before", means(vertical)[0], "mm"),
        Check::at_most("antisloshing_vertical_after", means(vertical)[1], "mm", 4.0),
        Check::exactly("antisloshing_control_none", control.map_or(f64::NAN, free), "yes", 1.0),
    ]
}

/// Returns whether each hidden effect is among the names of a `named` or `tied` verdict.
fn found_both(answer: &Answer, judged: &Judged) -> bool {
    matches!(judged.verdict.as_str(), "named" | "tied")
        && answer.effects.iter().all(|(name, _)| judged.names.contains(name))
}

fn share(hits: usize, of: usize) -> f64 {
    if of == 0 { f64::NAN } else { hits as f64 / of as f64 }
}

/// Returns a count, not measured where nothing was tried.
fn count(hits: usize, of: usize) -> f64 {
    if of == 0 { f64::NAN } else { hits as f64 }
}

/// Returns the median of those of `values` that could be measured.
fn finite_median(values: Vec<f64>) -> f64 {
    median(values.into_iter().filter(|v| v.is_finite())).unwrap_or(f64::NAN)
}

/// Counts of single effects that were found in some trials.
struct Found {
    trials: usize,
    stated: usize,
    class_right: usize,
    named: usize,
    right: usize,
}

impl Found {
    fn of<'a>(lines: impl Iterator<Item = &'a JudgedTrial>) -> Self {
        let mut found = Self { trials: 0, stated: 0, class_right: 0, named: 0, right: 0 };
        for (answer, judged) in lines {
            let class = class_right(answer, judged);
            found.trials += 1;
            found.stated += usize::from(class.is_some());
            found.class_right += usize::from(class == Some(true));
            found.named += usize::from(judged.verdict == "named");
            found.right += usize::from(right(answer, judged));
        }
        found
    }
}

/// Returns the share of held-out glasses with a right name, of those whose effect can be named: twins that no recording here
/// distinguishes cannot be.
fn named_share(study: &StudyTally) -> f64 {
    let namable = Found::of(study.of(Family::Fresh).filter(|line| twins(&line.0.effects[0].0).is_empty()));
    share(namable.right, namable.trials)
}

/// Returns the number of trials with a confident wrong class or name where the truth was not in the library.
fn wrong_without(study: &StudyTally) -> usize {
    let wrong = |(answer, judged): &&JudgedTrial| {
        let named = judged.verdict == "named";
        let class = class_right(answer, judged);
        class == Some(false) || (named && class.is_none())
    };
    study.of(Family::Without).filter(wrong).count()
}

/// Returns the number of trials that were answered with `unknown` or the class of the truth, which the library lacked.
fn honest_without(study: &StudyTally) -> usize {
    let honest = |(a, j): &&JudgedTrial| j.verdict == "unknown" || class_right(a, j) == Some(true);
    study.of(Family::Without).filter(honest).count()
}
