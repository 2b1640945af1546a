//! The soak's verdict: the program's accounts against the camera's own book, its memory, and its words about a full disk.

use super::Failure;
use super::checks::{self, Check, at_most, check, informational, must};
use super::judge::{REATTACH_S, at, number};
use super::log::Log;
use serde_json::{Value, json};
use std::path::Path;

/// Samples of the memory in the first period: what grows later than this is a leak.
const FIRST_SAMPLES: usize = 10;
/// Growth of the resident memory behind the first period, KiB.
const GROWTH_KIB: f64 = 1024.0;
/// Standstills of the program in a period, and those of them that meet a full disk.
const STANDSTILLS: f64 = 3.0;
const STANDSTILLS_WHILE_FULL: f64 = 1.0;
/// Frames that a standstill of a tenth of a second can make late: six, and two that wait behind them.
const FRAMES_OF_STANDSTILL: f64 = 8.0;
/// Times that the camera leaves the bus in a period: once by its restart, once by hand.
const OUTAGES: f64 = 2.0;
/// Frames of an outage that the program had read and that were not in time: images without a partner, and those in transfers
/// that were cancelled.
const READ_IN_VAIN: f64 = 4.0;
/// The mode is looked at every tenth of a second.
const LOOK_S: f64 = 0.1;

/// Judges a log. `true` when every check is met.
pub(crate) fn judge(log: &Path, json: bool, wall_s: f64) -> Result<bool, Failure> {
    let log = Log::read(log)?;
    let nothing = Value::Null;
    let facts =
        log.facts.iter().find(|(plan, _)| plan.starts_with("soak")).map_or(&nothing, |(_, facts)| facts);
    let mut checks = of(facts);
    let passed = checks.iter().all(Check::passed);
    checks.push(informational("wall_s", wall_s, "s"));
    if json {
        let report = json!({ "command": "hil/run soak", "facts": facts, "checks": checks::json(&checks) });
        println!("{}", serde_json::to_string_pretty(&report)?);
    } else {
        checks::print(&checks);
    }
    Ok(passed)
}

fn of(facts: &Value) -> Vec<Check> {
    let of = |path: &str| number(facts, path);
    let periods = of("periods");
    let account = |name: &str| of(&format!("accounts.{name}"));
    let (in_time, late, lost) = (account("in_time"), account("late"), account("lost"));
    let never_handled = account("never_handled");
    let booked = in_time + late + lost + never_handled;
    let (exposed, away) = (of("book.exposed"), of("book.away"));
    let exactly = |name: &str, value: f64, wanted: f64| {
        check(name, value, "1", &format!("= {wanted}"), value == wanted)
    };
    let complaints = facts["kernel_complaints"].as_array().map_or(f64::NAN, |lines| lines.len() as f64);
    let mut checks = vec![
        informational("guest_s", of("guest_s"), "s"),
        informational("frames_exposed", exposed, "1"),
        informational("frames_away", away, "1"),
        informational("frames_in_time", in_time, "1"),
        informational("frames_late", late, "1"),
        informational("frames_lost", lost, "1"),
        informational("frames_never_handled", never_handled, "1"),
        // The clock that counts the frames of an outage is the computer's: each end of one may fall on either side of a frame.
        at_most("frames_off_the_book", (booked - exposed - away).abs(), "1", OUTAGES * periods),
        // Frames that were read and not in time: those of the standstills, and a few around each outage.
        at_most(
            "frames_read_not_in_time",
            of("book.read") - in_time,
            "1",
            periods * (STANDSTILLS * FRAMES_OF_STANDSTILL + OUTAGES * READ_IN_VAIN),
        ),
        check(
            "standstills_counted",
            late + never_handled,
            "1",
            &format!(">= {}", STANDSTILLS * periods),
            late + never_handled >= STANDSTILLS * periods,
        ),
        exactly("restarts", at(facts, "camera_health.rungs")[2].as_f64().unwrap_or(f64::NAN), periods),
        exactly("attached", length(facts, "attached_s"), 1.0 + OUTAGES * periods),
        at_most("reattach_to_track_s", longest_return(facts), "s", REATTACH_S + LOOK_S),
    ];
    checks.extend(memory(facts));
    checks.extend(disk(facts, periods));
    // A turn that a standstill interrupts is late.
    checks.push(at_most("turns_late", of("checks.turns_late.value"), "1", STANDSTILLS * periods));
    for name in ["energy_drift_step", "entropy_falls", "allocations"] {
        checks.push(must(&format!("{name}_ok"), at(facts, &format!("checks.{name}.ok")) == true));
    }
    checks.push(exactly("exit", of("exit"), 0.0));
    checks.push(exactly("kernel_complaints", complaints, 0.0));
    checks
}

fn length(facts: &Value, path: &str) -> f64 {
    at(facts, path).as_array().map_or(f64::NAN, |array| array.len() as f64)
}

/// Largest resident memory, and its growth behind the first period.
fn memory(facts: &Value) -> [Check; 2] {
    let samples: Vec<f64> =
        facts["memory_kib"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    let (first, later) = samples.split_at(samples.len().min(FIRST_SAMPLES));
    let largest = |samples: &[f64]| samples.iter().copied().fold(f64::NAN, f64::max);
    // A process that has ended has none.
    let alive = samples.iter().all(|kib| *kib > 0.0);
    let growth = if alive { largest(later) - largest(first) } else { f64::NAN };
    [
        informational("memory_kib", largest(&samples), "KiB"),
        at_most("memory_growth_kib", growth, "KiB", GROWTH_KIB),
    ]
}

/// Words about the disk: when it was full, when it took records again, and how many it did not take.
fn disk(facts: &Value, periods: f64) -> [Check; 3] {
    let lines: Vec<&str> = words(facts).map(|(_, line)| line).collect();
    let with =
        |words: [&str; 2]| lines.iter().filter(|line| words.iter().all(|word| line.contains(word))).count();
    let named = with(["a record of a missed deadline is lost", "No space left on device"]) as f64;
    let again = with(["records of missed deadlines are written again", ""]) as f64;
    let prefix = "records of missed deadlines that could not be written: ";
    let counted =
        lines.iter().find_map(|line| line.strip_prefix(prefix)?.split(';').next()?.parse::<f64>().ok());
    let counted = counted.unwrap_or(f64::NAN);
    let lost = STANDSTILLS_WHILE_FULL * periods;
    [
        check("full_disks_named", named, "1", &format!("= {periods}"), named == periods),
        check("disks_used_again", again, "1", &format!("= {periods}"), again == periods),
        check("records_lost_counted", counted, "1", &format!("= {lost}"), counted == lost),
    ]
}

/// The program's words with their times, s.
fn words(facts: &Value) -> impl Iterator<Item = (f64, &str)> {
    let lines = facts["words"].as_array().into_iter().flatten();
    lines.filter_map(|line| Some((line[0].as_f64()?, line[1].as_str()?)))
}

/// Longest time from an attachment, but the first, to the first tracking turn behind it, s; infinite where there is none.
fn longest_return(facts: &Value) -> f64 {
    let attached = facts["attached_s"].as_array().into_iter().flatten().filter_map(Value::as_f64);
    let tracking = |at_s: f64| {
        let found = words(facts).find(|(said_s, line)| *said_s > at_s && *line == "mode: Tracking");
        found.map_or(f64::INFINITY, |(said_s, _)| said_s - at_s)
    };
    attached.skip(1).map(tracking).fold(f64::NAN, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Facts of a run of six periods of a minute that went well.
    fn good() -> Value {
        let mut words = vec![json!([0.5, "mode: Tracking"])];
        let mut attached = vec![json!(0.0)];
        for period in 0..6 {
            let from_s = 60.0 * f64::from(period);
            for outage_s in [20.0, 32.0] {
                attached.push(json!(from_s + outage_s));
                words.push(json!([from_s + outage_s + 1.2, "mode: Tracking"]));
            }
            words.push(json!([from_s + 46.0,
                "a record of a missed deadline is lost: cannot write x: No space left on device (os error 28); the run goes on"]));
            words.push(json!([from_s + 55.0, "records of missed deadlines are written again; 1 were not"]));
        }
        words.push(json!([
            361.0,
            "records of missed deadlines that could not be written: 6; the last one: cannot write x"
        ]));
        let ok = json!({ "ok": true });
        json!({ "exit": 0, "periods": 6, "guest_s": 362.0, "kernel_complaints": [], "words": words,
            "attached_s": attached, "memory_kib": vec![200_000; 60],
            "camera_health": { "rungs": [6, 6, 6, 0, 12] },
            "accounts": { "in_time": 16_000, "late": 20, "lost": 5_500, "never_handled": 80, "over_s": 360.0 },
            "book": { "exposed": 17_000, "away": 4_597, "read": 16_040 },
            "checks": { "energy_drift_step": ok, "entropy_falls": ok, "turns_late": { "value": 2 }, "allocations": ok } })
    }

    fn missed(facts: &Value) -> Vec<String> {
        of(facts).into_iter().filter(|check| !check.passed()).map(|check| check.name).collect()
    }

    /// The good facts with one value changed.
    fn with(path: &str, value: impl Into<Value>) -> Value {
        let mut facts = good();
        *facts.pointer_mut(path).expect("a value") = value.into();
        facts
    }

    #[test]
    fn each_harm_has_a_check_that_it_misses() {
        assert!(missed(&good()).is_empty(), "{:?}", missed(&good()));
        assert_eq!(
            missed(&with("/accounts/lost", 5_480)),
            ["frames_off_the_book"],
            "twenty frames in no account"
        );
        assert_eq!(missed(&with("/accounts/lost", 5_560)), ["frames_off_the_book"]);
        assert_eq!(missed(&with("/book/read", 16_193)), ["frames_read_not_in_time"]);
        assert_eq!(missed(&with("/memory_kib/59", 201_100)), ["memory_growth_kib"]);
        assert_eq!(missed(&with("/memory_kib/30", 0)), ["memory_growth_kib"], "a process that has ended");
        assert_eq!(missed(&with("/words/3/1", "x")), ["full_disks_named"]);
        assert_eq!(missed(&with("/words/4/1", "x")), ["disks_used_again"]);
        assert_eq!(missed(&with("/words/25/1", "x")), ["records_lost_counted"]);
        assert_eq!(missed(&with("/words/24/1", "mode: Tracking")), ["disks_used_again"]);
        assert_eq!(missed(&with("/words/22/1", "mode: Halted")), ["reattach_to_track_s"]);
        assert_eq!(missed(&with("/checks/turns_late/value", 19)), ["turns_late"]);
        assert_eq!(missed(&with("/checks/entropy_falls/ok", false)), ["entropy_falls_ok"]);
        assert_eq!(missed(&with("/camera_health/rungs/2", 5)), ["restarts"]);
        assert_eq!(missed(&with("/attached_s", json!([0.0, 20.0]))), ["attached"]);
        assert_eq!(missed(&with("/exit", 1)), ["exit"]);
        assert_eq!(missed(&with("/kernel_complaints", json!(["BUG: x"]))), ["kernel_complaints"]);
    }

    #[test]
    fn nothing_passes_without_facts() {
        assert!(of(&Value::Null).iter().all(|check| !check.passed()), "{:?}", of(&Value::Null));
    }
}
