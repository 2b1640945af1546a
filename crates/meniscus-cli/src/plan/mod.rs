//! `meniscus plan`: the fastest motion of a glass whose crest stays below a limit.

mod said;
mod study;
mod table;

use crate::inputs::file;
use crate::outputs::Force;
use anyhow::{Context, bail, ensure};
use meniscus::blob::Model;
use meniscus::surface::Optics;
use meniscus_data::glass::{Glass, WallShape};
use meniscus_data::liquids::Liquid;
use meniscus_data::scene_file::GLASS;
use meniscus_plan::study::{Trace, move_png};
use meniscus_plan::{LearnedModel, Limits, ReducedLiquid, Request, SurfaceModel, compare, plan};
use meniscus_service::setup::Setup;
use said::Planned;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Plan the fastest motion of a glass whose crest stays below a limit.
///
/// The glass goes along x from rest to rest. The motion keeps limits of speed, acceleration and jerk, and the crest keeps its limit
/// at the stated confidence, by the model's own forecast. The table in --out is a motion for `meniscus simulate --motion` and
/// `meniscus run --motion`.
///
/// --model plans by a learned model. --liquid plans by the reduced slosh model for any known liquid, without learning; its crest
/// is less certain. docs/plan/README.md has the accuracy of both, measured in the simulator.
#[derive(clap::Args)]
#[command(
    allow_negative_numbers = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus plan --to 0.3 --limit-mm 6 --out plan.csv\n  meniscus plan --liquid water --to 0.4 --limit-mm 8 --picture plan.png\n  meniscus simulate --motion plan.csv --seconds 2 --out plan.safetensors\n  meniscus plan study --moves 10 --json"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    wanted: Wanted,
}

#[derive(clap::Subcommand)]
enum Verb {
    Study(study::Arguments),
}

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args)]
struct Wanted {
    /// Position of the start along x, m.
    #[arg(long, default_value_t = 0.0, value_name = "M", help_heading = "Move")]
    from: f64,
    /// Position of the goal along x, m.
    #[arg(long, value_name = "M", required = true, help_heading = "Move")]
    to: Option<f64>,
    /// Highest that the surface may stand over the liquid at rest, mm.
    #[arg(long, value_name = "MM", required = true, help_heading = "Move")]
    limit_mm: Option<f64>,
    /// Chance that the crest stays below the limit, 0.5 to 0.999.
    #[arg(long, default_value_t = 0.95, help_heading = "Move")]
    confidence: f64,
    /// Highest point after arrival, mm [default: the limit].
    #[arg(long, value_name = "MM", help_heading = "Move")]
    residual_mm: Option<f64>,
    /// Largest speed, m/s.
    #[arg(long, default_value_t = Limits::default().speed_m_s, help_heading = "Robot")]
    vmax: f64,
    /// Largest acceleration, m/s2.
    #[arg(long, default_value_t = Limits::default().acceleration_m_s2, help_heading = "Robot")]
    amax: f64,
    /// Largest jerk, m/s3.
    #[arg(long, default_value_t = Limits::default().jerk_m_s3, help_heading = "Robot")]
    jmax: f64,
    /// Learned model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Liquid")]
    model: PathBuf,
    /// Plan by the reduced model of this liquid, by name or file.
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "model", help_heading = "Liquid")]
    liquid: Option<String>,
    /// The glass, as `meniscus setup` has measured it.
    #[arg(long, value_name = "FILE", help_heading = "Liquid")]
    setup: Option<PathBuf>,
    /// Table of the motion to write: t, x_m.
    #[arg(long, value_name = "FILE.csv", help_heading = "Output")]
    out: Option<PathBuf>,
    /// Picture to write: glass and surface beside minimum jerk.
    #[arg(long, value_name = "FILE.png", help_heading = "Output")]
    picture: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Some(Verb::Study(arguments)) => study::run(arguments),
        None => make(&arguments.wanted),
    }
}

/// Plans one motion and writes it.
fn make(wanted: &Wanted) -> anyhow::Result<()> {
    let request = request(wanted)?;
    for path in [&wanted.out, &wanted.picture].into_iter().flatten() {
        wanted.force.check(path)?;
    }
    let setup = wanted.setup.as_deref().map(Setup::read).transpose()?;
    if let Some(name) = &wanted.liquid {
        let liquid = Liquid::load(name)?;
        let glass = setup.as_ref().map_or(GLASS, glass_of);
        let Some(reduced) = ReducedLiquid::new(&glass, &liquid) else {
            bail!("the reduced model is of upright cylinders")
        };
        return write(wanted, &request, &reduced, &format!("reduced model of {}", liquid.name));
    }
    let blob = file(&wanted.model)?;
    let model =
        Model::load(&blob).with_context(|| format!("the model {} is refused", wanted.model.display()))?;
    if let Some(setup) = &setup {
        fits(wanted, setup, &model)?;
    }
    let name = format!("learned model of {}", model.header.liquid);
    write(wanted, &request, &LearnedModel::new(&model), &name)
}

/// The request that the arguments make, checked.
fn request(wanted: &Wanted) -> anyhow::Result<Request> {
    let (Some(to_m), Some(limit_mm)) = (wanted.to, wanted.limit_mm) else {
        bail!("give the goal with --to and the limit of the crest with --limit-mm")
    };
    let request = Request {
        to_m,
        limits: Limits { speed_m_s: wanted.vmax, acceleration_m_s2: wanted.amax, jerk_m_s3: wanted.jmax },
        limit_m: 1e-3 * limit_mm,
        confidence: wanted.confidence,
        residual_m: wanted.residual_mm.map(|mm| 1e-3 * mm),
    };
    request.check(wanted.from)?;
    Ok(request)
}

/// The cylinder that a setup has measured.
fn glass_of(setup: &Setup) -> Glass {
    let m = |mm: f64| 1e-3 * mm;
    let glass = setup.glass;
    Glass {
        radius_m: m(glass.radius_mm),
        fill_m: m(glass.fill_mm),
        rim_m: m(glass.rim_mm),
        wall: WallShape::UPRIGHT,
    }
}

/// Refuses a setup of another glass than the model's, and a limit above its rim.
fn fits(wanted: &Wanted, setup: &Setup, model: &Model<'_>) -> anyhow::Result<()> {
    let path = wanted.setup.as_deref().unwrap_or(Path::new(""));
    if let Err(misfit) = setup.settings_for(&model.header, Optics::default()) {
        bail!("{}: {misfit}", path.display());
    }
    let room_mm = setup.glass.rim_mm - setup.glass.fill_mm;
    let limit_mm = wanted.limit_mm.unwrap_or(0.0);
    ensure!(
        limit_mm < room_mm,
        "a limit of {limit_mm} mm is not below the rim of {}, which is {room_mm:.1} mm above the liquid: give a lower limit",
        path.display()
    );
    Ok(())
}

/// Plans by `model`, writes the outputs and says what was planned.
fn write<M: SurfaceModel>(wanted: &Wanted, request: &Request, model: &M, name: &str) -> anyhow::Result<()> {
    let (rest, start) = (model.rest(), Instant::now());
    let plan = plan(model, &rest, wanted.from, request)?;
    let solve_ms = 1e3 * start.elapsed().as_secs_f64();
    let rival = compare(model, &rest, &plan);
    if let Some(path) = &wanted.out {
        table::write(path, &plan.course, &table::head(wanted.from, request, name))?;
    }
    if let Some(path) = &wanted.picture {
        let trace = |at: &dyn Fn(f64) -> f64, frames: &[meniscus_plan::FrameForecast]| Trace {
            position_m: (0..=frames.len()).map(|n| at(n as f64 / 60.0)).collect(),
            highest_m: std::iter::once(0.0).chain(frames.iter().map(|frame| frame.crest_m())).collect(),
        };
        let planned = trace(&|t| plan.course.at(t).position_m, &plan.frames);
        let plain = trace(&|t| rival.motion.at(t).position_m, &rival.frames);
        let traces = [("planned", &planned), ("minimum jerk in the same time", &plain)];
        move_png(&format!("forecast by the {name}"), request.limit_m, &traces, path)?;
    }
    let planned = Planned { request, plan: &plan, rival: &rival, solve_ms, from_m: wanted.from, name };
    if wanted.json {
        println!("{:#}", planned.json());
    } else {
        print!("{}", planned.text());
        for path in [&wanted.out, &wanted.picture].into_iter().flatten() {
            println!("written: {}", path.display());
        }
    }
    Ok(())
}
