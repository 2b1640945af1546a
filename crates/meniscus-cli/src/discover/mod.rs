//! `meniscus discover`: name the effect that is missing between simulation and measurement.

mod bar;
mod said;
mod study;

use self::bar::Bar;
use self::said::{command, print, warn};
use super::inputs::file;
use super::outputs::check_folder;
use super::stop::{finish, watched_until};
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus_data::validity::Validity;
use meniscus_discover::decision::settings::Settings;
use meniscus_discover::fitting::fit_cache::FitCache;
use meniscus_discover::foreign::command::CommandSimulator;
use meniscus_discover::insert::simulated::Resolution;
use meniscus_discover::recordings::load::{load, load_references};
use meniscus_discover::references::ReferenceSettings;
use meniscus_discover::report::html::page;
use meniscus_discover::report::scene::scene_toml;
use meniscus_discover::report::verdict_json::verdict_json;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::simulations::Shard;
use meniscus_discover::sizing::stage::SizingSettings;
use meniscus_discover::sizing::store::SimulationStore;
use meniscus_discover::workflow::Discovery;
use meniscus_discover::workflow::error::DiscoverError;
use meniscus_discover::workflow::inputs::{Inputs, library};
use meniscus_platform::files::{AlignedBytes, write_whole};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Identify the effect that a simulation lacks, from measurements.
///
/// The verdict is an effect with its size and evidence, several ambiguous ones, none, or unknown. The motion must be measured
/// apart from the camera, by a robot or an IMU.
///
/// The reduced model names the effect in seconds. The simulator then finds its size and compares it with its rivals, which takes
/// minutes; --quick leaves that out, and sizes at the wall may then be off by a factor of two (docs/limits.md). A name is taken back
/// where the simulator needs a size at the end of its range, needs another viscosity beside it, or is no better with the effect than
/// without; the verdict is then unknown.
///
/// Where the verdict is unknown, a law without a name is drawn: the missing force on the first mode by its height, and the missing
/// drag by its rate, each with a 90 % band. The report says which formula of the library comes nearest, where the law departs from
/// it, how much of the gap it closes, and which recording would help. It acts in the reduced model, not in a flashed one.
///
/// --recordings is a folder with setup.toml and, for each recording, NAME.profile.csv (or NAME.peak.csv) and NAME.motion.csv (or
/// NAME.pose.csv), described in docs/formats.md. Of four recordings or more one is held out to measure the gap.
///
/// --reference is such a folder of a KNOWN liquid in the same glass and motions, or a folder of such folders, simulated or
/// measured, at two viscosities or more. They show the error of the plain model. Without --reference the simulator makes six: the
/// stated liquid and one a fifth more viscous in your glass and motions, in several packings, at two spacings. The verdict is then
/// said against the simulator. --no-references and --quick leave them out; the verdict is then weak.
///
/// --simulator names a program of your own that simulates the glass in place of the particle simulator: it makes the references and
/// finds the sizes. It is called with two file names behind its own arguments, reads the scene (JSON: glass, liquid, effects with their
/// sizes, tables of motion) from the first and writes heights to the second. docs/simulators.md has the protocol, examples/one_mode.py is
/// such a program in a few lines.
///
/// The --out folder gets report.html, verdict.json and scene.toml (the effect, for `meniscus simulate --scene`). Every fit is kept
/// in --out/fits and every simulation in --out/simulations: after Ctrl-C the same command continues, and a further recording needs
/// only what it changes. Remove these folders to free their room: a simulation is 5 kB for each second. With --shard several machines that share --out make the simulations of a round together.
#[derive(clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus discover --recordings mine --reference known --out found\n  meniscus discover --recordings mine --reference known \\\n    --library viscosity,yield_stress --out found --json\n  meniscus discover --recordings mine --simulator \"python3 my_model.py\" \\\n    --library viscosity,yield_stress --out found\n  meniscus discover study --json"
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
    /// Make no references by simulation where --reference is not given.
    #[arg(long, conflicts_with = "reference", help_heading = "Recordings")]
    no_references: bool,
    /// Effects that may be identified, joined by commas [default: all].
    #[arg(long, value_delimiter = ',', value_name = "NAME", help_heading = "Method")]
    library: Vec<String>,
    /// Seed of the bootstrap and of the packings.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Leave the sizes by simulation out.
    #[arg(long, conflicts_with_all = ["rivals", "packings", "shard"], help_heading = "Sizes by simulation")]
    quick: bool,
    /// Command that simulates the glass in place of the particle simulator.
    ///
    /// It is run as CMD REQUEST.json ANSWER.json, several at once.
    #[arg(long, value_name = "CMD", conflicts_with = "quick", help_heading = "Sizes by simulation")]
    simulator: Option<String>,
    /// Longest time of one call of --simulator, s.
    #[arg(long, default_value_t = 600.0, value_name = "SECONDS", requires = "simulator", value_parser = seconds, help_heading = "Sizes by simulation")]
    simulator_seconds: f64,
    /// Spacing of the particles at the end, mm; the search begins at 7 mm.
    ///
    /// 7 alone takes a fifth of the time and leaves out the spacing's error.
    #[arg(long, default_value_t = 5.0, value_name = "MM", help_heading = "Sizes by simulation")]
    spacing_mm: f64,
    /// Rivals that are sized and compared, too.
    #[arg(long, default_value_t = 1, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(0..=4), help_heading = "Sizes by simulation")]
    rivals: u8,
    /// Packings of the particles whose scatter goes into the interval.
    #[arg(long, default_value_t = 2, value_name = "COUNT", value_parser = clap::value_parser!(u8).range(1..=9), help_heading = "Sizes by simulation")]
    packings: u8,
    /// Make one part of the simulations of a round and end, as 2/8.
    ///
    /// The machines share --out. When all parts are done, the same command begins the next round; a few rounds lead to the
    /// verdict, which the command without --shard writes.
    #[arg(long, value_name = "INDEX/COUNT", value_parser = Shard::parse, help_heading = "Sizes by simulation")]
    shard: Option<Shard>,
    /// Also insert the effects into a flashed model of this glass and liquid.
    ///
    /// The model with the effects is written as model.blob in --out.
    #[arg(long, value_name = "shipped|FILE", help_heading = "Insertion")]
    model: Option<String>,
    /// Also simulate the held-out recording; sizes by simulation include it.
    #[arg(long, help_heading = "Insertion")]
    simulate: bool,
    /// Folder for the report; it is made.
    #[arg(long, default_value = "out/discovery", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Reads the longest time of a call, s.
fn seconds(text: &str) -> Result<f64, String> {
    let (least, largest) = LIMITS_S;
    let seconds = text.parse::<f64>().ok().filter(|seconds| (least..=largest).contains(seconds));
    seconds.ok_or_else(|| format!("'{text}' is no time from {least} to {largest} s"))
}

/// Least and largest limit of a call of a simulator, s.
const LIMITS_S: (f64, f64) = (0.1, 604_800.0);

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match (&arguments.verb, &arguments.wanted) {
        (Some(Verb::Study(arguments)), _) => study::run(arguments),
        (None, Some(wanted)) => one(wanted),
        (None, None) => bail!("give a folder with --recordings, or the verb 'study'"),
    }
}

/// Returns the stages of a discovery with these flags.
fn stages(arguments: &Wanted) -> u64 {
    let sizes = u64::from(!arguments.quick);
    5 + sizes
        + u64::from(arguments.reference.is_none() && !arguments.quick && !arguments.no_references)
        + u64::from(arguments.model.is_some())
        + u64::from(arguments.simulate && arguments.quick)
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
    if let Some(text) = &arguments.simulator {
        let limit = Duration::from_secs_f64(arguments.simulator_seconds);
        inputs.simulator = Box::new(CommandSimulator::new(text, limit)?);
    }
    let spacing_m = 1e-3 * arguments.spacing_mm;
    if arguments.simulate {
        inputs.simulation = Some(Resolution { spacing_m, seed: FIRST_PACKING + arguments.seed });
    }
    if !arguments.quick {
        inputs.sizing = Some(SizingSettings {
            spacing_m,
            seed: FIRST_PACKING + arguments.seed,
            packings: arguments.packings.into(),
            rivals: arguments.rivals.into(),
            store: arguments.out.join("simulations"),
            shard: arguments.shard,
        });
    }
    inputs.check()?;
    match &arguments.reference {
        Some(path) => inputs.references = load_references(path)?,
        None if !arguments.quick && !arguments.no_references => {
            inputs.simulated_references = Some(ReferenceSettings::new(
                inputs.recordings.known.radius_m,
                arguments.seed,
                arguments.out.join("simulations"),
            ));
        }
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

/// First packing less the seed: other packings than those that `simulate` makes by itself, whose difference from a recording
/// of the same spacing would be nothing at the true size.
const FIRST_PACKING: u64 = 100;

/// Runs one discovery.
fn one(arguments: &Wanted) -> anyhow::Result<()> {
    let bar = Bar::new(stages(arguments), arguments.json)?;
    let cache = Arc::new(FitCache::new(&arguments.out.join("fits")));
    let mut inputs = inputs(arguments, &cache, &bar)?;
    check_folder(&arguments.out)?;
    if arguments.out.join("verdict.json").exists() {
        eprintln!("the verdict of an earlier run in {} is going to be replaced", arguments.out.display());
    }
    if !arguments.quick {
        let store = SimulationStore::new(&arguments.out.join("simulations"));
        store.others().iter().for_each(|said| bar.print(said));
    }
    inputs.stop = Some(watched_until(format!(
        "no verdict is written; fits and simulations are kept in {}, and the same command continues from them",
        arguments.out.display()
    ))?);
    let report = match Discovery::run(&inputs, &bar) {
        // The part of this machine is done, so the job has not failed.
        Err(DiscoverError::Sizing(pending @ SizingError::Pending { .. })) => {
            bar.end();
            println!("{pending}");
            return Ok(());
        }
        outcome => outcome?,
    };
    bar.end();
    finish();
    if arguments.shard.is_some() {
        println!("all simulations are there: the same command without --shard writes the verdict");
        return Ok(());
    }
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
    write("scene.toml", scene_toml(&report).as_bytes())?;
    if arguments.json {
        println!("{json}");
        return Ok(());
    }
    print(&report);
    println!("written: {}", arguments.out.display());
    Ok(())
}
