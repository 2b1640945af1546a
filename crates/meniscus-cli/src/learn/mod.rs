//! `meniscus learn`: from a liquid, or from recordings of one, to a model that knows its inside.

mod bars;
mod inputs;

use super::inputs::file;
use super::stop::{finish, watched_until};
use crate::outputs::note_folders;
use anyhow::{Context, bail, ensure};
use bars::Bars;
use clap::ValueEnum;
use inputs::{Inputs, read};
use meniscus_learn::Hyperparameters;
use meniscus_platform::files::check_writable;
use meniscus_relearn::identify::Law;
use meniscus_relearn::{Folder, Outcome, Plan, Progress, Run, SetSizes, Shard, Silent, Stage, Workers};
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Learn a new liquid: identify, simulate, train, correct, judge.
///
/// The model knows velocity, stress and heat of the liquid, not only its surface, because it is trained on simulations of that
/// liquid in your glass. `meniscus correct` is quicker, and teaches the surface alone.
///
/// Stages: identify fits viscosity, flow index and yield stress to the recordings and writes them as a liquid file. simulate makes
/// recordings of that liquid. train makes a model of them. correct adapts it to the recordings, if there are any. report judges it
/// on simulated recordings that no stage saw. With a liquid and no recordings, identify takes the liquid as it is stated.
///
/// All files lie in the folder --out. --until STAGE ends there; look at the files, edit liquid.toml if you know better, and run
/// again without it. Ctrl-C loses one recording or some seconds of training; the same command continues.
///
/// Each stage says at its start how long it is expected to take. On a cluster, run --shard 1/8 to
/// 8/8 as one job each, then the command without --shard.
///
/// Recordings are files of the simulator, or folders as `meniscus discover` takes them: setup.toml, NAME.profile.csv and
/// NAME.motion.csv. The viscosity is fitted by simulating the recorded motions, which takes some minutes; --rough fits the reduced
/// model alone. Of a low-viscosity liquid only an upper bound is found: name the liquid beside its recordings, or edit
/// liquid.toml. Damping at a contact line or by a film is taken for viscosity.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus learn water --out water\n  meniscus learn butter --quick --out butter\n  meniscus learn my-recordings --density 998 --out mine\n  meniscus learn my-recordings --density 998 --until identify --out mine"
)]
pub(crate) struct Arguments {
    /// A liquid by name or file, recordings of one, or both.
    #[arg(required = true, value_name = "LIQUID_OR_RECORDINGS")]
    inputs: Vec<String>,
    /// Density of the liquid in the recordings, kg/m3 [default: that of the liquid or the recordings].
    #[arg(long, value_name = "KG_M3", help_heading = "Liquid")]
    density: Option<f64>,
    /// Law of flow to fit to the recordings, which do not choose it.
    #[arg(long, value_enum, default_value_t = LawName::Newtonian, help_heading = "Liquid")]
    law: LawName,
    /// Scene file with the glass [default: that of the recordings, or 35 mm radius, 70 mm fill].
    #[arg(long, value_name = "FILE", help_heading = "Glass")]
    scene: Option<PathBuf>,
    /// A short run: five recordings of 3 s and a short training.
    #[arg(long, help_heading = "Method")]
    quick: bool,
    /// Recordings to train on, 1 to 500 [default: 16, or 3].
    #[arg(long, value_name = "N", help_heading = "Method")]
    training: Option<usize>,
    /// Recordings that choices are made by, 1 to 500 [default: 4, or 1].
    #[arg(long, value_name = "N", help_heading = "Method")]
    validation: Option<usize>,
    /// Recordings that judge the model and nothing else, 1 to 500 [default: 4, or 1].
    #[arg(long, value_name = "N", help_heading = "Method")]
    held_out: Option<usize>,
    /// Length of each recording, s, 1.5 to 60 [default: 4, or 3].
    #[arg(long, help_heading = "Method")]
    seconds: Option<f64>,
    /// Spacing of the particles, mm. Half of it takes about 16 times as long.
    #[arg(long, default_value_t = 5.0, value_name = "MM", help_heading = "Method")]
    spacing_mm: f64,
    /// Identify the liquid by the reduced model alone, in seconds.
    ///
    /// It finds 0.6 to 0.75 of glycerine's viscosity, and ten times water's. Without it the simulator is fitted.
    #[arg(long, help_heading = "Method")]
    rough: bool,
    /// Scale of the motions, 0.01 to 1.2 [default: as strong as the liquid stays in the glass].
    ///
    /// With recordings, not much stronger than they are.
    #[arg(long, value_name = "SCALE", help_heading = "Method")]
    strength: Option<f64>,
    /// Model whose encoder the training starts from; scratch starts from random weights.
    #[arg(long, default_value = "shipped", value_name = "shipped|scratch|FILE", help_heading = "Method")]
    from: String,
    /// Hyperparameters of the training as JSON, in the form of `meniscus train --json`.
    #[arg(long, value_name = "FILE", help_heading = "Method")]
    hyperparameters: Option<PathBuf>,
    /// Seed of the training.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// True liquid: learn it too, and judge both models on it.
    #[arg(long, value_name = "LIQUID", help_heading = "Method")]
    oracle: Option<String>,
    /// Last stage to run.
    #[arg(long, value_enum, default_value_t = StageName::Report, value_name = "STAGE", help_heading = "Method")]
    until: StageName,
    /// Simulate part I of N of the recordings, and end.
    #[arg(long, value_name = "I/N", value_parser = shard, help_heading = "Method")]
    shard: Option<Shard>,
    /// Processors for the simulations; 0 takes all.
    #[arg(long, default_value_t = 0, help_heading = "Method")]
    threads: usize,
    /// Folder of all files; made if it is not there.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Law of flow on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LawName {
    Newtonian,
    Power,
    Bingham,
    HerschelBulkley,
}

/// Stage on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum StageName {
    Identify,
    Simulate,
    Train,
    Correct,
    Report,
}

impl From<LawName> for Law {
    fn from(name: LawName) -> Self {
        match name {
            LawName::Newtonian => Self::Newtonian,
            LawName::Power => Self::Power,
            LawName::Bingham => Self::Bingham,
            LawName::HerschelBulkley => Self::HerschelBulkley,
        }
    }
}

impl From<StageName> for Stage {
    fn from(name: StageName) -> Self {
        match name {
            StageName::Identify => Self::Identify,
            StageName::Simulate => Self::Simulate,
            StageName::Train => Self::Train,
            StageName::Correct => Self::Correct,
            StageName::Report => Self::Report,
        }
    }
}

/// Reads `I/N`.
fn shard(text: &str) -> Result<Shard, String> {
    let wrong = || format!("'{text}' is not I/N, as 3/8: part I, from 1, of N parts");
    let (job, jobs) = text.split_once('/').ok_or_else(wrong)?;
    let [job, jobs] = [job, jobs].map(|number| number.trim().parse::<usize>().map_err(|_| wrong()));
    let (job, jobs) = (job?, jobs?);
    if job == 0 || job > jobs { Err(wrong()) } else { Ok(Shard { job, jobs }) }
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let begun = Instant::now();
    note_folders(&arguments.out.join("plan.json"));
    check_writable(&arguments.out.join("plan.json"))?;
    let Inputs { liquid, glass, measured } = read(arguments)?;
    let plan = Plan::new(liquid, glass);
    let plan = if arguments.quick { plan.quick() } else { plan };
    let base = (arguments.from != "scratch").then(|| file(&arguments.from)).transpose()?;
    let base: &[u8] = base.as_deref().unwrap_or_default();
    let plan = Plan {
        spacing_m: 1e-3 * arguments.spacing_mm,
        seconds: arguments.seconds.unwrap_or(plan.seconds),
        sizes: SetSizes {
            training: arguments.training.unwrap_or(plan.sizes.training),
            validation: arguments.validation.unwrap_or(plan.sizes.validation),
            held_out: arguments.held_out.unwrap_or(plan.sizes.held_out),
        },
        rough: arguments.rough || plan.rough,
        strength: arguments.strength,
        seed: arguments.seed,
        hyperparameters: match &arguments.hyperparameters {
            Some(path) => hyperparameters(path)?,
            None => plan.hyperparameters,
        },
        transfer: !base.is_empty(),
        base: if base.is_empty() { 0 } else { meniscus::blob::CRC.checksum(base) },
        recordings: measured.iter().map(|one| (one.record.name.clone(), one.checksum)).collect(),
        oracle: arguments.oracle.clone(),
        ..plan
    };
    plan.check()?;
    let stop = watched_until(format!(
        "finished recordings and checkpoints are kept in {}, and the same command continues from there",
        arguments.out.display()
    ))?;
    let bars = Bars::default();
    let progress: &dyn Progress = if arguments.json { &Silent } else { &bars };
    let folder = Folder::new(&arguments.out);
    let command = command(arguments);
    let workers = Workers { processors: arguments.threads, shard: arguments.shard.unwrap_or(Shard::WHOLE) };
    let run = Run {
        plan: &plan,
        folder: &folder,
        measured: &measured,
        base,
        command: &command,
        workers,
        stop,
        progress,
    };
    let outcome = run.go(arguments.until.into());
    bars.clear();
    let outcome = outcome?;
    finish();
    tell(arguments, &folder, &outcome, begun.elapsed().as_secs_f64());
    Ok(())
}

/// Prints the outcome.
fn tell(arguments: &Arguments, folder: &Folder, outcome: &Outcome, seconds: f64) {
    let finished = outcome.finished;
    if arguments.json {
        println!(
            "{:#}",
            serde_json::json!({
                "folder": folder.path(),
                "finished": finished.name(),
                "model": (finished >= Stage::Correct).then(|| folder.model()),
                "liquid": folder.liquid(),
                "sentences": outcome.sentences,
                "seconds": seconds,
                "checks": outcome.checks,
            })
        );
        return;
    }
    outcome.sentences.iter().for_each(|sentence| println!("{sentence}"));
    print!("{}", table(&outcome.checks));
    println!("{}", next(finished, folder, seconds));
}

/// Says where the result is and what comes next.
fn next(finished: Stage, folder: &Folder, seconds: f64) -> String {
    let after = format!("after {seconds:.0} s");
    match finished {
        Stage::Identify => format!(
            "{}: look at it, edit it if you know better, and run again without --until ({after})",
            folder.liquid().display()
        ),
        Stage::Simulate => {
            format!("{}: run again without --until or --shard ({after})", folder.recordings().display())
        }
        Stage::Train => format!("{}: run again without --until ({after})", folder.trained().display()),
        Stage::Correct => format!("{}: run again for the report ({after})", folder.model().display()),
        Stage::Report => format!(
            "{} ({after}); report: {}; watch it: meniscus run --model {} --view",
            folder.model().display(),
            folder.page().display(),
            folder.model().display()
        ),
    }
}

/// Reads hyperparameters: an object of their own, or the answer of `meniscus train --json` that holds one.
fn hyperparameters(path: &Path) -> anyhow::Result<Hyperparameters> {
    let text = std::fs::read_to_string(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let wrong =
        || format!("{} holds no hyperparameters as `meniscus train --json` prints them", path.display());
    let mut value: serde_json::Value = serde_json::from_str(&text).with_context(wrong)?;
    if let Some(inner) = value.get_mut("hyperparameters") {
        value = inner.take();
    }
    let parameters: Hyperparameters = serde_json::from_value(value).with_context(wrong)?;
    let schedule = parameters.schedule;
    ensure!(
        schedule.autoencoder.min(schedule.encoder).min(schedule.rollout) > 0,
        "{}: a stage of no steps trains nothing; give each at least 1",
        path.display()
    );
    if parameters.pod.max_modes.contains(&0) {
        bail!("{}: a group of no modes has no field; give each at least 1", path.display());
    }
    Ok(parameters)
}

/// The command as it belongs into the provenance: names without folders, which mean nothing elsewhere.
fn command(arguments: &Arguments) -> String {
    let name = |text: &String| {
        Path::new(text).file_name().map_or_else(|| text.clone(), |name| name.to_string_lossy().into_owned())
    };
    let inputs: Vec<String> = arguments.inputs.iter().map(name).collect();
    let quick = if arguments.quick { " --quick" } else { "" };
    format!("meniscus learn {} --seed {}{quick}", inputs.join(" "), arguments.seed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_parts_from_one_on() {
        assert_eq!(shard("3/8"), Ok(Shard { job: 3, jobs: 8 }));
        for wrong in ["0/8", "9/8", "3", "a/b", "/", "-1/2"] {
            assert!(shard(wrong).is_err_and(|why| why.contains("I/N")), "{wrong}");
        }
    }
}
