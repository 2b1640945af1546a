//! Tally of the second laboratory's trials, its checks and its table.

use super::judge::LaboratoryOutcome;
use super::trials::TrialPurpose;
use crate::study::plans::twins;
use crate::study::share::share_set;
use meniscus::reduced::effects::find;
use meniscus_report::Report;
use meniscus_report::checks::Check;

impl LaboratoryOutcome {
    /// Returns whether the verdict has the hidden effect as its only name.
    fn is_named(&self) -> bool {
        self.verdict == "named" && self.names == [self.hidden.as_str()]
    }

    /// Returns whether no recording of a planar motion distinguishes the hidden effect from another one.
    fn has_twin(&self) -> bool {
        twins(&self.hidden).len() > 1
    }

    /// Returns whether the class that is stated is that of the hidden effect; none where no class is stated.
    fn class_right(&self) -> Option<bool> {
        let truth = find(&self.hidden)?.class.words();
        Some(self.class.as_deref()? == truth)
    }

    /// Returns whether the interval of the verdict's first name covers the truth; none where that name is another effect's.
    fn covers(&self) -> Option<bool> {
        let states = matches!(self.verdict.as_str(), "named" | "tied");
        let [_, least, largest] =
            self.estimate.filter(|_| states && self.names.first() == Some(&self.hidden))?;
        self.truth.map(|truth| (least..=largest).contains(&truth))
    }
}

/// Returns the checks of `outcomes`.
#[must_use]
pub fn laboratory_checks(outcomes: &[LaboratoryOutcome]) -> Vec<Check> {
    let of = |purpose: TrialPurpose| outcomes.iter().filter(move |outcome| outcome.purpose == purpose);
    let hidden = || of(TrialPurpose::Hidden);
    let count = |some: &mut dyn Iterator<Item = &LaboratoryOutcome>| some.count() as f64;
    let if_any = |value: f64| if outcomes.is_empty() { f64::NAN } else { value };
    let named = hidden().filter(|outcome| outcome.verdict == "named");
    let intervals = hidden().filter_map(LaboratoryOutcome::covers).count() as f64;
    vec![
        Check::at_least("other_lab_trials", if_any(outcomes.len() as f64), "trials", 60.0),
        Check::at_least(
            "other_lab_named",
            share_set(hidden().filter(|o| !o.has_twin()).map(LaboratoryOutcome::is_named)),
            "share",
            0.6,
        ),
        Check::informational(
            "other_lab_right_of_named",
            share_set(named.map(LaboratoryOutcome::is_named)),
            "share",
        ),
        Check::informational(
            "other_lab_class_right",
            share_set(hidden().filter_map(LaboratoryOutcome::class_right)),
            "share",
        ),
        Check::within(
            "other_lab_coverage",
            share_set(hidden().filter_map(LaboratoryOutcome::covers)),
            "share",
            0.8,
            0.97,
        ),
        Check::informational("other_lab_intervals", if_any(intervals), "trials"),
        Check::exactly(
            "other_lab_false_names",
            if_any(count(&mut of(TrialPurpose::Clean).filter(|o| o.verdict == "named"))),
            "trials",
            0.0,
        ),
        Check::informational("other_lab_clean", if_any(count(&mut of(TrialPurpose::Clean))), "trials"),
        Check::at_most(
            "other_lab_none_with_effect",
            share_set(hidden().map(|outcome| outcome.verdict == "none")),
            "share",
            0.1,
        ),
        Check::at_least(
            "outside_library_unknown",
            share_set(of(TrialPurpose::Outside).map(|outcome| outcome.verdict == "unknown")),
            "share",
            0.8,
        ),
        Check::informational(
            "outside_library_named",
            if_any(count(&mut of(TrialPurpose::Outside).filter(|o| o.verdict == "named"))),
            "trials",
        ),
    ]
}

/// Columns of the table of trials.
const COLUMNS: [&str; 9] = [
    "hidden",
    "size",
    "truth",
    "verdict",
    "names",
    "estimate (90 %)",
    "misfit with",
    "gap untouched, mm",
    "gap effect, mm",
];

/// Adds the trials to `report`.
pub fn laboratory_tables(report: &mut Report, outcomes: &[LaboratoryOutcome]) {
    for (purpose, title) in [
        (TrialPurpose::Hidden, "Second laboratory: an effect of the library hidden"),
        (TrialPurpose::Clean, "Second laboratory: nothing hidden"),
        (TrialPurpose::Outside, "Second laboratory: a force hidden that no library holds"),
    ] {
        report.heading(title);
        let rows: Vec<_> = outcomes.iter().filter(|o| o.purpose == purpose).map(row).collect();
        report.table(&COLUMNS, &rows);
    }
}

fn row(outcome: &LaboratoryOutcome) -> Vec<String> {
    let dash = || String::from("-");
    let mm = |which: usize| outcome.gap_mm.map_or_else(dash, |gap| format!("{:.2}", gap[which]));
    vec![
        if outcome.hidden.is_empty() { dash() } else { outcome.hidden.clone() },
        format!("{}", outcome.size),
        outcome.truth.map_or_else(dash, |truth| format!("{truth:.4}")),
        if outcome.is_named() { "named, right".into() } else { outcome.verdict.clone() },
        outcome.names.join(", "),
        outcome
            .estimate
            .map_or_else(dash, |[value, least, largest]| format!("{value:.4} ({least:.4} to {largest:.4})")),
        format!("{:.2}", outcome.misfit),
        mm(0),
        mm(1),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(purpose: TrialPurpose, hidden: &str, verdict: &str, name: &str) -> LaboratoryOutcome {
        let truth = (purpose == TrialPurpose::Hidden).then_some(1.0);
        LaboratoryOutcome {
            purpose,
            hidden: hidden.into(),
            size: 1.0,
            truth,
            verdict: verdict.into(),
            names: if name.is_empty() { Vec::new() } else { vec![name.into()] },
            class: find(name).map(|effect| effect.class.words().into()),
            estimate: Some([1.1, 0.9, 1.3]),
            gap_mm: None,
            misfit: 1.0,
        }
    }

    #[test]
    fn each_check_fails_where_it_should() {
        let good = [
            outcome(TrialPurpose::Hidden, "foam", "named", "foam"),
            outcome(TrialPurpose::Hidden, "camera_latency", "tied", "actuation_delay"),
            outcome(TrialPurpose::Clean, "", "none", ""),
            outcome(TrialPurpose::Outside, "end stop", "unknown", "foam"),
        ];
        let of = |outcomes: &[LaboratoryOutcome], name: &str| {
            let checks = laboratory_checks(outcomes);
            let found = checks.iter().find(|check| check.name == name).expect("there");
            (found.value.unwrap_or(f64::NAN), found.ok)
        };
        for (name, value) in [
            ("other_lab_named", 1.0),
            ("other_lab_coverage", 1.0),
            ("other_lab_false_names", 0.0),
            ("other_lab_none_with_effect", 0.0),
            ("outside_library_unknown", 1.0),
        ] {
            assert_eq!(of(&good, name).0, value, "{name}");
        }
        let mut bad = good.clone();
        (bad[0].verdict, bad[2].verdict, bad[3].verdict) = ("none".into(), "named".into(), "named".into());
        for (name, value) in [
            ("other_lab_named", 0.0),
            ("other_lab_false_names", 1.0),
            ("other_lab_none_with_effect", 0.5),
            ("outside_library_unknown", 0.0),
        ] {
            assert_eq!(of(&bad, name), (value, Some(false)), "{name}");
        }
        let mut far = good;
        far[0].truth = Some(1.4);
        assert_eq!(of(&far, "other_lab_coverage"), (0.0, Some(false)));
        assert!(of(&[], "other_lab_trials").0.is_nan(), "nothing judged is no result");
    }
}
