//! `meniscus train`: from recordings to a weight blob.

mod multi_seed;

use super::inputs::{plain, recordings};
use super::stop::watched;
use anyhow::Context;
use meniscus_data::recording::Recording;
use meniscus_learn::evaluate::unseen;
use meniscus_learn::{Hyperparameters, Options, Schedule, Trained, curves_png, measured_again, train};
use meniscus_optim::progress::Checkpoints;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Trains a model of a liquid on recordings and writes the weight blob that the camera side runs.
///
/// The stages are, in this order: a basis of every field (POD), a joint autoencoder down to thirteen latents, a GRU encoder
/// that reads the latents from noisy surface profiles, the GENERIC step that predicts them, and the error model by which the
/// filter joins the two. Every choice is made on the validation recordings. --test names a held-out recording for figures
/// that nothing was chosen by.
///
/// Errors are relative to the slosh itself (slosh-rel = |z - zhat| / |z - z_rest|): a surface that is
/// called flat scores 100 %. Ctrl-C ends every stage with its best so far and keeps checkpoints beside the
/// blob; a second one gives up. The errors of every stage over its steps go to a picture beside the blob. --json also gives
/// the seed, the metric and the checkpoint of every stage, and all hyperparameters.
///
/// --repeat 5 trains five times from five seeds and writes the blob that did best on the validation recordings. A table
/// with the mean, the standard deviation and the worst of every figure goes beside the blob as FILE.md.
///
/// --intervals-of BLOB trains nothing: it measures the errors and the intervals of BLOB again on the recordings of
/// --validate, and writes the blob with them to --out.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// Recordings to learn from: files, or a folder, which stands for its train-*.safetensors
    #[arg(long, required_unless_present = "intervals_of", num_args = 1.., value_name = "DIR_OR_FILES")]
    recordings: Vec<PathBuf>,
    /// Recordings to choose by: files, or a folder, which stands for its val-*.safetensors
    #[arg(long, required = true, num_args = 1.., value_name = "DIR_OR_FILES")]
    validate: Vec<PathBuf>,
    /// Where the blob goes; it is written whole or not at all
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// A short schedule, a minute on two cores instead of six, to see whether the recordings will do
    #[arg(long)]
    quick: bool,
    /// Seed of everything that is drawn; the same seed and recordings give the same blob
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Also train the paper's net, whose laws are a penalty in its loss alone, and report both side by side
    #[arg(long)]
    soft: bool,
    /// Also train the paper's five sparse autoencoders, one a field group, and report what each keeps of thirteen
    /// latents beside the joint one
    #[arg(long)]
    sparse: bool,
    /// A held-out recording: the rendered camera films it, and the model is compared with its truth
    #[arg(long, value_name = "FILE")]
    test: Option<PathBuf>,
    /// Train from this many seeds, --seed and those after it, and report mean and spread of every figure
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100))]
    repeat: u64,
    /// Train nothing, but measure the intervals of this blob again on the recordings of --validate
    #[arg(long, value_name = "BLOB", conflicts_with_all = ["recordings", "quick", "soft", "sparse", "test", "repeat", "resume"])]
    intervals_of: Option<PathBuf>,
    /// Go on from the checkpoints of the same training that was broken off
    #[arg(long)]
    resume: bool,
    /// The report as JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Arguments) -> anyhow::Result<()> {
    let stop = watched()?;

    let begun = Instant::now();
    if let Some(blob) = &args.intervals_of {
        return intervals(args, blob);
    }
    let data = Data {
        training: recordings(&args.recordings, "train-", plain)?,
        validation: recordings(&args.validate, "val-", plain)?,
        test: args.test.as_deref().map(plain).transpose()?,
    };
    let folder = beside(&args.out, ".training");
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
    let broken_off = stop.load(Ordering::Relaxed);
    if !broken_off {
        std::fs::remove_dir_all(&folder)
            .with_context(|| format!("{} cannot be cleared", folder.display()))?;
    }

    let seconds = begun.elapsed().as_secs_f64();
    if args.json {
        let mut all = serde_json::json!({ "blob": args.out, "seconds": seconds, "broken_off": broken_off });
        if let (Some(all), serde_json::Value::Object(report)) = (all.as_object_mut(), report) {
            all.extend(report);
        }
        println!("{all:#}");
        return Ok(());
    }
    println!("{} after {seconds:.0} s", args.out.display());
    if broken_off {
        println!("broken off: this is the best so far; the same command with --resume goes on from here");
    }
    Ok(())
}

/// Writes `blob` with its intervals measured again.
fn intervals(args: &Arguments, blob: &Path) -> anyhow::Result<()> {
    let bytes = std::fs::read(blob).with_context(|| format!("{} cannot be read", blob.display()))?;
    let validation = recordings(&args.validate, "val-", plain)?;
    let measured = measured_again(&bytes, &validation, args.seed)
        .with_context(|| format!("{}: its intervals cannot be measured", blob.display()))?;
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
