//! `meniscus correct`: a model learns another liquid from recordings of its free surface.

use anyhow::{Context, ensure};
use meniscus::blob::{Header, Model};
use meniscus_data::recording::Recording;
use meniscus_learn::correct::{Correction, CorrectionParameters, Sightings, correct};
use meniscus_platform::files::write_whole;
use meniscus_report::checks::{Check, table};
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use std::path::{Path, PathBuf};

use super::filmed::{all_filmed, by_camera};
use super::glass;
use super::inputs::{file, level, recordings};
use super::stop::watched;

/// Correct a model by what a camera saw of another liquid: the free surface, and nothing else.
///
/// The last GRU layer, the operators and the energy of the GENERIC step and a gain between the two learn by
/// Adam; decoder and lower layers stay. Energy and entropy keep their laws whatever is learnt.
///
/// The last recording is held out (of a single one its last three tenths). The candidate that forecasts it best, 0.25 s
/// ahead under the tracked motion, is kept: the estimate itself follows the heights of any liquid. A candidate that has become worse on
/// the source liquid by more than --forgetting is refused.
///
/// Recordings of the simulator are seen through the simulated camera; learning uses no truth that they may hold. A
/// camera's own recordings (.mcap, .bag, .db3, or a folder with frames.csv) are read as `run --source replay` reads
/// them, with --setup for the position of the camera. One correction is of one kind.
#[derive(clap::Args, Debug)]
#[command(
    after_help = "Examples:\n  meniscus correct --recordings one.mcap two.mcap --setup glass.toml --out mine.blob\n  meniscus simulate --liquid water --motion strokes:1 --motion strokes:2 --seconds 4 --out water\n  meniscus correct --recordings water --out water.blob"
)]
pub(crate) struct Arguments {
    /// The model to correct: the one in the program (shipped) or a blob file.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE")]
    model: String,
    /// Recordings of the new liquid: files, or a folder, which stands for all of its *.safetensors; or a camera's.
    #[arg(long, required = true, num_args = 1.., value_name = "DIR_OR_FILES")]
    recordings: Vec<PathBuf>,
    /// The glass and the position of the camera, as `meniscus setup` has written them, for a camera's recordings.
    #[arg(long, value_name = "FILE.toml")]
    setup: Option<PathBuf>,
    /// Recordings of the model's own liquid, to guard against forgetting; by default the one in the program.
    #[arg(long, num_args = 1.., value_name = "DIR_OR_FILES")]
    source: Vec<PathBuf>,
    /// Where the corrected blob goes; it is written whole or not at all.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Steps of Adam.
    #[arg(long, default_value_t = 300)]
    steps: usize,
    /// By how much the slosh-relative error on the source recordings may grow (0.05 = 5 percentage points).
    #[arg(long, default_value_t = 0.05)]
    forgetting: f64,
    /// Noise of the camera's disparity, pixels rms (0.08 is a D435, 0.24 makes 2 mm of depth at 0.4 m).
    #[arg(long, default_value_t = 0.08)]
    noise_px: f64,
    /// Seed of everything that is drawn.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The report as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// Refuses arguments that are out of range.
fn within_range(arguments: &Arguments) -> anyhow::Result<()> {
    ensure!(
        (0.0..=10.0).contains(&arguments.forgetting),
        "--forgetting {} is out of range: 0 to 10",
        arguments.forgetting
    );
    ensure!(
        (1..=100_000).contains(&arguments.steps),
        "--steps {} is out of range: 1 to 100000",
        arguments.steps
    );
    ensure!(
        (0.0..=5.0).contains(&arguments.noise_px),
        "--noise-px {} is out of range: 0 to 5",
        arguments.noise_px
    );
    Ok(())
}

/// Returns the profiles that the simulated camera sees of `all`, with seeds from `first` on.
fn looks(arguments: &Arguments, all: &[Recording], first: u64) -> anyhow::Result<Vec<Sightings>> {
    let seen = |(k, recording): (u64, &Recording)| {
        let scene = SceneSettings {
            disparity_rms_px: arguments.noise_px,
            seed: arguments.seed + first + k,
            ..SceneSettings::of(&recording.glass)
        };
        Ok(sightings(recording, scene)?)
    };
    (0..).zip(all).map(seen).collect()
}

/// New liquid: its name, and its profiles by recording.
struct NewLiquid {
    name: String,
    seen: Vec<Sightings>,
}

/// Reads the recordings of the new liquid, those of a camera or those of the simulator.
fn new_liquid(arguments: &Arguments, header: &Header) -> anyhow::Result<NewLiquid> {
    if all_filmed(&arguments.recordings)? {
        // Nobody says which liquid stood before the camera: the file's name does.
        let name = arguments.recordings.first().and_then(|path| path.file_stem()).unwrap_or_default();
        let name = name.to_string_lossy().into_owned();
        let setup = arguments.setup.as_deref();
        let outline = glass::outline(setup)?;
        let look = |path: &PathBuf| {
            by_camera(path, outline, |camera| glass::settings(setup, header, camera.optics()))
        };
        let seen = arguments.recordings.iter().map(look).collect::<anyhow::Result<Vec<_>>>()?;
        return Ok(NewLiquid { name, seen });
    }
    ensure!(arguments.setup.is_none(), "--setup is for a camera's recordings, and these are the simulator's");
    let new = recordings(&arguments.recordings, "", level)?;
    let name = new.first().map_or(String::new(), |recording| recording.provenance.liquid.clone());
    Ok(NewLiquid { name, seen: looks(arguments, &new, 0)? })
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    within_range(arguments)?;
    let stop = watched()?;
    let bytes = file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let source = if arguments.source.is_empty() {
        vec![Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?]
    } else {
        recordings(&arguments.source, "", level)?
    };
    let NewLiquid { name, seen } = new_liquid(arguments, &model.header)?;
    let parameters = CorrectionParameters {
        steps: arguments.steps,
        forgetting: arguments.forgetting,
        ..CorrectionParameters::default()
    };
    let how = Correction {
        seed: arguments.seed,
        parameters,
        liquid: format!("{name} from {}", model.header.liquid),
        command: format!("meniscus correct --steps {} --seed {}", arguments.steps, arguments.seed),
        quiet: arguments.json,
    };
    let corrected = correct(&bytes, &seen, &looks(arguments, &source, 1000)?, &how, stop)?;
    write_whole(&arguments.out, &corrected.blob)?;
    let percent = |x: f64| 100.0 * x;
    let [held, source] = [corrected.held, corrected.source].map(|pair| pair.map(percent));
    let checks = [
        Check::informational("held_before_foretold", held[0], "%"),
        Check::at_most("held_after_foretold", held[1], "%", held[0]),
        Check::informational("source_before_slosh", source[0], "%"),
        Check::at_most("source_after_slosh", source[1], "%", source[0] + percent(arguments.forgetting)),
        Check::informational("refused_for_forgetting", corrected.refused as f64, "1"),
    ];
    if arguments.json {
        println!(
            "{:#}",
            serde_json::json!({
                "blob": arguments.out,
                "checks": checks,
                "looks": corrected.looks,
                "parameters": how.parameters,
            })
        );
        return Ok(());
    }
    print!("{}", table(&checks));
    println!("{}: {} bytes", arguments.out.display(), corrected.blob.len());
    Ok(())
}
