//! `meniscus train`: from recordings to a weight blob.

mod multi_seed;

use super::inputs::{check_apart, files, plain, recordings};
use super::kind::check_ending;
use super::outputs::Force;
use super::stop::{finish, watched_until};
use anyhow::Context;
use meniscus_data::liquids::{self, Liquid, Rheology};
use meniscus_data::recording::Recording;
use meniscus_learn::evaluate::unseen;
use meniscus_learn::{Base, Hyperparameters, Options, Schedule, Trained, curves_png, measured_again, train};
use meniscus_optim::progress::Checkpoints;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Train a model of a liquid on recordings and write its weight blob.
///
/// Stages: a basis of every field (POD), a joint autoencoder down to thirteen latents, a GRU encoder that reads the latents from
/// noisy surface profiles, the GENERIC step that predicts them, and the error model of the filter. Every choice is made on the
/// validation recordings. --test names a held-out recording for figures that nothing was chosen by.
///
/// Errors are relative to the slosh amplitude: |z - z_estimated| / |z - z_rest|. A flat surface scores 100 %. The learning curves
/// go to a picture beside the blob.
///
/// Ctrl-C writes no blob. The checkpoints stay beside --out, and --resume continues from them.
///
/// --repeat 5 trains from five seeds and writes the blob with the least validation error. A table with mean, standard deviation
/// and worst of every figure goes beside the blob as FILE.md.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus train --recordings data --validate data --quick --out quick.blob\n  meniscus train --recordings data --validate data \\\n    --test held-out.safetensors --out mine.blob\n  meniscus train --recordings data --validate data --out mine.blob --resume\n  meniscus train --intervals-of mine.blob --validate data --out new.blob"
)]
pub(crate) struct Arguments {
    /// Training recordings: files, or a folder for its train-*.safetensors.
    #[arg(
        long,
        required_unless_present = "intervals_of",
        num_args = 1..,
        value_name = "DIR_OR_FILES",
        help_heading = "Recordings"
    )]
    recordings: Vec<PathBuf>,
    /// Validation recordings: files, or a folder for its val-*.safetensors.
    #[arg(long, required = true, num_args = 1.., value_name = "DIR_OR_FILES", help_heading = "Recordings")]
    validate: Vec<PathBuf>,
    /// Held-out recording that the model is compared with.
    ///
    /// The model sees it through the rendered camera.
    #[arg(long, value_name = "FILE", help_heading = "Recordings")]
    test: Option<PathBuf>,
    /// A short schedule: a minute on two cores instead of six.
    #[arg(long, help_heading = "Method")]
    quick: bool,
    /// Seed of all random draws; seed and recordings determine the blob.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Number of seeds to train from, --seed and those after it, 1 to 100.
    #[arg(
        long,
        default_value_t = 1,
        value_name = "N",
        value_parser = clap::value_parser!(u64).range(1..=100),
        help_heading = "Method"
    )]
    repeat: u64,
    /// Also train a net whose laws are only a penalty in the loss, and compare both.
    #[arg(long, help_heading = "Method")]
    soft: bool,
    /// Also train five sparse autoencoders, one for each field group.
    ///
    /// The report compares what each keeps of thirteen latents.
    #[arg(long, help_heading = "Method")]
    sparse: bool,
    /// Train nothing: measure errors and intervals of BLOB anew on --validate.
    #[arg(
        long,
        value_name = "BLOB",
        conflicts_with_all = ["recordings", "quick", "soft", "sparse", "test", "repeat", "resume"],
        help_heading = "Method"
    )]
    intervals_of: Option<PathBuf>,
    /// Continue from the checkpoints of the same training.
    #[arg(long, help_heading = "Method")]
    resume: bool,
    /// Blob to write, whole or not at all.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object, with metric, seed and hyperparameters.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Arguments) -> anyhow::Result<()> {
    check_ending(&args.out, "blob")?;
    if !args.resume {
        args.force.check(&args.out)?;
    }
    let folder = beside(&args.out, ".training");
    let stop = watched_until(format!(
        "no blob is written; checkpoints are kept in {}, and the same command with --resume continues from them",
        folder.display()
    ))?;
    let begun = Instant::now();
    if let Some(blob) = &args.intervals_of {
        return intervals(args, blob);
    }
    check_apart(&files(&args.recordings, "train-")?, &files(&args.validate, "val-")?)?;
    let data = Data {
        training: recordings(&args.recordings, "train-", plain)?,
        validation: recordings(&args.validate, "val-", plain)?,
        test: args.test.as_deref().map(plain).transpose()?,
    };
    let report = if args.repeat > 1 {
        multi_seed::run(args, &data, &folder, stop)?
    } else {
        let trained = once(args, &data, args.seed, &folder, stop)?;
        let picture = write(args, &trained)?;
        serde_json::json!({
            "bytes": trained.blob.len(),
            "curves": picture,
            "checks": trained.checks,
            "stages": trained.stages,
            "hyperparameters": hyperparameters(args),
        })
    };
    std::fs::remove_dir_all(&folder).with_context(|| format!("{} cannot be cleared", folder.display()))?;

    let seconds = begun.elapsed().as_secs_f64();
    if args.json {
        let mut all = serde_json::json!({ "blob": args.out, "seconds": seconds, "broken_off": false });
        if let (Some(all), serde_json::Value::Object(report)) = (all.as_object_mut(), report) {
            all.extend(report);
        }
        println!("{all:#}");
        return Ok(());
    }
    println!("{} after {seconds:.0} s", args.out.display());
    Ok(())
}

/// Writes `blob` with its intervals measured again.
fn intervals(args: &Arguments, blob: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(blob).with_context(|| format!("{} cannot be read", blob.display()))?;
    let validation = recordings(&args.validate, "val-", plain)?;
    let measured = measured_again(&bytes, &validation, args.seed)
        .with_context(|| format!("{}: its intervals cannot be measured", blob.display()))?;
    finish();
    write_whole(&args.out, &measured.blob)?;
    if args.json {
        println!("{:#}", serde_json::json!({ "blob": args.out, "checks": measured.checks }));
    } else {
        print!("{}", table(&measured.checks));
        println!("{}", args.out.display());
    }
    Ok(())
}

/// Training, validation and held-out recordings.
struct Data {
    training: Vec<Recording>,
    validation: Vec<Recording>,
    test: Option<Recording>,
}

/// Hyperparameters of the training: the short schedule or the full one, and the values of the shipped models.
fn hyperparameters(args: &Arguments) -> Hyperparameters {
    Hyperparameters::with_schedule(if args.quick { Schedule::QUICK } else { Schedule::FULL })
}

/// Flow law of the liquid of `recordings`, where they name one that this program knows and its viscosity depends on the rate of shear.
fn flow_law(recordings: &[Recording]) -> Option<Rheology> {
    let name = recordings.first()?.provenance.liquid.as_str();
    let liquid = liquids::known().find(|known| *known == name).and_then(|known| Liquid::load(known).ok())?;
    (!liquid.rheology.is_newtonian()).then_some(liquid.rheology)
}

/// One training from `seed` with its checkpoints in `folder`, and its figures on the test recording.
fn once(
    args: &Arguments,
    data: &Data,
    seed: u64,
    folder: &Path,
    stop: &AtomicBool,
) -> anyhow::Result<Trained> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: no place for checkpoints", folder.display()))?;
    let options = Options {
        seed,
        hyperparameters: hyperparameters(args),
        soft: args.soft,
        sparse: args.sparse,
        quiet: args.json,
        command: command(args, seed),
        checkpoints: Some(Checkpoints { folder: folder.into(), resume: args.resume }),
        base: Base::Scratch,
        flow_law: flow_law(&data.training),
    };
    let mut trained = train(&data.training, &data.validation, &options, stop)
        .with_context(|| format!("checkpoints lie in {}; --resume goes on from them", folder.display()))?;
    if let Some(test) = &data.test {
        trained.checks.extend(unseen(&trained.blob, test, 1)?);
    }
    Ok(trained)
}

/// Writes the blob and the picture of its curves, whose place is returned, and shows the checks to a person.
fn write(args: &Arguments, trained: &Trained) -> anyhow::Result<PathBuf> {
    finish();
    write_whole(&args.out, &trained.blob)?;
    let picture = beside(&args.out, ".png");
    curves_png(&trained.curves, &picture)?;
    if !args.json {
        print!("{}", table(&trained.checks));
        println!("{}: learning curves", picture.display());
    }
    Ok(picture)
}

/// `path` with `ending` behind its name.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(ending);
    path.with_file_name(name)
}

/// The command as it belongs into the provenance: names without folders, which mean nothing elsewhere.
fn command(args: &Arguments, seed: u64) -> String {
    let names = |paths: &[PathBuf]| {
        let name = |p: &PathBuf| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
        paths.iter().map(name).collect::<Vec<_>>().join(" ")
    };
    let quick = if args.quick { " --quick" } else { "" };
    let (recordings, validate) = (names(&args.recordings), names(&args.validate));
    format!("meniscus train --recordings {recordings} --validate {validate} --seed {seed}{quick}")
}
