//! `meniscus run` before a recording of the simulator: a rendered camera, and the truth beside the estimate.

use super::BUFFERS;
use super::config::{Output, RunConfig, RunEnd};
use super::live::{Played, ReadyCamera, live};
use super::motion_source::MotionSource;
use super::motion_tag::TagMotion;
use super::printed::{announce, print};
use super::source::RecordingSource;
use crate::glass;
use anyhow::{Context, bail};
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_platform::files::write_whole;
use meniscus_report::checks::Check;
use meniscus_score::forecasts::KeptMemories;
use meniscus_score::run_picture::picture;
use meniscus_score::run_report::TruthReport;
use meniscus_service::ledger::SpanEnd;
use meniscus_service::live::CameraImages;
use meniscus_service::live::Silence;
use meniscus_service::run::RunState;
use meniscus_service::truth::Truth;
use meniscus_usb::link::link;
use meniscus_virtual::camera::{PAYLOAD_ROOM, START, SimulatedCamera};
use meniscus_virtual::looped_recording::BACK;
use meniscus_virtual::render::{SceneSettings, TagPattern, TagPlate};

/// Gap between the rim of the glass and the plate with a tag, m.
const PLATE_GAP_M: f64 = 0.02;
/// Half the height of a plate with its white margin, in widths of the tag.
const PLATE_HALF: f64 = 0.625;
/// Angle by which it leans back, rad: 20 degrees, at which its attitude is certain.
const PLATE_LEAN_RAD: f64 = 0.35;

/// Checks of time, which are informational where the camera waits for the worker.
const OF_TIME: [&str; 4] = ["deadline_misses", "turns_late", "turn_us_median", "turn_us_p99"];

/// Runs with a rendered camera.
pub(super) fn run(
    config: &RunConfig,
    model: &Model<'_>,
    source: &RecordingSource,
    faults: &FaultList,
) -> anyhow::Result<()> {
    let recording = source.load()?;
    let settings = settings(model, &recording)?;
    let reader = Config::new(glass::settings(config.setup.as_deref(), &model.header, settings.optics())?)?;
    let _alone = announce(config)?;
    let scene = SceneSettings {
        camera: settings,
        seed: config.seed,
        tag: plate(config, &settings),
        ..SceneSettings::default()
    };
    let mut camera = SimulatedCamera::new(&recording, scene, faults.clone());
    if config.silence == Silence::WaitOut {
        camera = camera.patient();
    }
    let mut shots = config.frames.min(recording.frames());
    if config.page.is_some() {
        camera = camera.repeating();
        shots = if config.end == RunEnd::WhenStopped { usize::MAX } else { config.frames };
    }
    // The turns of the first round are kept one by one and scored against the truth; the totals have all.
    let frames = shots.min(recording.frames());
    let (camera_end, end) = link(BUFFERS, PAYLOAD_ROOM);
    let mut memories = KeptMemories::with_room(frames);
    let (name, span_end) = ("simulated D435", SpanEnd::LastFrame);
    let truth = config.page.as_ref().map(|_| Truth {
        profiles_m: recording.profile_m.clone(),
        start: START,
        round: recording.frames() + BACK,
        fill_m: recording.glass.fill_m,
    });
    let images = CameraImages::DepthAndOutline;
    let ready = ReadyCamera {
        name,
        reader,
        images,
        rectifier: None,
        frames,
        span_end,
        truth,
        end,
        sink: Some(&mut memories),
    };
    let Played { finished, written, .. } = live(config, model, ready, move |state: &RunState| {
        camera.play(shots, &camera_end, &state.stop);
    })?;

    let mut report = TruthReport::new(model, &recording, &finished.log, &memories)
        .context("the run ended before the first turn: there is nothing to report")?;
    if config.silence == Silence::WaitOut {
        // The camera waits for the worker: times say what else the machine did.
        let of_time = |check: &&mut Check| OF_TIME.contains(&check.name.as_str());
        report.checks.iter_mut().filter(of_time).for_each(|check| *check = check.without_target());
    }
    let drawn = picture(model, &recording, &reader, &report, &finished.crest)?;
    print(config, &report.json(&config.labels()), &report.text())?;
    if let Some(png) = &drawn {
        let path = config.out.join("run.png");
        write_whole(&path, png)?;
        if config.output == Output::Text {
            println!("picture: {}", path.display());
        }
    }
    written?;
    config.judge(&report.checks)
}

/// Returns the plate with the tag of `--motion`, above the glass: a simulated camera sees what the run looks for.
pub(super) fn plate(config: &RunConfig, settings: &Settings) -> Option<TagPlate> {
    let Some(MotionSource::Tag(tag)) = &config.motion else { return None };
    plate_of(tag, settings.rim_m)
}

/// Returns the plate with the tag that `text`, ID,SIZE_MM, spells, above a glass with the rim at `rim_m`.
///
/// # Errors
/// When it spells no tag.
#[cfg(feature = "desk")]
pub(crate) fn plate_with(text: &str, rim_m: f32) -> anyhow::Result<Option<TagPlate>> {
    Ok(plate_of(&TagMotion::parse(text, [1.0, 0.0, 0.0])?, rim_m))
}

fn plate_of(tag: &TagMotion, rim_m: f32) -> Option<TagPlate> {
    let pattern = TagPattern::of(tag.number)?;
    let height_m = f64::from(rim_m) + PLATE_GAP_M + PLATE_HALF * tag.size_m;
    Some(TagPlate { pattern, size_m: tag.size_m, height_m, lean_rad: PLATE_LEAN_RAD })
}

/// Returns the camera's settings for the model's glass; a recording of another glass is refused.
fn settings(model: &Model<'_>, recording: &Recording) -> anyhow::Result<Settings> {
    let (header, glass) = (&model.header, &recording.glass);
    let pairs = [
        ("radius", header.radius_m, glass.radius_m),
        ("fill", header.fill_m, glass.fill_m),
        ("rim", header.rim_m, glass.rim_m),
    ];
    for (name, model_m, recording_m) in pairs {
        if (model_m - recording_m).abs() > 1e-4 {
            let (model_mm, recording_mm) = (1e3 * model_m, 1e3 * recording_m);
            bail!(
                "the model was trained for a glass with {name} {model_mm:.1} mm, the recording has \
                 {recording_mm:.1} mm: train a model for this glass, or choose another recording"
            );
        }
    }
    if model.field_len() != meniscus_data::recording::STATE {
        bail!("the model has {} tracers, recordings have 2134", model.header.particles);
    }
    Ok(Settings::for_glass(header.radius_m, header.fill_m, header.rim_m))
}
