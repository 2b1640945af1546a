//! `meniscus discover`: name the effect that is missing between simulation and measurement.

mod study;

use super::inputs::file;
use super::outputs::check_folder;
use super::stop::{finish, watched_until};
use anyhow::{Context, bail};
use indicatif::ProgressBar;
use meniscus::blob::Model;
use meniscus_data::validity::Validity;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::fitting::fit_cache::FitCache;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::recordings::load::{load, load_references};
use meniscus_discover::report::html::page;
use meniscus_discover::report::scene::scene_toml;
use meniscus_discover::report::verdict_json::verdict_json;
use meniscus_discover::workflow::clocks::AlignedClock;
use meniscus_discover::workflow::inputs::{Inputs, library};
use meniscus_discover::workflow::insertion::FLASHED;
use meniscus_discover::workflow::progress::{Progress, Stage};
use meniscus_discover::workflow::{Discovery, Report};
use meniscus_platform::files::{AlignedBytes, write_whole};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Identify the effect that a simulation lacks, from measurements.
///
/// The verdict is an effect with its size and evidence, several ambiguous ones, none, or unknown. The motion must be measured
/// apart from the camera, by a robot or an IMU. Sizes of effects at the wall can be off by a factor of two (docs/limits.md).
///
/// --recordings is a folder with setup.toml and, for each recording, NAME.profile.csv (or NAME.peak.csv) and NAME.motion.csv (or
/// NAME.pose.csv), described in docs/formats.md. Of four recordings or more one is held out to measure the gap.
///
/// --reference is such a folder of a KNOWN liquid in the same glass and motions, or a folder of such folders, simulated or
/// measured, at two viscosities or more. They show the error of the plain model. Without them the verdict is much weaker.
///
/// The --out folder gets report.html, verdict.json and scene.toml (the effect, for `meniscus simulate --scene`). Every fit is kept
/// in --out/fits: after Ctrl-C the same command continues, and a further recording needs only the fits that it changes.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus discover --recordings mine --reference known --out found\n  meniscus discover --recordings mine --reference known \\\n    --library viscosity,yield_stress --out found --json\n  meniscus discover study --json"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    wanted: Option<Wanted>,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(study::Arguments),
}

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args)]
struct Wanted {
    /// Folder of the recordings.
    #[arg(long, value_name = "DIR", help_heading = "Recordings")]
    recordings: PathBuf,
    /// Folder of recordings of a known liquid, or of such folders.
    #[arg(long, value_name = "DIR", help_heading = "Recordings")]
    reference: Option<PathBuf>,
    /// Effects that may be identified, joined by commas [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NAME", help_heading = "Method")]
    library: Vec<String>,
    /// Seed of the bootstrap.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Also insert the effects into a flashed model of this glass and liquid.
    ///
    /// The model with the effects is written as model.blob in --out.
    #[arg(long, value_name = "shipped|FILE", help_heading = "Insertion")]
    model: Option<String>,
    /// Also simulate the held-out recording without and with the effects, a minute each.
    #[arg(long, help_heading = "Insertion")]
    simulate: bool,
    /// Spacing of the particles of --simulate, mm.
    #[arg(long, default_value_t = 7.0, value_name = "MM", requires = "simulate", help_heading = "Insertion")]
    spacing_mm: f64,
    /// Folder for the report; it is made.
    #[arg(long, default_value = "out/discovery", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match (&arguments.verb, &arguments.wanted) {
        (Some(Verb::Study(arguments)), _) => study::run(arguments),
        (None, Some(wanted)) => one(wanted),
        (None, None) => bail!("give a folder with --recordings, or the verb 'study'"),
    }
}

/// Bar that shows the stages of a discovery.
struct Bar(ProgressBar);

impl Bar {
    /// Returns a bar that is hidden for `--json`.
    fn new(arguments: &Wanted) -> anyhow::Result<Self> {
        let steps = 4 + u64::from(arguments.model.is_some()) + u64::from(arguments.simulate);
        let bar = if arguments.json { ProgressBar::hidden() } else { crate::bars::bar(steps) };
        bar.set_style(crate::bars::style("{msg:40} {wide_bar} {pos}/{len}, {left}")?);
        bar.enable_steady_tick(Duration::from_millis(200));
        bar.set_message("reading the recordings");
        Ok(Self(bar))
    }

    /// Prints `text` to standard error above the bar.
    fn print(&self, text: &str) {
        self.0.suspend(|| eprintln!("{text}"));
    }
}

impl Progress for Bar {
    fn begins(&self, stage: Stage) {
        self.0.inc(1);
        self.0.set_message(match stage {
            Stage::FitReferences => "fitting the references",
            Stage::SetThresholds => "judging the references by one another",
            Stage::Decide => "ranking the effects",
            Stage::InsertIntoModel => "inserting the effects into the model",
            Stage::Simulate => "simulating the held-out recording twice",
        });
    }
}

/// Reads what the flags name.
fn inputs(arguments: &Wanted, cache: &Arc<FitCache>, bar: &Bar) -> anyhow::Result<Inputs> {
    let mut inputs = Inputs::new(load(&arguments.recordings)?);
    inputs.settings = Settings {
        library: library(&arguments.library)?,
        seed: arguments.seed,
        cache: Some(cache.clone()),
        ..Settings::default()
    };
    if arguments.simulate {
        inputs.simulation = Some(Resolution { spacing_m: 1e-3 * arguments.spacing_mm, seed: arguments.seed });
        inputs.check()?;
    }
    match &arguments.reference {
        Some(path) => inputs.references = load_references(path)?,
        None => {
            bar.print("without --reference the model's own error counts as an effect: a weak verdict");
        }
    }
    let left_out = inputs.references.iter().flat_map(|set| &set.left_out);
    for reason in inputs.recordings.left_out.iter().chain(left_out) {
        bar.print(&format!("left out: {reason}"));
    }
    if let Some(model) = &arguments.model {
        inputs.model = Some(file(model)?);
    }
    Ok(inputs)
}

/// Runs one discovery.
fn one(arguments: &Wanted) -> anyhow::Result<()> {
    let bar = Bar::new(arguments)?;
    let cache = Arc::new(FitCache::new(&arguments.out.join("fits")));
    let inputs = inputs(arguments, &cache, &bar)?;
    check_folder(&arguments.out)?;
    if arguments.out.join("verdict.json").exists() {
        eprintln!("the verdict of an earlier run in {} is going to be replaced", arguments.out.display());
    }
    // The fits say how far they are; nothing looks at the flag.
    let _flag = watched_until(format!(
        "no verdict is written; the fits are kept in {}, and the same command continues from them",
        cache.folder().display()
    ))?;
    let report = Discovery::run(&inputs, &bar)?;
    bar.0.finish_and_clear();
    finish();
    warn(arguments, &report, &cache);
    let json = verdict_json(&report);
    let write = |name: &str, bytes: &[u8]| write_whole(&arguments.out.join(name), bytes);
    if let Some(blob) = &report.insertion.blob {
        write("model.blob", blob)?;
        let aligned = AlignedBytes::copy(blob);
        let model = Model::load(&aligned).context("the model with the effects does not load")?;
        Validity::of(&model.header).sentence.iter().for_each(|sentence| eprintln!("model.blob: {sentence}"));
    }
    write("report.html", page(&report, &command(arguments))?.as_bytes())?;
    write("verdict.json", format!("{json:#}").as_bytes())?;
    write("scene.toml", scene_toml(&report.findings).as_bytes())?;
    if arguments.json {
        println!("{json}");
        return Ok(());
    }
    print(&report);
    println!("written: {}", arguments.out.display());
    Ok(())
}

/// Prints to standard error what could not be done.
fn warn(arguments: &Wanted, report: &Report, cache: &FitCache) {
    for refusal in report.clocks.iter().filter_map(AlignedClock::refusal) {
        eprintln!("left out: {refusal}");
    }
    if report.fits.unwritten > 0 {
        eprintln!("{} fits could not be kept in {}", report.fits.unwritten, cache.folder().display());
    }
    if report.insertion.nothing_to_insert {
        eprintln!("no effect was identified, so nothing was inserted into another model");
    }
    for skipped in &report.insertion.skipped {
        let file = arguments.model.as_deref().filter(|_| skipped.model == FLASHED);
        let file = file.map_or(String::new(), |file| format!(" ({file})"));
        eprintln!("not inserted into {}{file}: {}", skipped.model, skipped.reason);
    }
}

/// Returns the command that makes the report again.
fn command(arguments: &Wanted) -> String {
    let mut out = format!("meniscus discover --recordings {}", arguments.recordings.display());
    if let Some(reference) = &arguments.reference {
        out += &format!(" --reference {}", reference.display());
    }
    if let Some(model) = &arguments.model {
        out += &format!(" --model {model}");
    }
    if arguments.simulate {
        out += &format!(" --simulate --spacing-mm {}", arguments.spacing_mm);
    }
    if !arguments.library.is_empty() {
        out += &format!(" --library {}", arguments.library.join(","));
    }
    out + &format!(" --seed {} --out {}", arguments.seed, arguments.out.display())
}

/// Prints the report to standard output.
fn print(report: &Report) {
    let findings = &report.findings;
    println!("{}", findings.assessment.verdict.sentence());
    for e in &findings.estimates {
        println!(
            "  {} {}: {:.4} {} (90 %: {:.4} to {:.4})",
            e.effect, e.parameter, e.value, e.unit, e.interval.0, e.interval.1
        );
    }
    if let Some(gap) = findings.gap.as_ref().map(|measured| measured.gap) {
        println!(
            "  held-out recording: {:.3} mm untouched, {:.3} mm with nuisances fitted again, {:.3} mm with a black box, \
             {:.3} mm with the effect",
            1e3 * gap.untouched,
            1e3 * gap.refitted,
            1e3 * gap.black_box,
            1e3 * gap.effect
        );
    }
    if let Some(suggestion) = &findings.suggestion {
        let [one, two] = &suggestion.between;
        if suggestion.hopeful() {
            println!(
                "  to decide, record {}: it separates them by {:.1} times the noise",
                suggestion.motion, suggestion.separation
            );
        } else {
            println!("  no motion that was considered separates {one} from {two}");
        }
    }
    for closed in &report.insertion.closed {
        println!(
            "  {}: {:.3} mm untouched, {:.3} mm with the effect",
            closed.model,
            1e3 * closed.untouched_m,
            1e3 * closed.effect_m
        );
    }
    if report.fits.reused > 0 {
        println!("fits: {} taken from an earlier run, {} made", report.fits.reused, report.fits.computed);
    }
}
