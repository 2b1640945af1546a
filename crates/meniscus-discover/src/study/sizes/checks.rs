//! Tally of the sizes by simulation, and their table.

use super::trial::{FoundSize, SizedTrial, SizedTrials};
use crate::study::plans::Family;
use crate::study::share::share_set;
use meniscus_numerics::statistics::median;
use meniscus_report::Report;
use meniscus_report::checks::Check;

/// Fewest intervals that a coverage is measured on.
const INTERVALS: f64 = 100.0;

/// Returns the checks of `sized`.
///
/// The shares are of all trials whose class was stated: a trial without a size of the hidden effect is not within it. The
/// coverage is of those that have one.
#[must_use]
pub fn size_checks(sized: &SizedTrials) -> Vec<Check> {
    let all = || sized.trials.iter();
    let fresh = || all().filter(|trial| trial.answer.family == Family::Fresh);
    let within = |trial: &SizedTrial, size: Option<&FoundSize>, limit: f64| {
        size.is_some_and(|size| trial.error_of(size).abs() <= limit)
    };
    let covered = |trial: &SizedTrial| trial.stated().map(|size| size.covers(trial.truth));
    let middle = |values: Vec<f64>| median(values.into_iter().filter(|v| v.is_finite())).unwrap_or(f64::NAN);
    vec![
        Check::at_least("sized_trials", all().count() as f64, "trials", sized.planned.max(1) as f64),
        Check::at_least(
            "size_within_10_percent",
            share_set(all().map(|t| within(t, t.stated(), 0.1))),
            "share",
            0.85,
        ),
        Check::at_least(
            "size_within_25_percent",
            share_set(all().map(|t| within(t, t.stated(), 0.25))),
            "share",
            0.97,
        ),
        Check::informational(
            "size_within_10_percent_fresh",
            share_set(fresh().map(|t| within(t, t.stated(), 0.1))),
            "share",
        ),
        Check::informational(
            "size_within_10_percent_reduced_model",
            share_set(all().map(|t| within(t, t.reduced.as_ref(), 0.1))),
            "share",
        ),
        Check::informational(
            "size_within_25_percent_reduced_model",
            share_set(all().map(|t| within(t, t.reduced.as_ref(), 0.25))),
            "share",
        ),
        Check::within(
            "interval_coverage_other_simulator",
            share_set(all().filter_map(covered)),
            "share",
            0.85,
            0.95,
        ),
        Check::informational(
            "interval_coverage_other_simulator_fresh",
            share_set(fresh().filter_map(covered)),
            "share",
        ),
        Check::at_least(
            "intervals_other_simulator",
            all().filter_map(covered).count() as f64,
            "trials",
            INTERVALS,
        ),
        Check::at_least(
            "gap_closed_simulator_median",
            middle(all().filter_map(SizedTrial::gap_closed).collect()),
            "share",
            0.95,
        ),
        Check::informational(
            "gap_closed_simulator_least",
            all().filter_map(SizedTrial::gap_closed).fold(f64::NAN, f64::min),
            "share",
        ),
        Check::informational(
            "minutes_per_sizing",
            middle(all().filter(|t| t.simulations > 0).map(|t| t.seconds / 60.0).collect()),
            "min",
        ),
    ]
}

/// Adds the table of `sized` to `report`.
pub fn size_table(report: &mut Report, sized: &SizedTrials) {
    report.heading("Sizes by simulation");
    report.prose(&format!("{} of {} planned.", sized.trials.len(), sized.planned));
    report.table(&COLUMNS, &sized.trials.iter().map(row).collect::<Vec<_>>());
    if !sized.without.is_empty() {
        report.heading("Effects that the library lacks, by simulation");
        report.prose("Trials in which the reduced model names an effect, and what becomes of the verdict.");
        report.table(&COLUMNS, &sized.without.iter().map(row).collect::<Vec<_>>());
    }
}

/// Columns of the tables.
const COLUMNS: [&str; 11] = [
    "truth",
    "glass",
    "reduced model (90 %)",
    "simulator (90 %)",
    "error, %",
    "covered",
    "verdict",
    "names left",
    "held-out error untouched, mm",
    "with the effect, mm",
    "said",
];

fn row(trial: &SizedTrial) -> Vec<String> {
    let size = |size: &Option<FoundSize>| {
        let text = |s: &FoundSize| format!("{:.4} ({:.4} to {:.4})", s.value, s.least, s.largest);
        size.as_ref().map_or_else(|| "-".into(), text)
    };
    let name = &trial.answer.effects[0].0;
    let error = trial.stated().map_or_else(|| "-".into(), |s| format!("{:+.1}", 100.0 * trial.error_of(s)));
    let covered = trial.stated().map_or("-", |s| if s.covers(trial.truth) { "yes" } else { "no" });
    let [untouched, effect] =
        trial.held_out_mm.map_or([const { String::new() }; 2], |both| both.map(|mm| format!("{mm:.3}")));
    vec![
        format!("{name} {:.4} {}", trial.truth, trial.unit),
        trial.answer.glass.clone(),
        size(&trial.reduced),
        size(&trial.simulated),
        error,
        covered.into(),
        trial.verdict.clone(),
        trial.names.join(", "),
        untouched,
        effect,
        trial.said.join("; "),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plans::Answer;

    fn trial(family: Family, reduced: Option<f64>, simulated: Option<f64>) -> SizedTrial {
        let size = |value: f64| FoundSize { value, least: value - 0.3, largest: value + 0.3 };
        SizedTrial {
            answer: Answer {
                family,
                effects: vec![("yield_stress".into(), 3.0)],
                size: 1.0,
                glass: "packing 7".into(),
            },
            truth: 3.0,
            absent: 0.0,
            unit: "Pa".into(),
            reduced: reduced.map(size),
            simulated: simulated.map(size),
            verdict: "named".into(),
            class: None,
            names: vec!["yield_stress".into()],
            held_out_mm: Some([1.0, 0.1]),
            said: vec![],
            simulations: 30,
            seconds: 120.0,
        }
    }

    #[test]
    fn a_trial_without_a_size_is_not_within_it_and_has_no_interval() {
        let trials = vec![
            trial(Family::Fresh, Some(2.0), Some(2.9)),
            trial(Family::Hidden, Some(2.0), Some(3.5)),
            trial(Family::Hidden, None, None),
        ];
        let sized = SizedTrials { trials, planned: 4, without: vec![] };
        let checks = size_checks(&sized);
        let value = |name: &str| checks.iter().find(|c| c.name == name).and_then(|c| c.value);
        let third = |count: f64| Some(count / 3.0);
        assert_eq!(value("size_within_10_percent"), third(1.0));
        assert_eq!(value("size_within_25_percent"), third(2.0));
        assert_eq!(value("size_within_10_percent_reduced_model"), third(0.0));
        assert_eq!(value("interval_coverage_other_simulator"), Some(0.5));
        assert_eq!(value("gap_closed_simulator_median"), Some(0.9));
        let missed = |name: &str| checks.iter().any(|c| c.name == name && c.ok == Some(false));
        assert!(missed("sized_trials") && missed("intervals_other_simulator"));
        let mut report = Report::new("Sizes", "command");
        size_table(&mut report, &sized);
        let page = report.markdown();
        assert!(page.contains("| -3.3 | yes | named | yield_stress | 1.000 | 0.100 |"), "{page}");
    }

    #[test]
    fn the_error_counts_from_the_absent_effect() {
        let gain = SizedTrial { truth: 1.08, absent: 1.0, ..trial(Family::Fresh, None, Some(1.06)) };
        let error = gain.error_of(gain.stated().expect("it has a size"));
        assert!((error + 0.25).abs() < 1e-9, "{error}");
    }
}
