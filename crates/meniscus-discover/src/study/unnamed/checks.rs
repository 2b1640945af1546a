//! Tally of the trials of the drawn law, its checks and its table.

use super::judge::{FoundLaw, LawOutcome};
use super::trials::{Library, Purpose};
use crate::law::band::CONFIDENCE;
use crate::study::share::share_set;
use meniscus_numerics::statistics::median;
use meniscus_report::Report;
use meniscus_report::checks::Check;

/// Returns the trials of `purpose` with the laws that were found in them.
fn found(outcomes: &[LawOutcome], purpose: Purpose) -> impl Iterator<Item = (&LawOutcome, &FoundLaw)> {
    outcomes.iter().filter(move |o| o.purpose == purpose).filter_map(|o| Some((o, o.found.as_ref()?)))
}

/// Returns the share of the gap that a law closes: one less its error over that of the untouched model.
fn closed(law: &FoundLaw) -> f64 {
    1.0 - law.gap_mm[3] / law.gap_mm[0]
}

/// Returns the factors on the bands that `outcomes` call for: the quantile of [`CONFIDENCE`] of the largest distances on the
/// calibration trials, of the force and of the drag.
#[must_use]
pub fn factors(outcomes: &[LawOutcome]) -> [f64; 2] {
    [0, 1].map(|curve| {
        let mut all: Vec<f64> =
            found(outcomes, Purpose::Calibration).map(|(_, law)| law.distance[curve]).collect();
        all.sort_by(f64::total_cmp);
        // The conformal quantile: one more than the number of trials counts.
        let place = (CONFIDENCE * (all.len() + 1) as f64).ceil() as usize;
        all.get(place.saturating_sub(1)).or(all.last()).copied().unwrap_or(f64::NAN)
    })
}

/// Returns the checks of `outcomes`.
#[must_use]
pub fn law_checks(outcomes: &[LawOutcome]) -> Vec<Check> {
    let count = |purpose: Purpose, holds: &dyn Fn(&LawOutcome) -> bool| {
        outcomes.iter().filter(|o| o.purpose == purpose && holds(o)).count() as f64
    };
    let all = |purpose: Purpose| count(purpose, &|_| true);
    let if_any = |trials: f64, value: f64| if trials == 0.0 { f64::NAN } else { value };
    let middle = |values: Vec<f64>| median(values).unwrap_or(f64::NAN);
    let drawn = || found(outcomes, Purpose::Judged).filter(|(o, _)| o.is_drawn);
    let any = || found(outcomes, Purpose::Judged);
    let held = |curve: usize| share_set(any().map(|(_, law)| law.distance[curve] <= 1.0));
    let negative =
        any().chain(found(outcomes, Purpose::Calibration)).filter(|(_, law)| law.least_friction < 0.0);
    let (judged, clean) = (all(Purpose::Judged), all(Purpose::Clean));
    let whole = count(Purpose::Judged, &|o| o.library == Library::Whole);
    let by_word = |word: &'static str| {
        if_any(whole, count(Purpose::Judged, &move |o| o.library == Library::Whole && o.verdict == word))
    };
    let named = all(Purpose::Named);
    let stays = count(Purpose::Named, &|o| matches!(o.verdict.as_str(), "named" | "tied") && !o.is_drawn);
    let over_refitted = drawn().map(|(_, law)| law.gap_mm[3] / law.gap_mm[1]).collect();
    let over_black_box = drawn().map(|(_, law)| law.gap_mm[3] / law.gap_mm[2]).collect();
    vec![
        Check::at_least("law_trials", judged, "trials", 12.0),
        Check::informational("law_whole_library_unknown", by_word("unknown"), "trials"),
        Check::informational("law_whole_library_tied", by_word("tied"), "trials"),
        Check::informational("law_whole_library_named", by_word("named"), "trials"),
        Check::informational("law_whole_library_none", by_word("none"), "trials"),
        Check::informational("law_drawn", if_any(judged, count(Purpose::Judged, &|o| o.is_drawn)), "trials"),
        Check::at_least(
            "law_gap_closed_median",
            middle(drawn().map(|(_, law)| closed(law)).collect()),
            "share",
            0.7,
        ),
        Check::informational(
            "law_gap_closed_median_any_verdict",
            middle(any().map(|(_, law)| closed(law)).collect()),
            "share",
        ),
        Check::informational("law_gap_over_refitted_median", middle(over_refitted), "ratio"),
        Check::informational("law_gap_over_black_box_median", middle(over_black_box), "ratio"),
        Check::exactly("negative_dissipation", if_any(judged, negative.count() as f64), "trials", 0.0),
        Check::at_least("law_force_in_band", held(0), "share", 0.85),
        Check::at_least("law_drag_in_band", held(1), "share", 0.85),
        Check::exactly(
            "laws_of_clean_glasses",
            if_any(clean, count(Purpose::Clean, &|o| o.is_drawn)),
            "trials",
            0.0,
        ),
        Check::at_least("law_clean_trials", clean, "trials", 12.0),
        Check::at_least("effects_that_stay_named", if_any(named, stays / named), "share", 1.0),
        Check::informational("law_force_factor", factors(outcomes)[0], "half-widths"),
        Check::informational("law_drag_factor", factors(outcomes)[1], "half-widths"),
    ]
}

/// Columns of the table of trials.
const COLUMNS: [&str; 14] = [
    "law",
    "size",
    "library",
    "verdict",
    "names",
    "drawn",
    "gap untouched, mm",
    "gap refitted, mm",
    "gap black box, mm",
    "gap law, mm",
    "misfit with",
    "force, half-widths off",
    "drag, half-widths off",
    "nearest formula",
];

/// Adds the trials to `report`.
pub fn tables(report: &mut Report, outcomes: &[LawOutcome]) {
    for (purpose, title) in [
        (Purpose::Judged, "Laws that no library holds"),
        (Purpose::Calibration, "Laws on which the bands were calibrated, without their factor"),
        (Purpose::Clean, "No law hidden"),
        (Purpose::Named, "An effect of the library hidden"),
    ] {
        report.heading(title);
        let rows: Vec<_> = outcomes.iter().filter(|o| o.purpose == purpose).map(row).collect();
        report.table(&COLUMNS, &rows);
    }
}

fn row(outcome: &LawOutcome) -> Vec<String> {
    let mut row = vec![
        if outcome.law.is_empty() { "-".into() } else { outcome.law.clone() },
        format!("{}", outcome.size),
        match outcome.library {
            Library::Whole => "whole".into(),
            Library::WithoutForces => "without forces".into(),
        },
        outcome.verdict.clone(),
        outcome.names.join(" + "),
        if outcome.is_drawn { "yes".into() } else { "no".into() },
    ];
    match &outcome.found {
        Some(law) => {
            row.extend(law.gap_mm.map(|mm| format!("{mm:.3}")));
            row.push(format!("{:.2}", law.misfit));
            row.extend(law.distance.map(|d| format!("{d:.2}")));
            row.push(law.nearest.clone().unwrap_or_else(|| "-".into()));
        }
        None => row.extend((row.len()..COLUMNS.len()).map(|_| String::from("-"))),
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(purpose: Purpose, distance: f64, drawn: bool) -> LawOutcome {
        let found = FoundLaw {
            gap_mm: [1.0, 0.9, 0.5, 0.2],
            distance: [distance, 0.5 * distance],
            width: [0.1; 2],
            least_friction: 0.0,
            misfit: 1.0,
            nearest: None,
            departs: false,
        };
        LawOutcome {
            purpose,
            law: "law".into(),
            size: 1.0,
            library: Library::WithoutForces,
            verdict: if drawn { "unknown".into() } else { "none".into() },
            names: Vec::new(),
            is_drawn: drawn,
            refused: None,
            found: (purpose != Purpose::Clean).then_some(found),
        }
    }

    #[test]
    fn checks_fail_where_they_should() {
        let value = |outcomes: &[LawOutcome], name: &str| {
            let found = law_checks(outcomes).into_iter().find(|check| check.name == name);
            found.map(|check| (check.value.unwrap_or(f64::NAN), check.ok))
        };
        let good: Vec<LawOutcome> = (0..12)
            .flat_map(|_| [outcome(Purpose::Judged, 0.6, true), outcome(Purpose::Clean, 0.0, false)])
            .collect();
        assert_eq!(value(&good, "law_gap_closed_median"), Some((0.8, Some(true))));
        assert_eq!(value(&good, "law_force_in_band"), Some((1.0, Some(true))));
        let mut bad = good.clone();
        bad.iter_mut().filter(|o| o.purpose == Purpose::Clean).take(1).for_each(|o| o.is_drawn = true);
        let mut few = bad.iter_mut().filter_map(|o| o.found.as_mut());
        few.by_ref().take(1).for_each(|law| law.least_friction = -1e-9);
        few.for_each(|law| law.distance = [3.0; 2]);
        assert_eq!(value(&bad, "laws_of_clean_glasses"), Some((1.0, Some(false))));
        assert_eq!(value(&bad, "negative_dissipation"), Some((1.0, Some(false))));
        assert_eq!(value(&bad, "law_force_in_band").and_then(|v| v.1), Some(false));
    }

    #[test]
    fn the_factor_is_the_conformal_quantile_of_the_calibration_trials() {
        let outcomes: Vec<LawOutcome> =
            (1..=19).map(|i| outcome(Purpose::Calibration, f64::from(i), true)).collect();
        assert_eq!(factors(&outcomes), [18.0, 9.0]);
    }
}
