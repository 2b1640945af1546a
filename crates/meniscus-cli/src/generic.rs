//! `meniscus generic`: networks of a closed system from its trajectories, exact and soft side by side.

use super::kind::{Kind, expect};
use super::stop::watched;
use anyhow::{Context, ensure};
use generic_systems::{
    Dataset, Kinds, Networks, Options, Outcome, ProgressBars, Published, ReversibleOperator, Schedule,
    checks, markdown, rollouts_png, train,
};
use meniscus_learn::curves_png;
use meniscus_optim::progress::Checkpoints;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::table;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Learn a closed system from trajectories, with exact thermodynamics.
///
/// The form that carries the liquid, z' = L dE + M dS, keeps energy and never lowers entropy, whatever its weights are. Here it
/// is learnt for any system: a pendulum with friction, a polymer in shear, a circuit that warms.
///
/// --points and --momenta name the positions and momenta of bodies. The energy then depends on distances alone. --entropies names
/// the variables whose sum is the entropy of the whole; without it an entropy is appended to the state.
///
/// One in eight of the training trajectories is held back for validation. --soft also trains a net whose laws are only a penalty
/// in the loss. --weights replays a published net (W0, b0, .., mean, std, L, M, dt) and compares both.
///
/// The --out folder gets report.md, rollouts.png, learnt.png, and net.safetensors, the exact net's weights by name
/// (docs/formats.md). Ctrl-C ends every stage with its best so far; --resume continues from there.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus generic pendulum.npz --quick\n  meniscus generic pendulum.npz \\\n    --names q1x,q1y,q2x,q2y,p1x,p1y,p2x,p2y,s1,s2 \\\n    --points q1x,q1y:q2x,q2y --momenta p1x,p1y:p2x,p2y --entropies s1,s2",
    after_long_help = "DATASET is an npz file, as numpy.savez writes it:\n  Z                   [trajectory, variable, step], float32 or float64: states\n  dt                  time between two steps, s\n  train_idx test_idx  trajectories for training and test [default: a fifth]\n  L                   [variable, variable], skew: the reversible operator\n                      [default: it is learnt]\n  M                   [variable, variable]: rows that are not zero have\n                      friction [default: all may]\n  t                   times; steps of Z beyond their count are not used"
)]
pub(crate) struct Arguments {
    /// Trajectories, npz.
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,
    /// Weights of a published net, npz, to compare with.
    #[arg(long, value_name = "FILE", help_heading = "Input")]
    weights: Option<PathBuf>,
    /// Names of the variables in their order [default: z1,z2,..].
    #[arg(long, value_name = "A,B,..", value_delimiter = ',', help_heading = "Variables")]
    names: Vec<String>,
    /// Positions: coordinates of a point by commas, points by colons.
    #[arg(
        long,
        value_name = "A,B:C,D",
        default_value = "",
        hide_default_value = true,
        help_heading = "Variables"
    )]
    points: String,
    /// Momenta of the points, in the same order.
    #[arg(
        long,
        value_name = "A,B:C,D",
        default_value = "",
        hide_default_value = true,
        requires = "points",
        help_heading = "Variables"
    )]
    momenta: String,
    /// Variables whose sum is the entropy of the whole.
    #[arg(
        long,
        value_name = "A,B,..",
        default_value = "",
        hide_default_value = true,
        help_heading = "Variables"
    )]
    entropies: String,
    /// Learn L beyond what the file states.
    #[arg(long, help_heading = "Method")]
    learn_l: bool,
    /// Also train a net whose laws are only a penalty in the loss.
    #[arg(long, help_heading = "Method")]
    soft: bool,
    /// A short schedule, about a minute.
    #[arg(long, help_heading = "Method")]
    quick: bool,
    /// Seed of all random draws.
    #[arg(long, default_value_t = 1, help_heading = "Method")]
    seed: u64,
    /// Continue from the checkpoints of the same training.
    #[arg(long, help_heading = "Method")]
    resume: bool,
    /// Folder for the report; it is made.
    #[arg(long, default_value = "generic", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Arguments) -> anyhow::Result<()> {
    let stop = watched()?;

    let begun = Instant::now();
    expect(&args.dataset, Kind::Arrays, "an npz file")?;
    let data = Dataset::read(&args.dataset, args.seed)?;
    let published = args.weights.as_deref().map(Published::read).transpose()?;
    if let (Some(net), Some(path)) = (&published, &args.weights) {
        ensure!(
            net.variables() == data.variables(),
            "{} is of {} variables, the states in {} have {}",
            path.display(),
            net.variables(),
            args.dataset.display(),
            data.variables()
        );
    }
    let names = names(args, data.variables())?;
    let kinds = kinds(args, &names)?;
    if let Some(clash) = kinds.clash(&data) {
        anyhow::bail!("{}, {clash}: leave out --entropies, or correct L", args.dataset.display());
    }
    let folder = args.out.join("training");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("{}: no place for checkpoints", folder.display()))?;
    let options = Options {
        seed: args.seed,
        schedule: if args.quick { Schedule::QUICK } else { Schedule::FULL },
        kinds,
        reversible: if args.learn_l { ReversibleOperator::Learnt } else { ReversibleOperator::FromFile },
        networks: if args.soft { Networks::ExactAndSoft } else { Networks::Exact },
        progress: if args.json { ProgressBars::Hidden } else { ProgressBars::Shown },
        checkpoints: Some(Checkpoints { folder: folder.clone(), resume: args.resume }),
    };
    let outcome = train(data, names, published.as_ref(), &options, stop);
    let broken_off = stop.load(Ordering::Relaxed);
    if !broken_off {
        std::fs::remove_dir_all(&folder)
            .with_context(|| format!("{} cannot be cleared", folder.display()))?;
    }
    write(args, &outcome)?;
    let (checks, seconds) = (checks(&outcome), begun.elapsed().as_secs_f64());
    if args.json {
        let report = serde_json::json!({
            "out": args.out, "seconds": seconds, "broken_off": broken_off, "checks": checks,
        });
        println!("{report:#}");
        return Ok(());
    }
    print!("{}", table(&checks));
    println!(
        "{}: report.md, rollouts.png, learnt.png, net.safetensors after {seconds:.0} s",
        args.out.display()
    );
    if broken_off {
        println!("broken off: this is the best so far; the same command with --resume goes on from here");
    }
    Ok(())
}

/// Names of the variables: those given, or z1, z2, ..
fn names(args: &Arguments, variables: usize) -> anyhow::Result<Vec<String>> {
    if args.names.is_empty() {
        return Ok((1..=variables).map(|k| format!("z{k}")).collect());
    }
    ensure!(
        args.names.len() == variables,
        "--names lists {} names, the states have {variables} variables",
        args.names.len()
    );
    Ok(args.names.clone())
}

/// Meaning of the variables, from their names.
fn kinds(args: &Arguments, names: &[String]) -> anyhow::Result<Kinds> {
    let one = |name: &str| {
        let at = names.iter().position(|known| known == name.trim());
        at.with_context(|| format!("no variable is named '{name}': they are {}", names.join(", ")))
    };
    let list =
        |text: &str| text.split(',').filter(|name| !name.is_empty()).map(one).collect::<anyhow::Result<_>>();
    let lists =
        |text: &str| text.split(':').filter(|part| !part.is_empty()).map(list).collect::<anyhow::Result<_>>();
    let kinds = Kinds {
        points: lists(&args.points)?,
        momenta: lists(&args.momenta)?,
        entropies: list(&args.entropies)?,
    };
    if let Some(fault) = kinds.fault(names.len()) {
        anyhow::bail!("--points, --momenta, --entropies: {fault}");
    }
    Ok(kinds)
}

/// Writes the report, the pictures and the weights.
fn write(args: &Arguments, outcome: &Outcome) -> anyhow::Result<()> {
    write_whole(&args.out.join("report.md"), markdown(outcome, &command(args)).as_bytes())?;
    rollouts_png(outcome, &args.out.join("rollouts.png"))?;
    curves_png(&outcome.curves, &args.out.join("learnt.png"))?;
    write_whole(&args.out.join("net.safetensors"), &outcome.safetensors()?)?;
    Ok(())
}

/// The command as it belongs into the report: names of files without their folders.
fn command(args: &Arguments) -> String {
    let name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut command = format!("meniscus generic {}", name(&args.dataset));
    if let Some(weights) = &args.weights {
        command += &format!(" --weights {}", name(weights));
    }
    if !args.names.is_empty() {
        command += &format!(" --names {}", args.names.join(","));
    }
    for (flag, value) in
        [("points", &args.points), ("momenta", &args.momenta), ("entropies", &args.entropies)]
    {
        if !value.is_empty() {
            command += &format!(" --{flag} {value}");
        }
    }
    command += if args.learn_l { " --learn-l" } else { "" };
    command += if args.soft { " --soft" } else { "" };
    command += if args.quick { " --quick" } else { "" };
    command + &format!(" --seed {}", args.seed)
}
