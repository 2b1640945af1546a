//! `meniscus discover`: name the effect that is missing between simulation and measurement.

mod added;
mod study;

use super::inputs::file;
use anyhow::{Context, anyhow, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::blob::Model;
use meniscus::reduced::effects::{Entry, LIBRARY, find};
use meniscus_discover::calibrate::Group;
use meniscus_discover::fit_cache::Kept;
use meniscus_discover::html::page;
use meniscus_discover::insert::Closed;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::load::{Folder, load};
use meniscus_discover::report::{scene_toml, verdict_json};
use meniscus_discover::settings::Settings;
use meniscus_discover::thresholds::thresholds;
use meniscus_discover::verdict::Decision;
use meniscus_discover::workflow::{Discovery, discover};
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Deviation of a recording's own clock where a setup says that it has one, s.
const OWN_CLOCK_S: f64 = 0.02;

/// Name what is missing between simulation and measurement, with evidence, or say honestly that it is unknown.
///
/// --recordings is a folder with setup.toml and, for each recording, NAME.profile.csv (or NAME.peak.csv) and
/// NAME.motion.csv (or NAME.pose.csv); docs/formats.md describes them. Of four recordings or more one stays
/// sealed and is only used to measure the gap.
///
/// --reference is such a folder of a KNOWN liquid in the same glass and motions, or a folder of such folders,
/// simulated or measured, at two viscosities or more: they say what the plain model is off by anyway.
/// Without them the verdict is much weaker.
///
/// Into --out go report.html, verdict.json and scene.toml (the effect, for `meniscus simulate --scene`). With --model
/// the effect is put into a flashed model too, and with --simulate into the simulator; the report says what of the gap
/// each closes on the sealed recording. Every
/// fit is kept in --out/fits as soon as it is made: the same command on the same recordings goes on where it
/// was interrupted, and one with a recording more makes only what that changes.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus discover --recordings mine --reference known --out found\n  meniscus discover \
                  --recordings mine --reference known --library viscosity,yield_stress --out found --json\n  meniscus \
                  discover study --json"
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
    #[arg(long, value_name = "DIR")]
    recordings: PathBuf,
    /// Folder of recordings of a known liquid, or of such folders.
    #[arg(long, value_name = "DIR")]
    reference: Option<PathBuf>,
    /// Folder for the report; it is made if it is not there.
    #[arg(long, default_value = "out/discovery", value_name = "DIR")]
    out: PathBuf,
    /// The flashed model of this glass and liquid, shipped or a blob: what is named goes into it, as model.blob in --out.
    #[arg(long, value_name = "shipped|FILE")]
    model: Option<String>,
    /// Simulate the sealed recording again, as it was said to be and with what is named: a minute each.
    #[arg(long)]
    simulate: bool,
    /// Spacing of the particles of --simulate, mm.
    #[arg(long, default_value_t = 7.0, value_name = "MM", requires = "simulate")]
    spacing_mm: f64,
    /// Only these effects may be named, separated by commas.
    #[arg(long, value_delimiter = ',', value_name = "NAME")]
    library: Vec<String>,
    /// Seed of the bootstrap.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object on standard output.
    #[arg(long)]
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

/// The effects called `names`, all where there is none.
fn library(names: &[String]) -> anyhow::Result<Vec<&'static Entry>> {
    if names.is_empty() {
        return Ok(LIBRARY.iter().collect());
    }
    let known = || LIBRARY.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ");
    let one = |name: &String| {
        find(name.trim()).ok_or_else(|| anyhow!("no effect is called '{name}': take {}", known()))
    };
    names.iter().map(one).collect()
}

/// The groups of references in `path`.
fn references(path: &Path, settings: &Settings) -> anyhow::Result<Vec<Group>> {
    let mut folders = Vec::new();
    if path.join("setup.toml").exists() {
        folders.push(path.to_owned());
    } else {
        let inside = std::fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()))?;
        folders.extend(
            inside.filter_map(|e| e.ok().map(|e| e.path())).filter(|p| p.join("setup.toml").exists()),
        );
        folders.sort();
    }
    if folders.is_empty() {
        bail!(
            "{}: no setup.toml in it, nor in a folder of it; docs/formats.md says what it holds",
            path.display()
        );
    }
    let mut groups = Vec::new();
    for folder in folders {
        let folder = load(&folder).map_err(|why| anyhow!(why))?;
        folder.left_out.iter().for_each(|why| eprintln!("left out: {why}"));
        let group = Group::keeping(folder.known, folder.records, settings.own_clocks_s, &settings.kept);
        groups.push(group.map_err(|why| anyhow!(why))?);
    }
    Ok(groups)
}

/// Says on Ctrl-C what is kept, and ends.
fn watch(kept: &Arc<Kept>) -> anyhow::Result<()> {
    let kept = kept.clone();
    ctrlc::set_handler(move || {
        let [taken, made, _] = kept.counts();
        eprintln!("\ninterrupted: {} fits are kept; the same command goes on from there", taken + made);
        std::process::exit(130);
    })
    .context("Ctrl-C cannot be watched")
}

/// One discovery.
fn one(arguments: &Wanted) -> anyhow::Result<()> {
    let bar = if arguments.json { ProgressBar::hidden() } else { ProgressBar::new(4) };
    bar.set_style(ProgressStyle::with_template("{msg:40} {wide_bar} {pos}/{len}, {eta} left")?);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar.set_message("reading the recordings");
    let folder = load(&arguments.recordings).map_err(|why| anyhow!(why))?;
    for why in &folder.left_out {
        bar.suspend(|| eprintln!("left out: {why}"));
    }
    let widest_mm = 250.0 * folder.known.radius_m;
    ensure!(
        (1.5..=widest_mm).contains(&arguments.spacing_mm),
        "--spacing-mm {} is out of range: 1.5 to a quarter of the radius, {widest_mm:.2}",
        arguments.spacing_mm
    );
    let kept = Arc::new(Kept::new(&arguments.out.join("fits")));
    watch(&kept)?;
    let mut settings =
        Settings { library: library(&arguments.library)?, seed: arguments.seed, ..Settings::default() };
    settings.own_clocks_s = folder.own_clocks.then_some(OWN_CLOCK_S);
    settings.kept = Some(kept.clone());
    bar.inc(1);
    bar.set_message("fitting the references");
    let groups = match &arguments.reference {
        Some(path) => references(path, &settings)?,
        None => {
            bar.suspend(|| {
                eprintln!("without --reference the model's own error counts as an effect: a weak verdict");
            });
            Vec::new()
        }
    };
    let references: Vec<&Group> = groups.iter().collect();
    bar.inc(1);
    bar.set_message("judging the references by one another");
    let limits = thresholds(&references, &settings).map_err(|why| anyhow!(why))?;
    bar.inc(1);
    bar.set_message("ranking the effects");
    let found = discover(&folder.records, folder.known, &references, &limits, &settings)
        .map_err(|why| anyhow!(why))?;
    bar.finish_and_clear();
    let [taken, made, lost] = kept.counts();
    if lost > 0 {
        eprintln!("{lost} fits could not be kept in {}", arguments.out.join("fits").display());
    }
    let closed = others(arguments, &folder, &found)?;
    let mut json = verdict_json(&found, &closed);
    json["fits"] = serde_json::json!({ "taken": taken, "made": made });
    let write = |name: &str, text: &str| write_whole(&arguments.out.join(name), text.as_bytes());
    write("report.html", &page(&found, &closed, &command(arguments))?)?;
    write("verdict.json", &format!("{json:#}"))?;
    write("scene.toml", &scene_toml(&found, &folder.known))?;
    if arguments.json {
        println!("{json}");
        return Ok(());
    }
    say(&found);
    for c in &closed {
        println!(
            "  {}: {:.3} mm untouched, {:.3} mm with the effect",
            c.model,
            1e3 * c.untouched_m,
            1e3 * c.effect_m
        );
    }
    if taken > 0 {
        println!("fits: {taken} taken from an earlier run, {made} made");
    }
    println!("written: {}", arguments.out.display());
    Ok(())
}

/// The effect in the models that `arguments` ask for; model.blob is written here.
fn others(arguments: &Wanted, folder: &Folder, found: &Discovery) -> anyhow::Result<Vec<Closed>> {
    let mut closed = Vec::new();
    let named = matches!(found.verdict.decision, Decision::Named | Decision::Tied);
    if !named {
        if arguments.model.is_some() || arguments.simulate {
            eprintln!("nothing was named, so nothing was put into another model");
        }
        return Ok(closed);
    }
    let sealed = &found.split.held_out;
    if let Some(path) = &arguments.model {
        let bytes = file(path)?;
        let model = Model::load(&bytes).with_context(|| format!("the model {path} is refused"))?;
        added::same_glass(&model, &folder.known)?;
        match added::flashed(&bytes, &folder.known, found, sealed.as_ref()) {
            Ok((blob, one)) => {
                write_whole(&arguments.out.join("model.blob"), &blob)?;
                closed.extend(one);
            }
            Err(why) => eprintln!("not put into {path}: {why:#}"),
        }
    }
    if let Some(record) = sealed.as_ref().filter(|_| arguments.simulate) {
        let spacing_m = 1e-3 * arguments.spacing_mm;
        let bar = if arguments.json { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        bar.enable_steady_tick(Duration::from_millis(200));
        bar.set_message("simulating the sealed recording twice");
        let resolution = Resolution { spacing_m, seed: arguments.seed };
        match added::simulated(&folder.known, found, record, resolution) {
            Ok(one) => closed.push(one),
            Err(why) => eprintln!("not simulated again: {why:#}"),
        }
        bar.finish_and_clear();
    }
    Ok(closed)
}

/// The command that makes the report again.
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

/// The verdict on standard output.
fn say(found: &Discovery) {
    println!("{}", found.verdict.sentence());
    for e in &found.estimates {
        println!(
            "  {} {}: {:.4} {} (90 %: {:.4} to {:.4})",
            e.effect, e.parameter, e.value, e.unit, e.interval.0, e.interval.1
        );
    }
    if let Some(gap) = found.gap {
        println!(
            "  sealed recording: {:.3} mm untouched, {:.3} mm with nuisances fitted again, {:.3} mm with a black box, {:.3} mm \
             with the effect",
            1e3 * gap.untouched,
            1e3 * gap.refitted,
            1e3 * gap.black_box,
            1e3 * gap.effect
        );
    }
    if let Some(question) = &found.question {
        let [one, two] = &question.between;
        if question.hopeful() {
            println!(
                "  to settle it, record {}: {:.1} times the noise",
                question.motion, question.separation
            );
        } else {
            println!("  no motion that was looked at parts {one} from {two}");
        }
    }
}
