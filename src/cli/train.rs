//! `meniscus train`: from recordings to a weight blob.

use super::inputs::recordings;
use anyhow::Context;
use meniscus::host::checks::table;
use meniscus::host::files::write_whole;
use meniscus::offline::train::{Checkpoints, Options, Schedule, curves_png, train};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Learns a liquid from recordings and writes the weight blob that the camera side runs.
///
/// Five parts are learnt, in this order: a basis of every field (POD), a joint autoencoder down to
/// thirteen latents, the GRU that reads the latents from noisy surface profiles, the GENERIC step that
/// carries them through time, and the gain of the filter that joins the two. Every choice is made on
/// the validation recordings; keep a third set that neither has seen for `meniscus bench`.
///
/// Errors are relative to the slosh itself (slosh-rel = |z - zhat| / |z - z_rest|): a surface that is
/// called flat scores 100 %. Ctrl-C ends every part with its best so far and keeps checkpoints beside the
/// blob; a second one gives up. The errors of every part over its steps go to a picture beside the blob.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// Recordings to learn from: files, or a folder, which stands for its train-*.safetensors
    #[arg(long, required = true, num_args = 1.., value_name = "DIR_OR_FILES")]
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
    /// Also train the paper's net, whose laws are only asked for by its loss, and report both side by side
    #[arg(long)]
    soft: bool,
    /// Also train the paper's five sparse autoencoders, one a field group, and report what each keeps of thirteen
    /// latents beside the joint one
    #[arg(long)]
    sparse: bool,
    /// Go on from the checkpoints of the same training that was broken off
    #[arg(long)]
    resume: bool,
    /// The report as JSON on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Arguments) -> anyhow::Result<()> {
    static STOP: AtomicBool = AtomicBool::new(false);
    ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    })
    .context("Ctrl-C cannot be watched")?;

    let begun = Instant::now();
    let training = recordings(&args.recordings, "train-")?;
    let validation = recordings(&args.validate, "val-")?;
    let schedule = if args.quick { Schedule::QUICK } else { Schedule::FULL };
    let folder = beside(&args.out, ".training");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("{}: no place for checkpoints", folder.display()))?;
    let options = Options {
        seed: args.seed,
        schedule,
        soft: args.soft,
        sparse: args.sparse,
        quiet: args.json,
        command: command(args),
        checkpoints: Some(Checkpoints { folder: folder.clone(), resume: args.resume }),
    };
    let trained = train(&training, &validation, &options, &STOP)
        .with_context(|| format!("checkpoints lie in {}; --resume goes on from them", folder.display()))?;
    write_whole(&args.out, &trained.blob)?;
    let picture = beside(&args.out, ".png");
    curves_png(&trained.curves, &picture)?;
    let broken_off = STOP.load(Ordering::Relaxed);
    if !broken_off {
        std::fs::remove_dir_all(&folder)
            .with_context(|| format!("{} cannot be cleared", folder.display()))?;
    }

    let seconds = begun.elapsed().as_secs_f64();
    if args.json {
        let report = serde_json::json!({
            "blob": args.out,
            "bytes": trained.blob.len(),
            "seconds": seconds,
            "curves": picture,
            "broken_off": broken_off,
            "checks": trained.checks,
        });
        println!("{report:#}");
        return Ok(());
    }
    print!("{}", table(&trained.checks));
    println!("{}: {} bytes after {seconds:.0} s", args.out.display(), trained.blob.len());
    println!("{}: how it learnt", picture.display());
    if broken_off {
        println!("broken off: this is the best so far; the same command with --resume goes on from here");
    }
    Ok(())
}

/// `path` with `ending` behind its name.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(ending);
    path.with_file_name(name)
}

/// The command as it belongs into the provenance: names without folders, which mean nothing elsewhere.
fn command(args: &Arguments) -> String {
    let names = |paths: &[PathBuf]| {
        let name = |p: &PathBuf| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
        paths.iter().map(name).collect::<Vec<_>>().join(" ")
    };
    let quick = if args.quick { " --quick" } else { "" };
    let (recordings, validate) = (names(&args.recordings), names(&args.validate));
    format!("meniscus train --recordings {recordings} --validate {validate} --seed {}{quick}", args.seed)
}
