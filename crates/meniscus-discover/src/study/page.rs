//! Page of the study: checks, then every trial.

use super::against_simulator::{AgainstSimulator, simulator_checks};
use super::bench::Judged;
use super::caution::always_unknown;
use super::checks::checks;
use super::laboratory::checks::{laboratory_checks, laboratory_tables};
use super::laboratory::judge::LaboratoryOutcome;
use super::measured::MeasuredResult;
use super::plans::{Answer, Family};
use super::run::JudgedTrial;
use super::sizes::checks::size_table;
use super::tally::{StudyTally, class_right, right};
use super::unnamed::checks::{law_checks, tables};
use super::unnamed::judge::LawOutcome;
use meniscus_report::Report;

/// Families in the order of the page.
const TITLES: [(Family, &str); 7] = [
    (Family::Hidden, "One effect hidden"),
    (Family::Fresh, "One effect hidden, in a glass that was held out while rules were made"),
    (Family::Asked, "Ambiguous trials with the recordings that were suggested"),
    (Family::Without, "The true effect taken out of the library"),
    (Family::Pair, "Two effects at once"),
    (Family::Clean, "Nothing hidden"),
    (Family::Noise, "Nothing hidden, noise misjudged by half"),
];

/// Columns of a table of trials in which something is hidden.
const TRIAL: [&str; 15] = [
    "truth",
    "size",
    "verdict",
    "names",
    "class",
    "gain",
    "gain needed",
    "misfit without",
    "misfit with",
    "estimate (90 %)",
    "gap untouched, mm",
    "gap refitted, mm",
    "gap black box, mm",
    "gap effect, mm",
    "gap oracle, mm",
];

/// Columns of a table of trials in which nothing is hidden.
const CLEAN: [&str; 8] = ["glass", "trials", "none", "tied", "unknown", "named", "names", "largest gain"];

/// Returns the report of `study`, which `command` makes again. The pictures `confusion.png` and `detection.png` lie beside
/// it.
#[must_use]
pub fn report(study: &StudyTally, command: &str) -> Report {
    let mut report = Report::new("The study of discovery", command);
    if !study.is_whole() {
        report.prose("Not all planned trials are judged yet.");
    }
    let planned = |family: Family| study.planned.get(&family).copied().unwrap_or(0);
    let counts = TITLES.map(|(family, title)| {
        vec![title.into(), format!("{}", study.of(family).count()), format!("{}", planned(family))]
    });
    report.table(&["trials", "judged", "planned"], &counts);
    report.checks(&checks(study));
    report.prose(
        "Some of these rates measure caution. A program that answers every trial with `unknown` scores them as follows.",
    );
    let shown = |value: Option<f64>| value.map_or_else(|| "-".into(), |value| format!("{value:.3}"));
    let beside = always_unknown(study).into_iter();
    let rows: Vec<_> =
        beside.map(|(c, theirs)| vec![c.name.clone(), shown(c.value), shown(theirs)]).collect();
    report.table(&["check", "this program", "always `unknown`"], &rows);
    report.picture("confusion.png", "hidden effects and the verdicts on them");
    // Curves of one size are none.
    if study.of(Family::Hidden).any(|(answer, _)| answer.size != 1.0) {
        report.picture("detection.png", "gain by size of the hidden effect");
    }
    report.prose(
        "Pictures and trials have the verdicts of the reduced model. Those in the end, which the checks count, stand with the sizes \
         by simulation.",
    );
    for (family, title) in TITLES {
        let trials: Vec<&JudgedTrial> = study.of(family).collect();
        if trials.is_empty() {
            continue;
        }
        report.heading(title);
        report.prose(&format!("{} of {} planned.", trials.len(), planned(family)));
        if matches!(family, Family::Clean | Family::Noise) {
            report.table(&CLEAN, &clean_rows(&trials));
        } else {
            let rows: Vec<_> = trials.iter().map(|(answer, judged)| trial_row(answer, judged)).collect();
            report.table(&TRIAL, &rows);
        }
    }
    if study.beside.sizes.planned > 0 {
        size_table(&mut report, &study.beside.sizes);
    }
    study.beside.measured.iter().flatten().for_each(|result| measured(&mut report, result));
    if !study.beside.laws.is_empty() {
        tables(&mut report, &study.beside.laws);
    }
    if !study.beside.laboratory.is_empty() {
        laboratory_tables(&mut report, &study.beside.laboratory);
    }
    if !study.beside.against.is_empty() {
        against(&mut report, &study.beside.against);
    }
    report
}

/// Returns the report of the trials against references by simulation alone.
#[must_use]
pub fn against_report(outcomes: &[AgainstSimulator], command: &str) -> Report {
    let mut report = Report::new("The study of references by simulation", command);
    report.checks(&simulator_checks(outcomes));
    against(&mut report, outcomes);
    report
}

/// Adds the trials against references by simulation.
fn against(report: &mut Report, outcomes: &[AgainstSimulator]) {
    report.heading("Against references that the simulator made");
    let row = |o: &AgainstSimulator| {
        let spacing = format!("{:.1}", 1e3 * o.spacing_m);
        let or_none = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".into());
        let (hidden, class) = (or_none(&o.hidden), or_none(&o.class));
        vec![hidden, spacing, o.packing.to_string(), o.verdict.clone(), o.names.join(" + "), class]
    };
    let rows: Vec<_> = outcomes.iter().map(row).collect();
    report.table(&["hidden", "spacing, mm", "packing", "verdict", "names", "class"], &rows);
}

/// Returns the report of the second laboratory's trials alone.
#[must_use]
pub fn laboratory_report(outcomes: &[LaboratoryOutcome], command: &str) -> Report {
    let mut report = Report::new("The study in a second laboratory", command);
    report.checks(&laboratory_checks(outcomes));
    laboratory_tables(&mut report, outcomes);
    report
}

/// Returns the report of the trials of the drawn law alone.
#[must_use]
pub fn law_report(outcomes: &[LawOutcome], command: &str) -> Report {
    let mut report = Report::new("The study of drawn laws", command);
    report.checks(&law_checks(outcomes));
    tables(&mut report, outcomes);
    report
}

/// Adds the errors of the runs of measured water.
fn measured(report: &mut Report, result: &MeasuredResult) {
    let [before, after] = result.means_mm();
    report.heading(&format!("Measured water: {}", result.title));
    report.prose(&format!("{} Mean error {before:.2} mm before, {after:.2} mm after.", result.sentence));
    let mm = |m: &f64| format!("{:.2}", 1e3 * m);
    let rows: Vec<_> =
        result.runs.iter().map(|(name, before, after)| vec![name.clone(), mm(before), mm(after)]).collect();
    report.table(&["run", "before, mm", "after, mm"], &rows);
}

/// Returns the rows of trials with nothing hidden, one per glass.
fn clean_rows(trials: &[&JudgedTrial]) -> Vec<Vec<String>> {
    let mut glasses: Vec<&str> = trials.iter().map(|(answer, _)| answer.glass.as_str()).collect();
    glasses.sort_unstable();
    glasses.dedup();
    let row = |glass: &str| {
        let mine: Vec<&Judged> = trials.iter().filter(|(a, _)| a.glass == glass).map(|(_, j)| j).collect();
        let of = |word: &str| format!("{}", mine.iter().filter(|j| j.verdict == word).count());
        let mut names: Vec<&str> =
            mine.iter().filter(|j| j.verdict != "none").flat_map(|j| &j.names).map(String::as_str).collect();
        names.sort_unstable();
        names.dedup();
        let most = mine.iter().filter_map(|j| j.best.as_ref()).max_by(|a, b| a.1.total_cmp(&b.1));
        let most = most.map_or(String::new(), |(name, gain)| format!("{gain:.0} ({name})"));
        let count = format!("{}", mine.len());
        let [none, tied, unknown, named] = ["none", "tied", "unknown", "named"].map(of);
        vec![glass.into(), count, none, tied, unknown, named, names.join(", "), most]
    };
    glasses.into_iter().map(row).collect()
}

/// Returns the row of a trial with something hidden.
fn trial_row(answer: &Answer, judged: &Judged) -> Vec<String> {
    let truth: Vec<String> =
        answer.effects.iter().map(|(name, value)| format!("{name} {value:.3}")).collect();
    let verdict = match judged.verdict.as_str() {
        _ if right(answer, judged) => "named, right",
        "named" if class_right(answer, judged) == Some(true) => "named, of its class",
        "named" => "named, wrong",
        other => other,
    };
    let estimate = |(name, v, a, b): &(String, f64, f64, f64)| format!("{name} {v:.4} ({a:.4} to {b:.4})");
    let mut row = vec![
        truth.join(" + "),
        format!("{}", answer.size),
        verdict.into(),
        judged.names.join(", "),
        judged.class.clone().unwrap_or_default(),
        format!("{:.0}", judged.gain),
        judged.bound.map_or(String::new(), |bound| format!("{bound:.0}")),
        format!("{:.2}", judged.misfit[0]),
        format!("{:.2}", judged.misfit[1]),
        judged.estimate.as_ref().map_or(String::new(), estimate),
    ];
    let mm = |mm: f64| format!("{mm:.2}");
    row.extend(judged.gap_mm.map_or_else(|| [const { String::new() }; 4], |gap| gap.map(mm)));
    row.push(judged.oracle_mm.map_or(String::new(), mm));
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn trial(family: Family, effects: &[(&str, f64)], verdict: &str, names: &[&str]) -> JudgedTrial {
        let answer = Answer {
            family,
            effects: effects.iter().map(|(name, value)| (String::from(*name), *value)).collect(),
            size: 1.0,
            glass: "packing 7".into(),
        };
        let judged = Judged {
            verdict: verdict.into(),
            names: names.iter().map(|name| String::from(*name)).collect(),
            class: None,
            gain: 158.2,
            bound: Some(35.0),
            best: Some(("swirl".into(), 3.0)),
            misfit: [0.44, 0.42],
            estimate: Some(("viscosity".into(), 1.296, 1.2537, 1.3382)),
            gap_mm: Some([0.29, 0.03, 0.02, 0.03]),
            oracle_mm: None,
            suggested: None,
            seconds: 8.0,
        };
        (answer, judged)
    }

    #[test]
    fn the_page_holds_every_trial_and_what_is_missing() {
        let lines = vec![
            trial(Family::Hidden, &[("viscosity", 1.3)], "named", &["viscosity"]),
            trial(Family::Clean, &[], "none", &[]),
        ];
        let planned = BTreeMap::from([(Family::Hidden, 1), (Family::Clean, 2)]);
        let study = StudyTally { lines, planned, ..StudyTally::default() };
        let page = report(&study, "meniscus discover study").markdown();
        for part in [
            "Not all planned trials are judged yet.",
            "| Nothing hidden | 1 | 2 |",
            "| right_of_decided | 1.0000e0 | share | >= 0.95 | ok |",
            "(confusion.png)",
            "| viscosity 1.300 | 1 | named, right | viscosity |  | 158 | 35 | 0.44 | 0.42 | viscosity 1.2960 (1.2537 to 1.3382) | 0.29 | 0.03 | 0.02 | 0.03 |  |",
            "| packing 7 | 1 | 1 | 0 | 0 | 0 |  | 3 (swirl) |",
        ] {
            assert!(page.contains(part), "{part} is missing in {page}");
        }
        assert!(!page.contains("detection.png"), "one size alone");
    }
}
