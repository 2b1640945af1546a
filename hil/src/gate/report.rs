//! The gate's verdict: every scenario, the boots against each other where there are two, and the golden log.

use super::Failure;
use super::checks::{self, Check, check, informational};
use super::judge::{self, REATTACH_S, Wrong, at, number};
use super::log::{Log, difference};
use super::scenarios::{GATE, Must, Scenario};
use serde_json::{Value, json};
use std::path::Path;

/// The checks of another command's report.
fn checks_of(report: &Path) -> Result<Vec<Check>, Failure> {
    let text = std::fs::read(report).map_err(|error| format!("{}: {error}", report.display()))?;
    let report: Value = serde_json::from_slice(&text)?;
    let checks = report["checks"].as_array().into_iter().flatten();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let read = |c: &Value| {
        let value = number(c, "value");
        let known = check(&text(&c["name"]), value, &text(&c["unit"]), &text(&c["target"]), true);
        Check { ok: c["ok"].as_bool(), ..known }
    };
    Ok(checks.filter(|check| check["name"] != "wall_s").map(read).collect())
}

/// Options of the verdict.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wanted<'w> {
    /// One JSON object instead of a table.
    pub(crate) json: bool,
    /// Write the golden log anew.
    pub(crate) bless: bool,
    /// Wall time of everything before, seconds.
    pub(crate) wall_s: f64,
    /// Reports of other commands whose checks belong to the gate's.
    pub(crate) with: &'w [&'w Path],
}

/// Logs of the boots.
pub(crate) struct Boots<'l> {
    pub(crate) first: &'l Path,
    /// The other boot of the same image. Without it the golden log alone shows that two boots end alike.
    pub(crate) second: Option<&'l Path>,
}

/// Judges the boots. `true` when every check is met.
pub(crate) fn judge(boots: Boots<'_>, film: &Path, golden: &Path, wanted: Wanted) -> Result<bool, Failure> {
    let first = Log::read(boots.first)?;
    let second = boots.second.map(Log::read).transpose()?;
    let film: Value = serde_json::from_slice(&std::fs::read(film)?)?;
    let verdicts: Vec<(&Scenario, Wrong)> =
        GATE.iter().map(|scenario| verdict(scenario, &first, &film)).collect();
    let verdict_lines: Vec<String> =
        verdicts.iter().map(|(scenario, wrong)| line(scenario, wrong, &first)).collect();
    if wanted.bless {
        let text = verdict_lines.join("\n") + "\n";
        let folder = golden.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = folder.and_then(|()| std::fs::write(golden, text));
        written.map_err(|error| format!("{} cannot be written: {error}", golden.display()))?;
    }
    let kept = std::fs::read_to_string(golden).unwrap_or_default();
    let compared: Vec<String> = verdicts
        .iter()
        .zip(&verdict_lines)
        .map(|((scenario, _), line)| as_kept(scenario, line.clone(), &kept))
        .collect();
    let off = compared.iter().zip(&verdict_lines).filter(|(compared, line)| compared != line).count();
    let between = second.as_ref().map(|second| difference(&strs(&first.lines), &strs(&second.lines)));
    let against = difference(&kept.lines().collect::<Vec<_>>(), &strs(&compared));
    let mut checks = gathered(&verdicts, &first, &film, &against);
    if let Some(between) = &between {
        let identical = between.is_empty() && !first.lines.is_empty();
        checks.push(check("logs_identical", f64::from(u8::from(identical)), "1", "= 1", identical));
    }
    for report in wanted.with {
        checks.extend(checks_of(report)?);
    }
    checks.push(informational("golden_off_by_a_frame", off as f64, "1"));
    let passed = checks.iter().all(Check::passed);
    // The machine's time, which others may use, and not the program's.
    checks.push(informational("wall_s", wanted.wall_s, "s"));
    if wanted.json {
        println!("{}", serde_json::to_string_pretty(&object(&verdicts, &first, &checks))?);
    } else {
        text(&verdicts, &first, &checks);
    }
    let show = |what: &str, lines: &[String]| {
        if !lines.is_empty() {
            eprintln!("{what}:");
            lines
                .iter()
                .take(40)
                .for_each(|line| eprintln!("{}", line.chars().take(2000).collect::<String>()));
        }
    };
    show("the two boots differ", between.as_deref().unwrap_or_default());
    show(&format!("{} differs (hil/run gate --bless writes it anew)", golden.display()), &against);
    Ok(passed)
}

fn strs(lines: &[String]) -> Vec<&str> {
    lines.iter().map(String::as_str).collect()
}

fn verdict<'s>(scenario: &'s Scenario, log: &Log, film: &Value) -> (&'s Scenario, Wrong) {
    match log.of(scenario.plan) {
        Some(facts) => (scenario, judge::judge(scenario, facts, film)),
        None => (scenario, vec!["it did not run".into()]),
    }
}

/// A line of the golden log: what a change of the program may change only on purpose, and no time.
fn line(scenario: &Scenario, wrong: &Wrong, log: &Log) -> String {
    let nothing = Value::Null;
    let facts = log.of(scenario.plan).unwrap_or(&nothing);
    let mut words = vec![format!("{} {}", scenario.chapter, scenario.plan)];
    for key in
        ["camera_health.rungs", "camera_notes", "turns.gaps", "turns.stale_as_fresh", "turns.last_mode"]
    {
        let value = at(facts, key);
        if !value.is_null() {
            words.push(format!("{}={value}", key.rsplit('.').next().unwrap_or(key)));
        }
    }
    for losses in ["losses.depth", "losses.infrared"] {
        let counted = at(facts, losses).as_object().into_iter().flatten();
        for (name, count) in counted.filter(|(_, count)| count.as_u64().is_some_and(|count| count > 0)) {
            words.push(format!("{losses}.{name}={count}"));
        }
    }
    if matches!(scenario.must, Must::Refuse(_)) {
        words.push(format!("said={}", facts["said"]));
    }
    words.push(if wrong.is_empty() { "ok".into() } else { "MISSED".into() });
    words.join(" ")
}

/// Returns the line of the golden log where it differs from `line` by one frame of a recovery, and `line` elsewhere.
///
/// Time in the guest is instructions, and the ladder's rungs are climbed by that time: with other instructions in the program a rung
/// falls before or behind a frame of the camera. That is no change on purpose.
fn as_kept(scenario: &Scenario, line: String, kept: &str) -> String {
    let recovers = matches!(scenario.must, Must::Recover(_));
    let same = kept.lines().find(|kept| recovers && within_a_frame(kept, &line));
    same.map_or(line, str::to_owned)
}

/// Whether two lines are the same but for counts of lost frames that differ by one.
fn within_a_frame(kept: &str, line: &str) -> bool {
    let close = |(kept, word): (&str, &str)| {
        let count = |word: &str| {
            let (name, count) = word.split_once('=')?;
            let lost = name == "gaps" || name.ends_with(".counter_gap");
            Some((name.to_owned(), count.parse::<u64>().ok().filter(|_| lost)?))
        };
        let counts = count(kept).zip(count(word));
        kept == word || counts.is_some_and(|(kept, now)| kept.0 == now.0 && kept.1.abs_diff(now.1) <= 1)
    };
    kept.split(' ').count() == line.split(' ').count() && kept.split(' ').zip(line.split(' ')).all(close)
}

fn gathered(verdicts: &[(&Scenario, Wrong)], log: &Log, film: &Value, against: &[String]) -> Vec<Check> {
    let nothing = Value::Null;
    let of = |wanted: fn(&Must) -> bool| {
        let found = verdicts.iter().find(|(scenario, _)| wanted(&scenario.must));
        found.and_then(|(scenario, _)| log.of(scenario.plan)).unwrap_or(&nothing)
    };
    let (stream, track) =
        (of(|must| matches!(must, Must::Stream(_))), of(|must| matches!(must, Must::Track(_))));
    let (fps, gaps) = (number(stream, "turns.fps"), number(stream, "turns.gaps"));
    let passed = verdicts.iter().filter(|(_, wrong)| wrong.is_empty()).count() as f64;
    let total = verdicts.len() as f64;
    let stale: f64 = log
        .facts
        .iter()
        .map(|(_, facts)| number(facts, "turns.stale_as_fresh"))
        .filter(|n| n.is_finite())
        .sum();
    let back: Vec<f64> = log.facts.iter().flat_map(|(_, facts)| reattached(facts)).collect();
    let reattach_s = back.iter().copied().fold(f64::NAN, f64::max);
    let ratio = judge::field_error_ratio(track, film).unwrap_or(f64::NAN);
    let is = |it: bool| f64::from(u8::from(it));
    vec![
        check("fps", fps, "Hz", "60 +- 0.1", (59.9..=60.1).contains(&fps)),
        check("gaps", gaps, "1", "= 0", gaps == 0.0),
        check("scenarios_passed", passed, "1", "= scenarios_total", passed == total),
        informational("scenarios_total", total, "1"),
        check("golden_identical", is(against.is_empty()), "1", "= 1", against.is_empty()),
        check("reattach_to_track_s", reattach_s, "s", "<= 1.5", reattach_s <= REATTACH_S),
        check("stale_as_fresh", stale, "1", "= 0", stale == 0.0),
        check("field_error_ratio", ratio, "1", "0.95 to 1.05", (ratio - 1.0).abs() <= 0.05),
    ]
}

/// Times from each re-attachment to the first tracked frame; infinite where there was none.
fn reattached(facts: &Value) -> Vec<f64> {
    let times = at(facts, "turns.reattach_to_track_s").as_array();
    times.into_iter().flatten().map(|time| time.as_f64().unwrap_or(f64::INFINITY)).collect()
}

fn object(verdicts: &[(&Scenario, Wrong)], log: &Log, checks: &[Check]) -> Value {
    let scenarios: Vec<Value> = verdicts
        .iter()
        .enumerate()
        .map(|(place, (scenario, wrong))| {
            json!({ "chapter": scenario.chapter, "plan": scenario.plan, "ok": wrong.is_empty(), "wrong": wrong,
                    "wall_s": log.wall_s.get(place),
                    "guest_s": log.of(scenario.plan).map(|facts| facts["guest_s"].clone()) })
        })
        .collect();
    json!({ "command": "hil/run gate", "scenarios": scenarios, "checks": checks::json(checks) })
}

fn text(verdicts: &[(&Scenario, Wrong)], log: &Log, checks: &[Check]) {
    for (place, (scenario, wrong)) in verdicts.iter().enumerate() {
        let guest_s = log.of(scenario.plan).map_or(f64::NAN, |facts| number(facts, "guest_s"));
        let wall_s = log.wall_s.get(place).copied().unwrap_or(f64::NAN);
        let verdict = if wrong.is_empty() { "ok" } else { "MISSED" };
        println!(
            "{} {:<28} {guest_s:>7.1} s in the guest {wall_s:>7.1} s  {verdict}",
            scenario.chapter, scenario.plan
        );
        wrong.iter().for_each(|wrong| println!("    {wrong}"));
    }
    checks::print(checks);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recovery_may_lose_one_frame_more_or_less_and_nothing_else_may_differ() {
        let kept = "6 run:quiet-restart:12 gaps=135 stale_as_fresh=0 losses.depth.counter_gap=132 ok";
        let with = |from: &str, to: &str| kept.replace(from, to);
        assert!(within_a_frame(kept, kept));
        assert!(within_a_frame(kept, &with("135", "134").replace("132", "131")));
        for other in [
            with("135", "133"),
            with("stale_as_fresh=0", "stale_as_fresh=1"),
            with("ok", "MISSED"),
            with(" ok", ""),
            with("quiet-restart", "quiet-reset"),
        ] {
            assert!(!within_a_frame(kept, &other), "{other}");
        }
        let of = |must| Scenario { chapter: 6, plan: "run:quiet-restart:12", must };
        let line = with("135", "134");
        assert_eq!(as_kept(&of(Must::Recover(2)), line.clone(), kept), kept);
        assert_eq!(as_kept(&of(Must::Flash), line.clone(), kept), line);
    }
}
