//! The soak: one run as the service has it, for an hour, with every trouble in each period of ten minutes. A shorter run has
//! shorter periods, and fewer where they would be too short.
//!
//! ```text
//! 0      0.1          0.2        0.5        0.7         0.75         0.85        0.9          1 period
//! |------standstill---restart----re-plug----disk full---standstill---disk free---standstill---|
//! ```
//! In a standstill the program is stopped for a tenth of a second and misses its deadlines. The flight recorder writes the seconds around it to the disk. The
//! memory of the process is sampled ten times in each period.

use super::program::{self, PROGRAM};
use super::{facts, soak_book};
use meniscus_hil::device::{At, Back, Cure, Trouble};
use meniscus_hil::vhci::Plugged;
use serde_json::{Map, Value, json};
use std::error::Error;
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{ChildStderr, Command, Stdio};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant, SystemTime};

type Done = Result<Map<String, Value>, Box<dyn Error>>;

/// Most periods of a run, each with every trouble.
const MOST_PERIODS: u32 = 6;
/// Shortest period, s: a restart takes ten of them, and has three tenths of the period.
const SHORTEST_S: f64 = 40.0;
/// Samples of the memory in a period: one a minute of an hour.
const SAMPLES: u32 = 10;
/// Length of a standstill: six frames.
const STANDSTILL: Duration = Duration::from_millis(100);
/// Disk that the run writes to.
const DISK: &str = "/tmp/disk";
/// File that fills it.
const FILLER: &str = "/tmp/disk/filler";

/// Step of a period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// The program is stopped for [`STANDSTILL`].
    Standstill,
    /// The camera sends nothing until it is restarted.
    Restart,
    /// The camera is pulled out and plugged in again two seconds later.
    Replug,
    FillDisk,
    FreeDisk,
    SampleMemory,
}

/// Steps of a period with their times, in periods.
const STEPS: [(f64, Step); 7] = [
    (0.1, Step::Standstill),
    (0.2, Step::Restart),
    (0.5, Step::Replug),
    (0.7, Step::FillDisk),
    (0.75, Step::Standstill),
    (0.85, Step::FreeDisk),
    (0.9, Step::Standstill),
];

/// Returns the number of periods of a run.
fn periods(seconds: f64) -> u32 {
    ((seconds / SHORTEST_S) as u32).clamp(1, MOST_PERIODS)
}

/// Returns the steps of a run with their times, s, in order.
fn plan(seconds: f64) -> Vec<(f64, Step)> {
    let periods = periods(seconds);
    let period_s = seconds / f64::from(periods);
    let troubles = (0..periods)
        .flat_map(|period| STEPS.map(|(part, step)| ((f64::from(period) + part) * period_s, step)));
    // Before the end of each tenth: no sample is taken while something is filled or freed.
    let samples = (0..periods * SAMPLES).map(|sample| {
        let tenth_s = period_s / f64::from(SAMPLES);
        ((f64::from(sample) + 0.97) * tenth_s, Step::SampleMemory)
    });
    let mut steps: Vec<(f64, Step)> = troubles.chain(samples).collect();
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    steps
}

/// Runs the program for `seconds` and lets everything happen to it.
pub(crate) fn run(plugged: &Plugged, seconds: f64) -> Done {
    busybox(&["mkdir", "-p", DISK])?;
    busybox(&["mount", "-t", "tmpfs", "-o", "size=4m", "disk", DISK])?;
    let done = run_on_disk(plugged, seconds);
    busybox(&["umount", DISK])?;
    done
}

fn run_on_disk(plugged: &Plugged, seconds: f64) -> Done {
    let (begun, begun_at) = (Instant::now(), SystemTime::now());
    let out = format!("{DISK}/out");
    let mut command = Command::new(PROGRAM);
    command.args(["run", "--source", "usb", "--service", "--json", "--out", &out]);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let words = child.stderr.take().map(|pipe| listen(pipe, begun)).ok_or("no standard error")?;
    let mut memory_kib = Vec::new();
    for (at_s, step) in plan(seconds) {
        sleep(Duration::from_secs_f64(at_s).saturating_sub(begun.elapsed()));
        match step {
            Step::Standstill => {
                busybox(&["kill", "-STOP", &child.id().to_string()])?;
                sleep(STANDSTILL);
                busybox(&["kill", "-CONT", &child.id().to_string()])?;
            }
            Step::Restart => plugged.impose(Trouble::Quiet(Cure::Restart)),
            Step::Replug => plugged.impose(Trouble::Unplug(At::Stream, Back::Same)),
            Step::FillDisk => fill()?,
            Step::FreeDisk => fs::remove_file(FILLER)?,
            Step::SampleMemory => memory_kib.push(resident_kib(child.id())),
        }
    }
    sleep(Duration::from_secs_f64(seconds).saturating_sub(begun.elapsed()));
    let ended_at = SystemTime::now();
    // As systemd stops a unit.
    busybox(&["kill", &child.id().to_string()])?;
    let ran = program::finish(child)?;
    let words = words.join().map_err(|_| "the program's words were lost")?;
    let since_s = |at: SystemTime| at.duration_since(begun_at).map_or(f64::NAN, |since| since.as_secs_f64());
    let witness = plugged.witness();
    let attached_s: Vec<f64> = witness.attached.iter().map(|at| since_s(*at)).collect();
    let over_s = ran.report["deadlines"]["over_s"].as_f64().unwrap_or(f64::NAN);
    let mut facts = facts::of(&ran);
    facts.insert("said".into(), words.last().map_or(Value::Null, |(_, line)| line.clone().into()));
    facts.insert("words".into(), json!(words));
    facts.insert("periods".into(), periods(seconds).into());
    facts.insert("memory_kib".into(), json!(memory_kib));
    facts.insert("attached_s".into(), json!(attached_s));
    facts.insert("accounts".into(), ran.report["deadlines"].clone());
    facts.insert("book".into(), soak_book::of(&plugged.exposures_us(), over_s, &witness, ended_at));
    Ok(facts)
}

/// Reads what the program says, each line with its time.
fn listen(pipe: ChildStderr, begun: Instant) -> JoinHandle<Vec<(f64, String)>> {
    std::thread::spawn(move || {
        let lines = BufReader::new(pipe).lines().map_while(Result::ok);
        lines.map(|line| (begun.elapsed().as_secs_f64(), line)).collect()
    })
}

/// Fills the disk to its last byte.
fn fill() -> Result<(), Box<dyn Error>> {
    match fs::write(FILLER, vec![0; 8 << 20]) {
        Err(error) if error.kind() == std::io::ErrorKind::StorageFull => Ok(()),
        Err(error) => Err(error.into()),
        Ok(()) => Err("the disk has no end".into()),
    }
}

/// Returns the resident memory of a process, KiB; 0 if it has ended.
fn resident_kib(process: u32) -> u64 {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}

fn busybox(arguments: &[&str]) -> std::io::Result<()> {
    Command::new("/bin/busybox").args(arguments).status().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_period_has_every_trouble_and_an_hour_has_a_sample_a_minute() {
        assert_eq!([80.0, 120.0, 240.0, 3600.0].map(periods), [2, 3, 6, 6]);
        let steps = plan(3600.0);
        assert!(steps.is_sorted_by(|a, b| a.0 <= b.0) && steps.last().is_some_and(|last| last.0 < 3600.0));
        for period in 0..MOST_PERIODS {
            let from_s = 600.0 * f64::from(period);
            let within = |step: &&(f64, Step)| (from_s..from_s + 600.0).contains(&step.0);
            let count = |wanted| steps.iter().filter(within).filter(|(_, step)| *step == wanted).count();
            let counts = [Step::Restart, Step::Replug, Step::FillDisk, Step::FreeDisk].map(count);
            assert_eq!((counts, count(Step::Standstill), count(Step::SampleMemory)), ([1; 4], 3, 10));
        }
        let samples: Vec<f64> =
            steps.iter().filter(|(_, step)| *step == Step::SampleMemory).map(|(at_s, _)| *at_s).collect();
        assert!(samples.windows(2).all(|pair| (pair[1] - pair[0] - 60.0).abs() < 1e-9));
    }
}
