//! `meniscus simulate`: from a liquid and a motion to a recording.

mod camera;
mod list;
mod said;
mod validate;

use crate::kind::check_ending;
use crate::outputs::{Force, check_folder};
use anyhow::{Context, bail};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Motion;
use meniscus_data::scene_file::{Experiment, GLASS};
use meniscus_platform::files::finish_writes;
use meniscus_sph::validate::Stopwatch;
use meniscus_sph::{Particles, Setup, Simulator, record_particles};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Simulate a moved glass of liquid and record it.
///
/// The liquid is computed by smoothed particle hydrodynamics in a glass of 35 mm inner radius, filled to 70 mm, rim at 110 mm,
/// unless a scene file says otherwise. The recording holds at 60 Hz: the motion, the free surface, the edge that a camera would
/// see, the energies, and the state (position, velocity, heat, stresses) at 2134 tracers.
///
/// An effect changes the liquid or the glass (--effect surface_tension=0.063). Values are in SI units and mean the same here, in
/// scene files, in `meniscus insert` and in `meniscus discover`. --list shows liquids, motions and effects with units and ranges.
/// A scene file holds glass, liquid, motion and effects together; the command line goes before it.
///
/// At the spacing of 5 mm it takes 5 to 8 s of processor time for each second of slosh, a yield stress 11 s, mayonnaise 12 s. A
/// new glass takes 5 s more to come to rest. It is kept in ~/.cache/meniscus for other liquids and motions. The first mode of
/// glycerine has 2 % error in frequency and decay, that of water 1 %. The numerical viscosity is 2.7e-6 m2/s.
#[derive(clap::Args)]
#[command(
    allow_negative_numbers = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus simulate --list\n  meniscus simulate --motion strokes:7 --out strokes-7.safetensors\n  meniscus simulate --motion table.csv --seconds 4 --out mine.safetensors\n  meniscus simulate --motion jolts:1 --effect wall_slip=0.002 \\\n    --camera images --out slip.safetensors"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    recording: Wanted,
}

#[derive(clap::Subcommand)]
enum Verb {
    Validate(validate::Arguments),
}

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args)]
struct Wanted {
    /// Show liquids, motions and effects, and do nothing else.
    #[arg(long, help_heading = "Scene")]
    list: bool,
    /// Scene file: glass, liquid, motion and effects in TOML.
    #[arg(long, value_name = "FILE", help_heading = "Scene")]
    scene: Option<PathBuf>,
    /// Liquid by name or file [default: that of the scene, or glycerine].
    ///
    /// Names: glycerine, water, blood, butter, honey, beer, gazpacho, chocolate, mayonnaise, ketchup.
    #[arg(long, value_name = "NAME|FILE", help_heading = "Scene")]
    liquid: Option<String>,
    #[arg(
        long,
        value_name = "KIND:SEED|FILE.csv",
        help_heading = "Scene",
        help = "Motion of the glass, from rest to rest; may be repeated",
        long_help = "Motion of the glass, from rest to rest; may be repeated.\n\nThe same spelling is always the same motion. strokes:7x0.25 has a quarter of the travel.\n\n  strokes:7   smooth strokes of 20 to 60 mm with rests\n  sweep:7     a sine whose frequency rises through the first mode\n  jolts:7     short half-sine pushes, each caught by an opposite one\n  random:7    a random motion between 0.5 and 4.5 Hz\n  hand:7      strokes, and a tenth as large ones away from the camera\n  heave:7     smooth strokes upwards and downwards\n  tilts:7     smooth inclinations about the middle of the bottom\n  carry:7     strokes, heaves and inclinations at once\n  still       no motion\n\nFILE.csv has a heading 't, x_m, y_m, z_m, tilt_rad', or some of them; y is away from the camera. Other units: t_ms, x_mm, tilt_deg. Its samples are joined by cubic splines. A line '# pivot_m = X, Z' is the point that the glass is inclined about."
    )]
    motion: Vec<String>,
    /// Effect to switch on, in SI units; may be repeated.
    #[arg(long, value_name = "NAME=VALUE[,VALUE]", help_heading = "Scene")]
    effect: Vec<String>,
    /// Length of each recording, s, 0.1 to 600; the last fifth (at most 1 s) is free decay.
    #[arg(long, default_value_t = 6.0, help_heading = "Scene")]
    seconds: f64,
    /// Spacing of the particles, mm [default: that of the scene, or 5].
    ///
    /// Half of it takes about 16 times as long.
    #[arg(long, value_name = "MM", help_heading = "Method")]
    spacing_mm: Option<f64>,
    /// A spacing of 3.5 mm: half the error of short waves, 4 times the time.
    #[arg(long, conflicts_with = "spacing_mm", help_heading = "Method")]
    fine: bool,
    /// Threads; 0 takes all processors. The result does not depend on it.
    #[arg(long, default_value_t = 0, help_heading = "Method")]
    threads: usize,
    /// File to write; with several motions, the folder for KIND-SEED.safetensors.
    #[arg(long, required_unless_present = "list", help_heading = "Output")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Also write the camera's images into DIR.
    ///
    /// 16-bit depth (steps of 0.1 mm) and 8-bit infrared as PNG, and the times as frames.csv. With several motions, into a
    /// folder for each.
    #[arg(long, value_name = "DIR", help_heading = "Output")]
    camera: Option<PathBuf>,
    /// Also write the particles of every frame as NAME.particles.safetensors.
    #[arg(long, help_heading = "Output")]
    particles: bool,
    /// Keep as few modes of each field as hold its error below TOL (0.005 = 0.5 %).
    #[arg(long, value_name = "TOL", help_heading = "Output")]
    compact: Option<f64>,
    /// Print one JSON object for each recording.
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Spacing of the particles with --fine, mm.
const FINE_MM: f64 = 3.5;

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match &arguments.verb {
        Some(Verb::Validate(arguments)) => validate::run(arguments),
        None => make(&arguments.recording),
    }
}

/// Makes the recordings.
fn make(arguments: &Wanted) -> anyhow::Result<()> {
    if arguments.list {
        return list::print();
    }
    let Some(out) = &arguments.out else { bail!("give the file to write with --out") };
    let frames = frames(arguments.seconds)?;
    if let Some(tolerance) = arguments.compact.filter(|t| !(1e-6..=0.5).contains(t)) {
        bail!("--compact {tolerance} is out of range: 0.000001 to 0.5");
    }
    let scene = arguments.scene.as_deref().map(Experiment::load).transpose()?.unwrap_or_default();
    let mut effects = scene.effects;
    for effect in &arguments.effect {
        effects.parse(effect).with_context(|| format!("--effect {effect}"))?;
    }
    effects.require_simulated()?;
    let name = arguments.liquid.as_deref().or(scene.liquid.as_deref()).unwrap_or("glycerine");
    let fine = arguments.fine.then_some(FINE_MM);
    let mut setup = Setup {
        glass: scene.glass.unwrap_or(GLASS),
        liquid: Liquid::load(name)?,
        spacing_m: 1e-3 * fine.or(arguments.spacing_mm).or(scene.spacing_mm).unwrap_or(5.0),
        seed: 0,
        no_slip: true,
        effects,
        step_s: scene.step_s,
    };
    setup.longest_step_s()?;
    let spellings = if arguments.motion.is_empty() { scene.motion.as_slice() } else { &arguments.motion };
    if spellings.is_empty() {
        bail!("give a motion with --motion, or a scene that has one");
    }
    let mut motions = Vec::new();
    for spelling in spellings {
        let motion = Motion::parse(spelling, arguments.seconds)?;
        if arguments.camera.is_some() {
            camera::check(&setup, &motion, arguments.seconds)?;
        }
        motions.push(motion);
    }
    for motion in &motions {
        let path = output(out, motion, motions.len())?;
        check_ending(&path, "safetensors")?;
        arguments.force.check(&path)?;
        if arguments.particles {
            arguments.force.check(&path.with_extension("particles.safetensors"))?;
        }
    }
    arguments.camera.as_deref().map_or(Ok(()), check_folder)?;
    rayon_threads(arguments.threads)?;
    let writing = stoppable()?;
    // As one of the threads that share the work: from outside, every sum of every step would wait for them to wake.
    rayon::scope(|_| {
        for motion in &motions {
            let path = output(out, motion, motions.len())?;
            setup.seed = motion.seed;
            let folder = arguments.camera.as_ref().map(|folder| match motions.len() {
                1 => folder.clone(),
                _ => folder.join(path.file_stem().unwrap_or_default()),
            });
            one(arguments, &setup, motion, frames, &path, folder.as_deref(), &writing)?;
        }
        Ok(())
    })
}

/// Simulates, writes and reports one recording.
fn one(
    arguments: &Wanted,
    setup: &Setup,
    motion: &Motion,
    frames: usize,
    path: &Path,
    folder: Option<&Path>,
    writing: &Mutex<()>,
) -> anyhow::Result<()> {
    let bar = crate::bars::bar(frames as u64);
    bar.set_style(crate::bars::style("{prefix} {wide_bar} {pos}/{len} frames, {left}")?);
    bar.set_prefix(motion.spelling.clone());
    let stopwatch = Stopwatch::start();
    let command = command(arguments, setup, motion);
    let mut particles = Particles::default();
    let each = |simulator: &Simulator| {
        if arguments.particles {
            particles.take(simulator);
        }
    };
    let progress = |done: usize| bar.set_position(done as u64);
    let mut recording = record_particles(setup, motion, frames, &command, progress, each)?;
    bar.finish_and_clear();
    let processor_s = stopwatch.seconds();
    if let Some(tolerance) = arguments.compact {
        recording = recording.compact(tolerance);
    }
    {
        let _disk = writing.lock();
        recording.save(path)?;
        if arguments.particles {
            particles.save(&path.with_extension("particles.safetensors"))?;
        }
    }
    let cost = said::Cost { wall_s: stopwatch.wall_s(), processor_s };
    said::report(&recording, path, cost, arguments.json);
    if let Some(folder) = folder {
        camera::render(&recording, folder)?;
        if !arguments.json {
            println!("  the camera's images are in {}", folder.display());
        }
    }
    Ok(())
}

/// Makes Ctrl-C end the command at once, but never while the returned lock is held: a file that is
/// being written is written to its end.
fn stoppable() -> anyhow::Result<Arc<Mutex<()>>> {
    let writing = Arc::new(Mutex::new(()));
    let lock = Arc::clone(&writing);
    let stop = move || {
        let _disk = lock.lock();
        finish_writes();
        eprintln!(
            "\ninterrupted: the recording that was being simulated is not written; earlier ones are kept"
        );
        std::process::exit(130);
    };
    ctrlc::set_handler(stop).context("cannot watch for Ctrl-C")?;
    Ok(writing)
}

/// Whole frames in `seconds`.
fn frames(seconds: f64) -> anyhow::Result<usize> {
    if !(0.1..=600.0).contains(&seconds) {
        bail!("--seconds {seconds} is out of range: 0.1 to 600");
    }
    Ok((seconds / FRAME_INTERVAL_S).round() as usize)
}

/// Where the recording of `motion` goes.
fn output(out: &Path, motion: &Motion, motions: usize) -> anyhow::Result<PathBuf> {
    let file = motions == 1 && !out.is_dir();
    let directory = if file { out.parent().unwrap_or(Path::new("")) } else { out };
    std::fs::create_dir_all(directory)
        .with_context(|| format!("cannot make the directory {}", directory.display()))?;
    if file {
        return Ok(out.to_owned());
    }
    // A scripted motion is no path, though its scale may have a point.
    let path = Path::new(&motion.spelling);
    let stem = if motion.spelling.contains(':') { Some(path.as_os_str()) } else { path.file_stem() };
    let stem = stem.unwrap_or_default().to_string_lossy().replace(':', "-");
    Ok(out.join(format!("{stem}.safetensors")))
}

/// The command that makes this one recording again.
fn command(arguments: &Wanted, setup: &Setup, motion: &Motion) -> String {
    let compact = arguments.compact.map_or(String::new(), |t| format!(" --compact {t}"));
    let scene = arguments.scene.as_ref().map_or(String::new(), |path| format!(" --scene {}", path.display()));
    let effects: String = arguments.effect.iter().map(|effect| format!(" --effect {effect}")).collect();
    let liquid = match (&arguments.liquid, &arguments.scene) {
        (None, Some(_)) => String::new(),
        (liquid, _) => format!(" --liquid {}", liquid.as_deref().unwrap_or("glycerine")),
    };
    let spacing_mm = arguments.spacing_mm.unwrap_or((1e9 * setup.spacing_m).round() / 1e6);
    format!(
        "meniscus simulate{scene}{liquid} --motion {} --seconds {} --spacing-mm {spacing_mm}{effects}{compact}",
        motion.spelling, arguments.seconds
    )
}

/// Sets the number of threads; 0 leaves one a processor.
fn rayon_threads(threads: usize) -> anyhow::Result<()> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build_global().context("cannot start the threads")
}
