//! Checks and page of a study.

use super::draw::StudyLiquid;
use super::judge::Outcome;
use meniscus_numerics::statistics::{median, quantile};
use meniscus_report::Report;
use meniscus_report::checks::Check;

/// Time of minimum jerk at equal crest, as a target for the plan's share of it.
const TIME_TARGET: f64 = 0.75;
/// Crest of minimum jerk at equal time, as a target for the plan's share of it.
const CREST_TARGET: f64 = 0.5;
/// Share of moves whose crest may be above the limit at a confidence of 0.95.
const BROKEN_TARGET: f64 = 0.05;
/// Time of a plan, ms.
const SOLVE_TARGET_MS: f64 = 20.0;

/// Share of `outcomes` for which `holds`.
fn share(outcomes: &[&Outcome], holds: impl Fn(&Outcome) -> bool) -> f64 {
    outcomes.iter().filter(|one| holds(one)).count() as f64 / outcomes.len() as f64
}

/// Median of a figure over `outcomes`; not a number without any.
fn middle(outcomes: &[&Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
    median(outcomes.iter().map(|one| of(one))).unwrap_or(f64::NAN)
}

/// Whether the crest was above the limit.
fn broken(one: &Outcome) -> bool {
    one.crest_m > one.of.request.limit_m
}

/// Returns the checks of `outcomes` out of `planned` moves.
#[must_use]
pub fn checks(outcomes: &[Outcome], planned: usize) -> Vec<Check> {
    let all: Vec<&Outcome> = outcomes.iter().collect();
    let solves = outcomes.iter().flat_map(|one| one.solve_ms.iter().copied());
    let slowest = quantile(solves.clone(), 0.99).unwrap_or(f64::NAN);
    let time = |one: &Outcome| one.arrival_s / one.equal_crest_s;
    let crest = |one: &Outcome| one.crest_m / one.minimum_jerk_m;
    let mut checks = vec![
        Check::at_most("time_over_minimum_jerk_at_equal_crest", middle(&all, time), "1", TIME_TARGET),
        Check::at_most("crest_over_minimum_jerk_at_equal_time", middle(&all, crest), "1", CREST_TARGET),
        Check::at_most("limit_broken_share", share(&all, broken), "1", BROKEN_TARGET),
        Check::at_most("solve_ms_p99", slowest, "ms", SOLVE_TARGET_MS),
        Check::exactly("moves_done", outcomes.len() as f64, "1", planned as f64),
        Check::informational(
            "crest_over_limit_median",
            middle(&all, |one| one.crest_m / one.of.request.limit_m),
            "1",
        ),
        Check::informational(
            "crest_over_limit_largest",
            all.iter().map(|one| one.crest_m / one.of.request.limit_m).fold(f64::NAN, f64::max),
            "1",
        ),
        Check::informational(
            "lowest_crest_of_the_model_over_minimum_jerk",
            middle(&all, |one| one.model_bound),
            "1",
        ),
        Check::informational("solve_ms_median", median(solves).unwrap_or(f64::NAN), "ms"),
        Check::informational("plans_unsolved", outcomes.iter().map(|one| one.unsolved as f64).sum(), "1"),
    ];
    for liquid in StudyLiquid::ALL {
        let of: Vec<&Outcome> = outcomes.iter().filter(|one| one.of.liquid == liquid).collect();
        let name = |figure: &str| format!("{figure}_{}", liquid.name());
        checks.push(Check::informational(name("time_ratio"), middle(&of, time), "1"));
        checks.push(Check::informational(name("crest_ratio"), middle(&of, crest), "1"));
        checks.push(Check::informational(name("broken_share"), share(&of, broken), "1"));
    }
    for rival in rivals(outcomes) {
        let of = |one: &Outcome| {
            one.rivals_m.iter().find(|(name, _)| *name == rival).and_then(|(_, crest)| *crest)
        };
        let ratios = outcomes.iter().filter_map(|one| of(one).map(|crest| one.predicted_m[0] / crest));
        let name = format!("forecast_crest_over_{}_at_equal_time", rival.replace(' ', "_"));
        checks.push(Check::informational(name, median(ratios).unwrap_or(f64::NAN), "1"));
    }
    checks
}

/// Names of the other rivals.
fn rivals(outcomes: &[Outcome]) -> Vec<String> {
    let first = outcomes.first().map(|one| &one.rivals_m);
    first.map_or_else(Vec::new, |all| all.iter().map(|(name, _)| name.clone()).collect())
}

/// Returns the page of `outcomes` out of `planned` moves, which `command` makes again.
#[must_use]
pub fn report(outcomes: &[Outcome], planned: usize, command: &str) -> Report {
    let mut report = Report::new("Planned moves in the simulator", command);
    if outcomes.len() < planned {
        report.answer(&format!(
            "Partial: {} of {planned} moves were carried out. The same command continues.",
            outcomes.len()
        ));
    }
    report.checks(&checks(outcomes, planned));
    let names = rivals(outcomes);
    let mut head = vec![
        "liquid",
        "seed",
        "distance, m",
        "limit, mm",
        "time, s",
        "crest, mm",
        "predicted, mm",
        "minimum jerk, mm",
        "its time at this crest, s",
    ];
    head.extend(names.iter().map(String::as_str));
    let mm = |m: f64| format!("{:.2}", 1e3 * m);
    let row = |one: &Outcome| {
        let [crest, half] = one.predicted_m;
        let mut row = vec![
            one.of.liquid.name().into(),
            one.of.seed.to_string(),
            format!("{:.3}", one.of.request.to_m),
            mm(one.of.request.limit_m),
            format!("{:.3}", one.arrival_s),
            mm(one.crest_m),
            format!("{} ± {}", mm(crest), mm(half)),
            mm(one.minimum_jerk_m),
            format!("{:.3}", one.equal_crest_s),
        ];
        row.extend(one.rivals_m.iter().map(|(_, crest)| crest.map_or("too long".into(), mm)));
        row
    };
    report.table(&head, &outcomes.iter().map(row).collect::<Vec<_>>());
    report
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::carry::Trace;
    use crate::study::draw::Move;
    use crate::study::judge::Planner;

    fn outcome(seed: u64, crest_over_limit: f64) -> Outcome {
        let of = Move::new(StudyLiquid::Water, seed);
        let limit_m = of.request.limit_m;
        Outcome {
            version: super::super::judge::VERSION,
            of,
            planner: Planner::Learned,
            planned_s: 0.9,
            arrival_s: 0.9,
            predicted_m: [0.9 * limit_m, 0.1 * limit_m],
            crest_m: crest_over_limit * limit_m,
            solve_ms: vec![5.0, 30.0],
            unsolved: 0,
            minimum_jerk_m: 2.0 * limit_m,
            equal_crest_s: 1.2,
            rivals_m: vec![("trapezoid".into(), Some(1.5 * limit_m)), ("input shaping".into(), None)],
            model_bound: 0.7,
            planned: Trace::default(),
            minimum_jerk: Trace::default(),
        }
    }

    #[test]
    fn an_interrupted_study_says_that_it_is_partial() {
        let outcomes = [outcome(1, 0.9), outcome(2, 1.1)];
        let page = report(&outcomes, 5, "meniscus plan study").text();
        assert!(page.contains("Partial: 2 of 5 moves"), "{page}");
        let all = checks(&outcomes, 5);
        let of = |name: &str| all.iter().find(|check| check.name == name).expect(name);
        assert!(of("moves_done").missed());
        assert!(!report(&outcomes, 2, "x").text().contains("Partial"));
        assert_eq!(of("limit_broken_share").value, Some(0.5));
        assert_eq!(of("time_over_minimum_jerk_at_equal_crest").value, Some(0.75));
        assert!(of("solve_ms_p99").missed());
        assert!(
            (of("forecast_crest_over_trapezoid_at_equal_time").value.expect("a value") - 0.6).abs() < 1e-9
        );
        assert!(of("forecast_crest_over_input_shaping_at_equal_time").value.is_none());
    }

    #[test]
    fn nothing_done_is_nothing_measured() {
        let all = checks(&[], 3);
        assert!(all.iter().filter(|check| check.ok.is_some()).all(Check::missed));
    }
}
