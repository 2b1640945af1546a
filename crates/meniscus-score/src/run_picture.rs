//! Picture of a run: its highest crest, estimated and true, and the errors over time.

use crate::run_report::TruthReport;
use crate::score::field_of;
use meniscus::blob::Model;
use meniscus::surface::Config;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::recording::frame_of;
use meniscus_data::recording::{Lattice, Recording, STATE};
use meniscus_data::validity::Validity;
use meniscus_report::plot::PictureError;
use meniscus_service::live::CrestImage;
use meniscus_ui::figure_parts::{camera, slice};
use meniscus_ui::picture::{Curve, Picture};
use meniscus_virtual::camera::START;
use meniscus_virtual::looped_recording::frame_shown;

/// Draws the highest crest of a run as PNG bytes; `None` for a run that never saw the liquid.
///
/// # Errors
/// [`PictureError`].
pub fn picture(
    model: &Model<'_>,
    recording: &Recording,
    config: &Config,
    report: &TruthReport<'_>,
    crest: &CrestImage,
) -> Result<Option<Vec<u8>>, PictureError> {
    let Some(turn) = crest.turn else { return Ok(None) };
    let score = &report.score;
    // Behind the recording's end it has begun again (`--view`).
    let frame = frame_shown(recording, frame_of(turn.time, START) as u64);
    let (mut estimate, mut truth) = (vec![0.0; STATE], vec![0.0; STATE]);
    field_of(model, &turn.estimate, &mut estimate);
    recording.state(frame, &mut truth);
    let validity = Validity::of(&model.header);
    let lattice = Lattice::new(&recording.glass);

    let [own, linear] = &score.curves;
    let errors = vec![
        Curve { name: "meniscus".into(), points: own.clone() },
        Curve { name: "linear model with the true motion, fitted in place".into(), points: linear.clone() },
    ];
    let seconds = turn.time.since(START) as f64 * 1e-6;
    let picture = Picture {
        title: format!(
            "The estimate of {} beside the truth, at the highest crest of {} turns ({seconds:.2} s). Error of the surface: {:.1} % relative to the slosh",
            recording.provenance.liquid,
            report.turns(),
            100.0 * score.estimate.slosh_rel()
        ),
        camera: camera(config, recording, &crest.outline, &turn, frame),
        slices: vec![
            ("estimated".into(), slice(&lattice, recording, validity.known, &estimate)),
            ("true".into(), slice(&lattice, recording, recording.known, &truth)),
        ],
        value: "speed, m/s".into(),
        unknown: validity.sentence,
        top: None,
        // The curves end with the first pass of the recording.
        now_s: Some(seconds).filter(|now| *now < recording.frames() as f64 * FRAME_INTERVAL_S),
        errors,
        glass_mm: (1e3 * recording.glass.radius_m, 1e3 * recording.glass.rim_m),
        letters: 1.0,
    };
    picture.png().map(Some)
}
