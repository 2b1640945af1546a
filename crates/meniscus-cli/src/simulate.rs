//! `meniscus simulate`: from a liquid and a motion to a recording.

mod camera;
mod list;
mod validate;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Recording, States};
use meniscus_data::scene_file::{Experiment, GLASS};
use meniscus_sph::validate::Stopwatch;
use meniscus_sph::{Particles, Setup, Simulator, record_particles, relative_closure};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Simulate a moved glass of liquid and record it.
///
/// The glass (inner radius 35 mm, filled to 70 mm, rim at 110 mm, unless a scene file says otherwise)
/// is moved from rest to rest while the liquid inside is computed by smoothed particle hydrodynamics. The recording holds, at
/// 60 Hz: the motion, the free surface, the edge that a camera would see, the energies, and the full
/// state (position, velocity, heat, stresses) at 2134 tracers.
///
/// A motion is spelled KIND:SEED, and the same spelling is the same motion for ever:
///
///   strokes:7   smooth strokes of 20 to 60 mm with rests between them
///   sweep:7     a sine whose frequency rises through the first slosh mode
///   jolts:7     short half-sine pushes, each caught by an equal one the other way
///   random:7    a random motion between 0.5 and 4.5 Hz
///   hand:7      strokes, and a tenth as large ones away from the camera and back
///   heave:7     smooth strokes upwards and downwards
///   tilts:7     smooth inclinations about the middle of the bottom
///   carry:7     strokes, heaves and inclinations at once
///   still       no motion
///   FILE.csv    a heading 't, x_m, y_m, z_m, tilt_rad' (or some of them; y is away from the camera) and
///               samples, joined by cubic splines; a line '# pivot_m = X, Z' says what the glass is
///               inclined about
///
/// Effects change the liquid or the glass by name (--effect surface_tension=0.063). A value is in SI
/// units and means the same here, in scene files, in `meniscus insert` and in `meniscus discover`;
/// --list shows them all with units, ranges and sources, beside the liquids and motions. A scene file (--scene) holds
/// glass, liquid, motion and effects together; what the command line says goes before it.
///
/// Numbers to expect at the spacing of 5 mm: 8 s of processor time to settle and 5 to 8 s for each second
/// of slosh. Glycerine's first mode is right to 2 % in frequency and decay, that of water to 1 %; the numerical
/// viscosity is 2.6e-6 m2/s. The second mode is 4 % too slow, 2 % with --fine. Very
/// stiff liquids take more, by the length of the step: chocolate 9, ketchup 11, mayonnaise 21 times.
#[derive(clap::Args)]
#[command(
    verbatim_doc_comment,
    allow_negative_numbers = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Examples:\n  meniscus simulate --liquid glycerine --motion strokes:7 --seconds 6 --out strokes-7.safetensors\n  \
                  meniscus simulate --motion jolts:1 --effect wall_slip=0.002 --camera images --out slip.safetensors\n  \
                  meniscus simulate --list"
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    verb: Option<Verb>,
    #[command(flatten)]
    recording: Option<Wanted>,
}

#[derive(clap::Subcommand)]
enum Verb {
    Validate(validate::Arguments),
}

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args)]
struct Wanted {
    /// A scene file: glass, liquid, motion and effects in TOML.
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// The liquid: glycerine, water, blood, butter, honey, beer, gazpacho, chocolate, mayonnaise,
    /// ketchup, or the path of a liquid file; glycerine where neither this nor a scene says.
    #[arg(long)]
    liquid: Option<String>,
    /// The motion, KIND:SEED or a CSV file; give it several times for several recordings.
    #[arg(long)]
    motion: Vec<String>,
    /// Switch on an effect; give it several times for several effects.
    #[arg(long, value_name = "NAME=VALUE[,VALUE]")]
    effect: Vec<String>,
    /// Show liquids, motions and effects, and do nothing else.
    #[arg(long)]
    list: bool,
    /// Length of each recording, s; the last fifth (at most 1 s) is free decay.
    #[arg(long, default_value_t = 6.0)]
    seconds: f64,
    /// The file to write; with several motions, the directory to write KIND-SEED.safetensors into.
    #[arg(long, required_unless_present = "list")]
    out: Option<PathBuf>,
    /// Also write what the camera would see into DIR: 16-bit depth (steps of 0.1 mm) and 8-bit infrared as PNG, and the
    /// times as frames.csv. With several motions, into a folder for each.
    #[arg(long, value_name = "DIR")]
    camera: Option<PathBuf>,
    /// Also write the particles themselves at every frame, beside the recording as NAME.particles.safetensors.
    #[arg(long)]
    particles: bool,
    /// Spacing of the particles, mm, 5 unless a scene says; half of it takes about 16 times as long.
    #[arg(long)]
    spacing_mm: Option<f64>,
    /// A spacing of 3.5 mm: short waves twice as right for about four times the time.
    #[arg(long, conflicts_with = "spacing_mm")]
    fine: bool,
    /// Threads to use; the result is the same bit for bit for any number. 0 takes all processors.
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Keep only as many modes of each field as hold its error below TOL (0.005 = 0.5 %).
    #[arg(long, value_name = "TOL")]
    compact: Option<f64>,
    /// Report on standard output as one JSON object a recording.
    #[arg(long)]
    json: bool,
}

/// Spacing of the particles with --fine, mm.
const FINE_MM: f64 = 3.5;

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    match (&arguments.verb, &arguments.recording) {
        (Some(Verb::Validate(arguments)), _) => validate::run(arguments),
        (None, Some(wanted)) => make(wanted),
        (None, None) => bail!("give a motion with --motion and a file with --out, or the verb 'validate'"),
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
    let bar = ProgressBar::new(frames as u64);
    bar.set_style(ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} frames, {eta} left")?);
    bar.set_prefix(motion.spelling.clone());
    let stopwatch = Stopwatch::start();
    let command = command(arguments, setup, motion);
    let mut particles = Particles::default();
    let each = |simulator: &Simulator| {
        if arguments.particles {
            particles.take(simulator);
        }
    };
    let told = |done: usize| bar.set_position(done as u64);
    let mut recording = record_particles(setup, motion, frames, &command, told, each)?;
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
    report(arguments, &recording, path, stopwatch.wall_s(), processor_s);
    if let Some(folder) = folder {
        camera::render(&recording, folder)?;
        if !arguments.json {
            println!("  the camera's images are in {}", folder.display());
        }
    }
    Ok(())
}

/// Prints what was made.
fn report(arguments: &Wanted, recording: &Recording, path: &Path, wall_s: f64, processor_s: f64) {
    let seconds = recording.frames() as f64 * FRAME_INTERVAL_S;
    let fill = recording.glass.fill_m as f32;
    let crest_mm = 1e3 * recording.wall_m.iter().fold(0.0_f32, |m, h| m.max(h - fill));
    let closure = relative_closure(&recording.energy);
    let cost = processor_s / seconds;
    let truncation = match &recording.states {
        States::Full(_) => None,
        States::Factored(factored) => Some(factored.truncation),
    };
    if arguments.json {
        // Escapes end a simulation with an error, so a recording that exists has none.
        println!(
            "{}",
            serde_json::json!({
                "file": path, "motion": recording.provenance.motion, "liquid": recording.provenance.liquid,
                "frames": recording.frames(), "crest_mm": crest_mm, "energy_closure": closure, "escapes": 0,
                "processor_s_per_simulated_s": cost, "wall_s": wall_s, "truncation": truncation,
            })
        );
        return;
    }
    println!(
        "{}: {} frames of {} in {}",
        path.display(),
        recording.frames(),
        recording.provenance.liquid,
        recording.provenance.motion
    );
    println!("  highest crest {crest_mm:.1} mm above the fill, no particle escaped");
    println!("  energy closes to {:.2} % of the largest slosh energy", 100.0 * closure);
    println!("  {cost:.1} s of processor time for each simulated second, {wall_s:.0} s in all");
    if let Some(errors) = truncation {
        let errors: Vec<_> = errors.iter().map(|e| format!("{:.2} %", 100.0 * e)).collect();
        println!("  truncation errors of q, v, e, sigma, tau: {}", errors.join(", "));
    }
}

/// Makes Ctrl-C end the command at once, but never while the returned lock is held: a file that is
/// being written is written to its end.
fn stoppable() -> anyhow::Result<Arc<Mutex<()>>> {
    let writing = Arc::new(Mutex::new(()));
    let lock = Arc::clone(&writing);
    let stop = move || {
        let _disk = lock.lock();
        eprintln!("interrupted: the recording that was being simulated is not written");
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
