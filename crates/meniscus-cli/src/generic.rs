//! `meniscus generic`: networks of a closed system from its trajectories, exact and soft side by side.

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

/// Learn any closed system from its trajectories, so that the laws of thermodynamics hold exactly.
///
/// The form that carries the liquid, z' = L dE + M dS with energy kept and entropy rising for every weight, is
/// learnt for whatever system DATASET holds: a pendulum with friction, a polymer in shear, a circuit that warms. The
/// file is npz, as numpy.savez writes it:
///
///   Z                   [trajectory, variable, step], float32 or float64: the states
///   dt                  time between two steps, s
///   train_idx test_idx  which trajectories are learnt from and judged by (a fifth is drawn if absent)
///   L                   [variable, variable], skew: the reversible operator, if known; else it is learnt
///   M                   [variable, variable]: its rows that are not zero have friction; else all may
///   t                   times; steps of Z beyond their count are not used
///
/// What is known of the variables makes the net better. --points and --momenta say which are positions and momenta of
/// bodies: the energy then sees distances alone, as nothing in a closed system knows which way is up. --entropies says
/// whose sum is the entropy of the whole; without it an entropy of its own is appended to the state. A pendulum of two
/// warm springs:
///
///   meniscus generic pendulum.npz --names q1x,q1y,q2x,q2y,p1x,p1y,p2x,p2y,s1,s2 \
///     --points q1x,q1y:q2x,q2y --momenta p1x,p1y:p2x,p2y --entropies s1,s2
///
/// One in eight of the trajectories that are learnt from is held back to choose by. With --soft a net whose laws are
/// a penalty in its loss alone learns the same; --weights replays a published net (W0, b0, .., mean, std, L, M, dt)
/// and compares the exact one with it.
///
/// Into --out go report.md, rollouts.png, learnt.png, and net.safetensors: the exact net's weights by name
/// (docs/formats.md). Ctrl-C ends every stage with its best so far; --resume goes on from there.
#[derive(clap::Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct Arguments {
    /// Trajectories, npz
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,
    /// A published net's weights, npz, to hold beside
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Names of the variables, by commas, in their order
    #[arg(long, value_name = "A,B,..", value_delimiter = ',')]
    names: Vec<String>,
    /// Points, their coordinates by commas, points by colons: q1x,q1y:q2x,q2y. The energy then sees distances alone
    #[arg(long, value_name = "A,B:C,D", default_value = "", hide_default_value = true)]
    points: String,
    /// Momenta of the points, in the same order
    #[arg(long, value_name = "A,B:C,D", default_value = "", hide_default_value = true, requires = "points")]
    momenta: String,
    /// Variables whose sum is the entropy of the whole; without them an entropy is appended to the state
    #[arg(long, value_name = "A,B,..", default_value = "", hide_default_value = true)]
    entropies: String,
    /// Learn L beyond what the file says of it
    #[arg(long)]
    learn_l: bool,
    /// Also train a net whose laws are a penalty in its loss alone
    #[arg(long)]
    soft: bool,
    /// A short schedule, about a minute, to see whether the file will do
    #[arg(long)]
    quick: bool,
    /// Seed of everything that is drawn
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the report; it is made if it is not there
    #[arg(long, default_value = "generic", value_name = "DIR")]
    out: PathBuf,
    /// Go on from the checkpoints of the same training that was broken off
    #[arg(long)]
    resume: bool,
    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(crate) fn run(args: &Arguments) -> anyhow::Result<()> {
    let stop = watched()?;

    let begun = Instant::now();
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

/// What the variables are, from their names.
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
