//! The study as checks and as a page.

use super::Outcome;
use meniscus_platform::realtime::Priority;
use meniscus_report::checks::{Check, table};

/// Misses that a page shows of each run, the longest first.
const SHOWN: usize = 12;

/// Returns the checks of all runs. At 60 Hz no frame may be missed; faster runs are informational.
#[must_use]
pub fn checks(outcomes: &[Outcome]) -> Vec<Check> {
    outcomes.iter().flat_map(of).collect()
}

fn of(outcome: &Outcome) -> Vec<Check> {
    let (run, tally) = (&outcome.run, &outcome.tally);
    let loads: Vec<&str> = run.loads.iter().map(|load| load.name()).collect();
    let beside = if loads.is_empty() { String::from("idle") } else { loads.join("_") };
    let rights = if run.priority == Priority::RealTime { "" } else { "_ordinary" };
    let name = |what: &str| format!("deadline_{}hz_{beside}{rights}_{what}", run.rate_hz);
    let missed = tally.missed() as f64;
    let ratio = tally.within_us(0.999) / tally.within_us(0.5);
    let strict = run.rate_hz <= 60.0;
    vec![
        Check::informational(name("frames"), tally.frames as f64, "1"),
        if strict {
            Check::exactly(name("missed"), missed, "1", 0.0)
        } else {
            Check::informational(name("missed"), missed, "1")
        },
        Check::informational(name("median"), tally.within_us(0.5), "us"),
        if strict && run.loads.is_empty() {
            Check::at_most(name("p999_over_median"), ratio, "1", 2.0)
        } else {
            Check::informational(name("p999_over_median"), ratio, "1")
        },
        Check::informational(name("p99999"), tally.within_us(0.99999), "us"),
        Check::informational(name("largest"), tally.within_us(1.0), "us"),
        Check::informational(name("turn_largest"), tally.turn_us.max() as f64, "us"),
        Check::exactly(name("allocations"), tally.allocations as f64, "1", 0.0),
    ]
}

/// Markdown: a row a run, then the misses of each, then what the loads did.
#[must_use]
pub fn markdown(outcomes: &[Outcome], command: &str, machine: &str) -> String {
    let mut page = format!(
        "# The deadline, minutes on end\n\n`{command}`\n\non {machine}.\n\nLatencies are in ms, from the instant at which \
         the last payload of a frame was due to the end of its turn. *Late*: after the next frame was due. *Lost*: frames \
         without a turn of their own. *Stolen*: share of the processors' time that a virtual machine's host took.\n\n![Latency against the \
         share of turns](deadline.png)\n\n| run | frames | median | 99 % | 99.9 % | 99.99 % | 99.999 % | largest | \
         late | lost | without field | stolen |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n"
    );
    for outcome in outcomes {
        let tally = &outcome.tally;
        let ms = |share: f64| format!("{:.2}", 1e-3 * tally.within_us(share));
        let stolen = outcome.stolen.map_or("not reported".into(), |share| format!("{:.1} %", 100.0 * share));
        page += &format!(
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {stolen} |\n",
            outcome.run.name(),
            tally.frames,
            ms(0.5),
            ms(0.99),
            ms(0.999),
            ms(0.9999),
            ms(0.99999),
            ms(1.0),
            tally.misses.len(),
            tally.lost,
            tally.shed,
        );
    }
    page += "\nOf fewer than 100,000 turns the 99.999 % quantile is the largest.\n";
    for outcome in outcomes {
        page += &misses(outcome);
        page += &load(outcome);
    }
    page + &format!("\n```text\n{}```\n", table(&checks(outcomes)))
}

/// Returns the section on missed deadlines: their number, stages and lost frames.
fn misses(outcome: &Outcome) -> String {
    let tally = &outcome.tally;
    if tally.misses.is_empty() {
        return String::new();
    }
    let mut longest: Vec<_> = tally.misses.iter().collect();
    longest.sort_by_key(|miss| std::cmp::Reverse(miss.latency_us));
    let stolen = longest.iter().filter(|miss| miss.stolen_ms > 0.0).count();
    let mut text = format!(
        "\n## {}: {} late\n\n{stolen} of them while the host took the processor. The longest:\n\n| at, s | latency, ms | \
         handed over late | waited for the worker | turn | its longest stage | field | frames lost behind it | stolen, \
         ms |\n|---|---|---|---|---|---|---|---|---|\n",
        outcome.run.name(),
        tally.misses.len(),
    );
    for miss in longest.into_iter().take(SHOWN) {
        let ms = |us: u64| format!("{:.2}", 1e-3 * us as f64);
        text += &format!(
            "| {:.1} | {} | {} | {} | {} | {} {} | {} | {} | {:.0} |\n",
            miss.at_s,
            ms(miss.latency_us),
            ms(miss.late_us),
            ms(miss.waited_us),
            ms(miss.ran_us),
            miss.longest.0,
            ms(miss.longest.1),
            if miss.field_fresh { "written" } else { "left out" },
            miss.lost_after,
            miss.stolen_ms,
        );
    }
    text
}

/// Returns the section on the loads' work and the refused real-time rights.
fn load(outcome: &Outcome) -> String {
    let (pressed, name) = (&outcome.pressed, outcome.run.name());
    let mut text = String::new();
    if !outcome.run.loads.is_empty() {
        text += &format!(
            "\n{name}: beside {} threads that compute, {:.1} GB/s read and written in memory, {:.0} MB/s written to \
             the disk and synced.\n",
            pressed.spinning, pressed.copied_gb_s, pressed.written_mb_s
        );
    }
    if let Some(why) = &pressed.failed {
        text += &format!("\n{name}: **the disk's load ended early**: {why}\n");
    }
    for line in &outcome.refused {
        text += &format!("\n{name}: **not granted**: {line}\n");
    }
    text
}
