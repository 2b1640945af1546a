//! Checks of the study.

use super::unseen::{BLIND, TARGET, errors};
use super::{LiquidResult, SOURCE, Study, Trial, percent};
use meniscus::blob::FieldGroup;
use meniscus_numerics::statistics::median;
use meniscus_report::checks::Check;
use meniscus_score::field_error::GroupError;
use meniscus_score::unknown_groups::in_checks;

/// Every figure of the study.
#[must_use]
pub fn checks(study: &Study) -> Vec<Check> {
    let mut checks = Vec::new();
    let mut unknown = study.source.unknown_shown.len();
    for result in &study.results {
        let first = checks.len();
        liquid(&mut checks, result);
        let after = &result.after;
        unknown += after.unknown_shown.len() + in_checks(&checks[first..], after.score.known).len();
    }
    let first = checks.len();
    source_liquid(&mut checks, &study.source);
    for LiquidResult { course, after, .. } in &study.results {
        let name = format!("{}_interval_coverage", course.name);
        checks.push(Check::informational(name, percent(after.score.held.share()), "%"));
    }
    outside_range(&mut checks, &study.outside);
    motion_sources(&mut checks, study);
    laws(&mut checks, study);
    for (name, [said, still]) in ["forecast_250ms", "forecast_500ms"].iter().zip(study.source.forecast) {
        checks.push(Check::at_most(*name, percent(said), "%", percent(still)));
    }
    unknown += in_checks(&checks[first..], study.source.score.known).len();
    checks.push(Check::exactly("unknown_groups_shown", unknown as f64, "1", 0.0));
    checks
}

/// Growth of the error on the source recordings, percentage points.
fn forgotten(errors: [f64; 2]) -> f64 {
    let [before, after] = errors;
    percent(after - before)
}

/// Figures of one liquid before and after correction.
fn liquid(checks: &mut Vec<Check>, result: &LiquidResult) {
    let LiquidResult { course, before, after, source, .. } = result;
    let name = |what: &str| format!("{}_{what}", course.name);
    let surface = |trial: &Trial| trial.score.estimate;
    checks.push(Check::informational(name("before_max"), percent(surface(before).max), "%"));
    checks.push(Check::informational(name("before_mean"), percent(surface(before).mean()), "%"));
    checks.push(Check::at_most(name("after_max"), percent(surface(after).max), "%", course.target[0]));
    checks.push(Check::at_most(name("after_mean"), percent(surface(after).mean()), "%", course.target[1]));
    checks.push(Check::informational(name("before_slosh"), percent(surface(before).slosh_rel()), "%"));
    checks.push(Check::informational(name("after_slosh"), percent(surface(after).slosh_rel()), "%"));
    checks.push(Check::informational(
        name("persistence_slosh"),
        percent(after.score.persistence.slosh_rel()),
        "%",
    ));
    for (lead, name_of) in ["250ms", "500ms"].into_iter().enumerate() {
        for (when, trial) in [("before", before), ("after", after)] {
            let planned = percent(trial.planned.forecast[lead]);
            checks.push(Check::informational(name(&format!("{when}_planned_{name_of}")), planned, "%"));
        }
        let [said, still] = after.forecast[lead].map(percent);
        checks.push(Check::at_most(name(&format!("forecast_{name_of}")), said, "%", still));
    }
    checks.push(Check::at_most(name("source_forgetting"), forgotten(*source), "%", 5.0));
}

/// Figures of the source liquid: errors, coverage, forecasts and crests.
fn source_liquid(checks: &mut Vec<Check>, source: &Trial) {
    checks.extend(errors(SOURCE.0, source));
    checks.push(Check::within("interval_coverage", percent(source.score.held.share()), "%", 85.0, 95.0));
    for GroupError { name, held, .. } in source.score.known_field() {
        checks.push(Check::informational(format!("interval_coverage_{name}"), percent(held.share()), "%"));
    }
    for (lead, held) in ["250ms", "500ms"].iter().zip(source.forecast_held) {
        checks.push(Check::within(
            format!("interval_coverage_{lead}"),
            percent(held.share()),
            "%",
            85.0,
            95.0,
        ));
    }
    let crests = &source.crests_ahead;
    let off = |errors: &[f64]| median(errors.iter().map(|e| e.abs())).unwrap_or(f64::NAN);
    checks.push(Check::informational("crest_ahead_height", 1e3 * off(&crests.height_m), "mm"));
    checks.push(Check::informational("crest_ahead_time", 1e3 * off(&crests.time_s), "ms"));
    checks.push(Check::informational("crest_ahead_coverage", percent(crests.held.share()), "%"));
    let planned = &source.planned;
    for ((name, said), held) in ["250ms", "500ms"].iter().zip(planned.forecast).zip(&planned.held) {
        checks.push(Check::informational(format!("forecast_planned_{name}"), percent(said), "%"));
        checks.push(Check::informational(
            format!("forecast_planned_{name}_coverage"),
            percent(held.share()),
            "%",
        ));
    }
    checks.push(Check::informational("crest_planned_height", 1e3 * off(&planned.crests.height_m), "mm"));
    checks.push(Check::informational("crest_planned_time", 1e3 * off(&planned.crests.time_s), "ms"));
    checks.push(Check::informational("crest_planned_coverage", percent(planned.crests.held.share()), "%"));
}

/// Figures of the source liquid moved further and harder than any training recording.
fn outside_range(checks: &mut Vec<Check>, outside: &Trial) {
    let outside = &outside.score;
    checks.push(Check::informational("outside_slosh_rel", percent(outside.estimate.slosh_rel()), "%"));
    checks.push(Check::informational("outside_mean", percent(outside.estimate.mean()), "%"));
    checks.push(Check::informational("outside_max", percent(outside.estimate.max), "%"));
    for GroupError { name, error, .. } in outside.known_field() {
        checks.push(Check::informational(format!("outside_field_{name}"), percent(error), "%"));
    }
    checks.push(Check::informational("outside_interval_coverage", percent(outside.held.share()), "%"));
}

/// Figures of the estimate with the motion from each source, and of the forecasts of the acceleration.
fn motion_sources(checks: &mut Vec<Check>, study: &Study) {
    for one in &study.motion {
        let name = |what: &str| format!("motion_{}_{what}", one.name);
        let slosh = percent(one.score.estimate.slosh_rel());
        let [of_slosh, of_v] = if one.name == "none" { BLIND } else { [TARGET.0, TARGET.1[1]] };
        checks.push(Check::at_most(name("slosh_rel"), slosh, "%", of_slosh));
        let field = |one: GroupError| {
            let (check, error) = (name(&format!("field_{}", one.name)), percent(one.error));
            match one.group {
                FieldGroup::Velocity => Check::at_most(check, error, "%", of_v),
                _ => Check::informational(check, error, "%"),
            }
        };
        checks.extend(one.score.known_field().map(field));
    }
    for (track, missed) in ["true", "tracked"].iter().zip(study.acceleration_forecast) {
        checks.push(Check::informational(
            format!("acceleration_forecast_{track}_position"),
            percent(missed),
            "%",
        ));
    }
    checks.push(Check::informational("acceleration_forecast_oracle", percent(study.oracle_error), "%"));
}

/// Forgetting, entropy and energy over the whole study.
fn laws(checks: &mut Vec<Check>, study: &Study) {
    let worst = study.results.iter().map(|result| forgotten(result.source));
    checks.push(Check::at_most("source_forgetting", worst.fold(0.0, f64::max), "%", 5.0));
    let trials =
        || study.results.iter().flat_map(|r| [&r.before, &r.after]).chain([&study.source, &study.outside]);
    let falls: usize = trials().map(|t| t.entropy_falls).sum();
    checks.push(Check::exactly("entropy_falls", falls as f64, "1", 0.0));
    let drift = trials().map(|t| t.energy_drift).fold(0.0, f64::max);
    checks.push(Check::at_most("energy_drift_step", drift, "H", 1e-6));
}
