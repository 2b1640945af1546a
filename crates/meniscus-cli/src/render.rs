//! `meniscus render`: a recording as a film and a picture.

use super::inputs;
use super::outputs::check_folder;
use anyhow::{Context, ensure};
use meniscus::blob::Model;
use meniscus::surface::Settings;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::Recording;
use meniscus_platform::files::write_whole;
use meniscus_score::film::{Film, Reel, SIZE, animation, still};
use meniscus_virtual::render::SceneSettings;
use std::path::{Path, PathBuf};

/// Frames of a recording a second.
const RATE: u16 = 60;

/// Draw a recording as a film: camera, estimate, truth and error.
///
/// The recording is seen through the simulated camera with its noise. The --out folder gets film.png, an animated PNG that any
/// browser plays, and crest.png, its liveliest moment. --corrected puts a second model beside the first.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  meniscus render\n  meniscus render beer/strokes-1401.safetensors \\\n    --corrected beer.blob --out beer-film"
)]
pub(crate) struct Arguments {
    /// Recording of `meniscus simulate`, or the one in the program (shipped).
    #[arg(default_value = "shipped", value_name = "shipped|RECORDING")]
    recording: String,
    /// The model: the one in the program (shipped) or a blob.
    #[arg(long, default_value = "shipped", value_name = "shipped|FILE", help_heading = "Input")]
    model: String,
    /// Second model beside it, as `meniscus correct` makes it.
    #[arg(long, value_name = "FILE", help_heading = "Input")]
    corrected: Option<PathBuf>,
    /// Length of the film from the beginning, s [default: all].
    #[arg(long, value_name = "SECONDS", help_heading = "Film")]
    seconds: Option<f64>,
    /// Frames of the film a second: a divisor of 60.
    #[arg(
        long,
        default_value_t = 20,
        value_parser = clap::value_parser!(u16).range(1..=60),
        help_heading = "Film"
    )]
    rate: u16,
    /// Width of the film, pixels, 300 to 1200; a narrow one has a tenth of the bytes.
    #[arg(
        long,
        default_value_t = SIZE.0,
        value_name = "PIXELS",
        value_parser = clap::value_parser!(u32).range(300..=1200),
        help_heading = "Film"
    )]
    width: u32,
    /// Folder for the files; it is made.
    #[arg(long, default_value = "out", value_name = "DIR", help_heading = "Output")]
    out: PathBuf,
}

/// Runs the verb.
pub(crate) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let rate = arguments.rate;
    ensure!(
        RATE.is_multiple_of(rate),
        "--rate {rate} is no whole part of {RATE}: take 10, 12, 15, 20, 30 or 60"
    );
    let recording = match arguments.recording.as_str() {
        "shipped" => Recording::from_bytes(Path::new("the shipped recording"), meniscus_shipped::RECORDING)?,
        file => inputs::recording(Path::new(file))?,
    };
    inputs::check_level(&recording, &arguments.recording)?;
    check_folder(&arguments.out)?;
    let bytes = inputs::file(&arguments.model)?;
    let model = Model::load(&bytes).with_context(|| format!("the model {} is refused", arguments.model))?;
    let corrected = arguments.corrected.as_ref().map(|path| path.display().to_string());
    let other = corrected.as_deref().map(inputs::file).transpose()?;
    let other = other
        .as_ref()
        .map(|bytes| Model::load(bytes))
        .transpose()
        .context("the corrected model is refused")?;
    let mut models = vec![(if other.is_some() { "before" } else { "estimated" }, &model)];
    models.extend(other.as_ref().map(|model| ("after", model)));
    for (name, model) in &models {
        let (glass, header) = (&recording.glass, &model.header);
        let same = [(glass.radius_m, header.radius_m), (glass.fill_m, header.fill_m)];
        ensure!(
            same.iter().all(|(a, b)| (a - b).abs() < 1e-4),
            "the model {name} was trained for a glass of {:.1} mm radius filled to {:.1} mm, the recording has {:.1} and {:.1} mm",
            1e3 * header.radius_m,
            1e3 * header.fill_m,
            1e3 * glass.radius_m,
            1e3 * glass.fill_m
        );
    }
    let glass = &recording.glass;
    let camera = Settings::for_glass(glass.radius_m, glass.fill_m, glass.rim_m);
    let mut film = Film::new(&recording, SceneSettings { camera, ..SceneSettings::default() }, &models)?;
    let most = arguments.seconds.map_or(usize::MAX, |seconds| (seconds / FRAME_INTERVAL_S) as usize);
    let frames: Vec<usize> = (0..film.frames().min(most)).step_by(usize::from(RATE / rate)).collect();
    ensure!(!frames.is_empty(), "--seconds {:?} leaves no frame", arguments.seconds);

    let bar = crate::bars::bar(frames.len() as u64);
    bar.set_style(crate::bars::style("frames {wide_bar} {pos}/{len}, {left}")?);
    let crest = film.crest();
    let nearest = (0..frames.len()).min_by_key(|&k| frames[k].abs_diff(crest)).unwrap_or(0);
    let reel = Reel { count: frames.len(), rate, width: arguments.width, still: nearest };
    let moving = animation(reel, |k| {
        bar.inc(1);
        film.frame(frames[k], SIZE)
    })?;
    bar.finish_and_clear();
    let crest = still(&film.frame(crest, SIZE)?)?;
    for (name, bytes) in [("film.png", moving), ("crest.png", crest)] {
        let path = arguments.out.join(name);
        write_whole(&path, &bytes)?;
        println!("{}", path.display());
    }
    Ok(())
}
