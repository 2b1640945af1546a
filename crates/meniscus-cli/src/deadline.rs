//! `meniscus deadline`: minutes of turns at a camera's pace, idle and beside a load.

use super::inputs::file;
use super::stop::watched;
use anyhow::{Context, ensure};
use indicatif::ProgressBar;
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_platform::files::write_whole;
use meniscus_platform::realtime::Priority;
use meniscus_report::checks::table;
use meniscus_timing::deadline::{
    Bench, Film, Load, Outcome, Run, checks, latencies_png, markdown, run as perform,
};
use meniscus_virtual::render::SceneSettings;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Rates that can be requested, frames a second.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1.0..=2000.0;

/// Longest run, minutes.
const LONGEST_MIN: f64 = 240.0;

/// Count late turns over minutes, idle and under load.
///
/// The worker of `meniscus run` gets a frame at every interval of a clock, from images that were rendered before (0.7 GB of
/// memory). A turn's time counts from when the frame's last payload was due, so it includes the wait for a processor. A turn is
/// late when the next frame was due before it ended.
///
/// A rate above 60 Hz plays the same 60 Hz film faster: the model's step stays 1/60 s, and the deadline becomes the interval.
///
/// With --realtime worker and camera ask for SCHED_FIFO, the worker for a core of its own, and memory is locked; refusals are
/// reported. The --out folder gets deadline.md and deadline.png.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus deadline --realtime\n  meniscus deadline --rates 60:1 --load none\n  meniscus deadline --rates 60:10,90:1,300:1,1000:1 --realtime --json"
)]
pub(crate) struct Arguments {
    /// The model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Method")]
    model: String,
    /// Frame rates, Hz, 1 to 2000, each with its minutes (10 if not given).
    #[arg(long, default_value = "60:10", value_name = "RATE[:MINUTES],...", help_heading = "Method")]
    rates: String,
    /// Other work of the machine, one run for each: none, or cpu, memory, disk joined by +.
    #[arg(
        long,
        default_value = "none,cpu+memory+disk",
        value_name = "none|KINDS,...",
        help_heading = "Method"
    )]
    load: String,
    /// Ask for real-time rights.
    #[arg(long, help_heading = "Method")]
    realtime: bool,
    /// Folder for the report, and for the file that the disk's load writes.
    #[arg(long, default_value = "deadline", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let runs = runs(arguments)?;
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let recording = Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?;
    let header = &model.header;
    let settings = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let page = arguments.out.join("deadline.md");
    write_whole(&page, b"The study has not ended.\n").context("the --out folder cannot be used")?;
    let stop = watched()?;
    let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(1000) };
    bar.set_style(crate::bars::style("{msg:40} {wide_bar} {percent} %, {left}")?);
    bar.enable_steady_tick(Duration::from_millis(500));
    bar.set_message("rendering the frames");
    let scene = SceneSettings { camera: settings, ..SceneSettings::default() };
    let film = Film::render(&recording, scene, stop, |done| bar.set_position((1000.0 * done) as u64));
    let film = film.context("stopped before the first run: nothing was measured")?;
    let mut outcomes: Vec<Outcome> = Vec::new();
    for run in &runs {
        bar.reset();
        bar.set_message(run.name());
        let progress = |done| bar.set_position((1000.0 * done) as u64);
        let bench =
            Bench { model: &model, config: Config::new(settings)?, film: &film, folder: &arguments.out };
        let outcome = perform(run, &bench, stop, progress);
        outcome.refused.iter().for_each(|line| bar.suspend(|| eprintln!("real time: {line}")));
        outcomes.push(outcome);
        // After each run: what was measured is not lost to what comes later.
        write_whole(&page, markdown(&outcomes, &command(arguments), &machine()).as_bytes())?;
        latencies_png(&outcomes, &arguments.out.join("deadline.png"))?;
        if stop.load(Ordering::Relaxed) {
            eprintln!("stopped: the last run is shorter than requested, and the rest is missing");
            break;
        }
    }
    bar.finish_and_clear();
    if arguments.json {
        let report = json!({
            "command": "meniscus deadline",
            "version": env!("CARGO_PKG_VERSION"),
            "machine": machine(),
            "runs": outcomes.iter().map(outcome_json).collect::<Vec<Value>>(),
            "checks": checks(&outcomes),
        });
        println!("{report:#}");
    } else {
        print!("{}", table(&checks(&outcomes)));
        println!("report: {}", page.display());
    }
    Ok(())
}

/// A run for scripts.
fn outcome_json(outcome: &Outcome) -> Value {
    let tally = &outcome.tally;
    let shares = [0.5, 0.9, 0.99, 0.999, 0.9999, 0.99999, 1.0];
    json!({
        "name": outcome.run.name(),
        "rate_hz": outcome.run.rate_hz,
        "frames": tally.frames,
        "late": tally.misses.len(),
        "lost": tally.lost,
        "field_left_out": tally.shed,
        "stolen": outcome.stolen,
        "latency_us": shares.map(|share| [share, tally.within_us(share)]),
        "refused": outcome.refused,
    })
}

/// The requested runs: every rate with every load.
fn runs(arguments: &Arguments) -> anyhow::Result<Vec<Run>> {
    let mut loads = Vec::new();
    for list in arguments.load.split(',') {
        let known = || Load::ALL.map(Load::name).join(", ");
        let named = |name: &str| {
            let load = Load::ALL.into_iter().find(|load| load.name() == name.trim());
            load.with_context(|| format!("--load knows no '{name}': none, or {} joined by +", known()))
        };
        let list = if list.trim() == "none" { Ok(Vec::new()) } else { list.split('+').map(named).collect() };
        loads.push(list?);
    }
    let mut runs = Vec::new();
    for entry in arguments.rates.split(',') {
        let (rate, minutes) = entry.split_once(':').unwrap_or((entry, "10"));
        let number = |text: &str, what: &str| {
            let number = text.trim().parse::<f64>();
            number.with_context(|| format!("--rates {entry}: '{text}' is no number of {what}"))
        };
        let (rate_hz, minutes) = (number(rate, "frames a second")?, number(minutes, "minutes")?);
        let (least, most) = RATES_HZ.into_inner();
        ensure!(
            RATES_HZ.contains(&rate_hz),
            "--rates {entry}: {rate_hz} Hz is out of range: {least} to {most}"
        );
        ensure!(
            (0.05..=LONGEST_MIN).contains(&minutes),
            "--rates {entry}: {minutes} minutes are out of range: 0.05 to {LONGEST_MIN}"
        );
        let run = |loads: &Vec<Load>| Run {
            rate_hz,
            seconds: 60.0 * minutes,
            loads: loads.clone(),
            priority: Priority::real_time_if(arguments.realtime),
        };
        runs.extend(loads.iter().map(run));
    }
    Ok(runs)
}

/// The command, as the page tells it.
fn command(arguments: &Arguments) -> String {
    let realtime = if arguments.realtime { " --realtime" } else { "" };
    format!("meniscus deadline --rates {} --load {}{realtime}", arguments.rates, arguments.load)
}

/// Processors and their name, as the kernel tells.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let line = text.lines().find(|line| line.starts_with("model name") || line.starts_with("Model"));
    let name = line.and_then(|line| line.split_once(':')).map_or("unknown", |(_, name)| name.trim());
    format!("{cores} processors, {name}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arguments(rates: &str, load: &str) -> Arguments {
        let (rates, load) = (rates.into(), load.into());
        Arguments { model: "shipped".into(), rates, load, realtime: false, out: "x".into(), json: false }
    }

    #[test]
    fn every_rate_is_run_beside_every_load() {
        let runs = runs(&arguments("60:10,300:0.5", "none,cpu+disk")).expect("sound");
        let names: Vec<String> = runs.iter().map(Run::name).collect();
        assert_eq!(names.len(), 4);
        assert_eq!(names[0], "60 Hz, idle, no real-time rights");
        assert_eq!((runs[3].deadline_us(), runs[3].seconds), (3333, 30.0));
        assert_eq!(runs[3].loads, [Load::Cpu, Load::Disk]);
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_value() {
        for (rates, load, word) in [
            ("0:1", "none", "0 Hz"),
            ("60:x", "none", "'x'"),
            ("60:0", "none", "0 minutes"),
            ("60", "gpu", "'gpu'"),
        ] {
            let error = runs(&arguments(rates, load)).expect_err("refused").to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
