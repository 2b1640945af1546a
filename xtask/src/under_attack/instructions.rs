//! Instructions of a turn, counted by callgrind in the turn's own thread.
//!
//! Callgrind makes the program some ten times slower, so the camera waits for the estimator (`--patient`): each frame has
//! its turn, and a turn is the same work as at 60 Hz. Counting is on from the first payload of a frame to the last sink that
//! takes the turn; callgrind keeps that state for each thread apart. It writes a file a turn.

use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// Functions of the worker whose instructions are those of a turn: its payloads, then its sinks. Whole names: callgrind
/// misses one of two patterns that begin alike.
const COUNTED: [&str; 2] =
    ["meniscus_service::live::turns::Turns::take_payload", "meniscus_service::live::turns::Turns::hand_on"];
/// Name of callgrind's files, in a folder of their own.
const COUNTS: &str = "counts";
/// Turns that the filter's window takes to fill: they are shorter, and no turn is like them.
const FILLING: usize = 16;

/// Returns the command that runs `program` under callgrind and leaves a count of each turn in `folder`.
pub(super) fn counting(program: &Path, folder: &Path) -> Result<Command> {
    let found = Command::new("valgrind").arg("--version").output();
    found.context("valgrind counts the instructions, and it does not start (apt-get install valgrind)")?;
    if folder.exists() {
        std::fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    }
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let [payload, sinks] = COUNTED;
    let mut command = Command::new("valgrind");
    command
        // Threads take turns at valgrind's one lock: without fairness an attacked server would keep the camera waiting.
        .args(["--tool=callgrind", "--fair-sched=try"])
        .arg(format!("--callgrind-out-file={}", folder.join(COUNTS).display()))
        .args([format!("--toggle-collect={payload}"), format!("--toggle-collect={sinks}")])
        .arg(format!("--dump-after={sinks}"))
        // The kernels as tests/instructions.rs counts them. Valgrind counts each byte of `rep movsb` as an instruction; the
        // processor counts one.
        .env("MENISCUS_NARROW", "1")
        .env("GLIBC_TUNABLES", "glibc.cpu.x86_rep_movsb_threshold=1000000000")
        .arg(program);
    Ok(command)
}

/// Returns the median of the turns' counts that a run has left in `folder`.
pub(super) fn median_of_turns(folder: &Path) -> Result<f64> {
    let mut turns = Vec::new();
    // Dumps are numbered from 1; what follows the last turn has the bare name.
    for number in 1_usize.. {
        let path = folder.join(format!("{COUNTS}.{number}"));
        let Ok(text) = std::fs::read_to_string(&path) else { break };
        turns.push(total(&text).with_context(|| format!("{} has no total", path.display()))?);
    }
    ensure!(
        turns.len() > 2 * FILLING,
        "callgrind counted {} turns: the program has to be built with its symbols, and to have run longer",
        turns.len()
    );
    let mut tracked = turns.split_off(FILLING);
    tracked.sort_by(f64::total_cmp);
    Ok(0.5 * (tracked[tracked.len() / 2] + tracked[(tracked.len() - 1) / 2]))
}

/// Returns the instructions of a dump.
fn total(dump: &str) -> Option<f64> {
    dump.lines().find_map(|line| line.strip_prefix("totals: "))?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_over_the_turns_behind_the_filling_ones() {
        let folder = std::env::temp_dir().join(format!("meniscus-counts-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let write = |numbers: std::ops::Range<usize>, count: usize| {
            for number in numbers {
                let text = format!("events: Ir\nfn=(1) x\n1 2\n\ntotals: {}\n", count + number % 2);
                std::fs::write(folder.join(format!("{COUNTS}.{number}")), text).expect("written");
            }
        };
        write(1..17, 5);
        assert!(median_of_turns(&folder).is_err(), "the window was not full yet");
        write(17..57, 1000);
        std::fs::write(folder.join(COUNTS), "totals: 7\n").expect("written");
        assert_eq!(median_of_turns(&folder).expect("a median"), 1000.5);
        std::fs::write(folder.join(format!("{COUNTS}.9")), "events: Ir\n").expect("written");
        assert!(median_of_turns(&folder).is_err(), "a dump that was cut");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
