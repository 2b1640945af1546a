//! The picture of a run, from its log, its still and the truth.

use meniscus::host::live::{Log, Still};
use meniscus::host::view::picture::{CameraImage, Curve, Picture, Slice};
use meniscus::host::view::plot::PictureError;
use meniscus::model::Model;
use meniscus::offline::camera::START;
use meniscus::offline::recording::{LAYERS, Lattice, Recording, STATE, TRACERS, group_range};
use meniscus::offline::repeat::frame_shown;
use meniscus::offline::score::{Score, field_of, frame_of};
use meniscus::surface::{Config, profile_abscissa};

/// Half the thickness of the slice through the middle of the glass, in units of the radius.
const SLICE: f64 = 0.12;

/// Pixels around the glass that the camera panel shows.
const MARGIN: usize = 24;

/// Draws the highest crest of the run as PNG bytes; `None` for a run that never tracked.
///
/// # Errors
/// [`PictureError`].
pub(super) fn picture(
    model: &Model<'_>,
    recording: &Recording,
    config: &Config,
    log: &Log,
    score: &Score,
    still: &Still,
) -> Result<Option<Vec<u8>>, PictureError> {
    let Some(turn) = still.turn else { return Ok(None) };
    // Behind the recording's end it has begun again (`--view`).
    let frame = frame_shown(recording, frame_of(turn.time, START) as u64);
    let (mut estimate, mut truth) = (vec![0.0; STATE], vec![0.0; STATE]);
    field_of(model, &turn.estimate, &mut estimate);
    recording.state(frame, &mut truth);
    let lattice = Lattice::new(&recording.glass);

    let [own, linear] = &score.curves;
    let errors = vec![
        Curve { name: "meniscus".into(), points: own.clone() },
        Curve { name: "linear model with the true motion, fitted in place".into(), points: linear.clone() },
    ];
    let seconds = turn.time.since(START) as f64 * 1e-6;
    let picture = Picture {
        title: format!(
            "{} at {seconds:.2} s, the highest crest of {} turns: surface off by {:.1} % of the slosh over the run",
            recording.provenance.liquid,
            log.turns.len(),
            100.0 * score.estimate.slosh_rel()
        ),
        camera: camera(config, recording, still, frame),
        slices: vec![
            ("estimated".into(), slice(&lattice, recording, &estimate)),
            ("true".into(), slice(&lattice, recording, &truth)),
        ],
        value: "speed, m/s".into(),
        errors,
        glass_mm: (1e3 * recording.glass.radius_m, 1e3 * recording.glass.rim_m),
    };
    picture.png().map(Some)
}

/// The camera's image with both profiles on it.
fn camera<'s>(config: &Config, recording: &Recording, still: &'s Still, frame: usize) -> CameraImage<'s> {
    let pixel = |point: usize, height: f32, glass_x: f32| {
        let [x, y, z] = config.wall_point(profile_abscissa(point) as f32, height);
        config.pixel_of([x + glass_x, y, z])
    };
    let turn = still.turn.as_ref();
    let seen = turn.and_then(|turn| turn.sight.and_then(Result::ok));
    let glass_x = seen.and_then(|profile| profile.glass_x_m).unwrap_or(recording.glass_x_m[frame] as f32);
    let measured = seen.map_or(vec![], |profile| {
        let points = profile.height_m.iter().zip(profile.valid).enumerate();
        points.filter(|(_, (_, valid))| *valid).map(|(k, (z, _))| pixel(k, *z, glass_x)).collect()
    });
    let estimated = turn.map_or(vec![], |turn| {
        turn.estimate.surface_m.iter().enumerate().map(|(k, z)| pixel(k, *z, glass_x)).collect()
    });
    let size = config.image_size();
    let glass = &recording.glass;
    let (radius, rim) = (glass.radius_m as f32, glass.rim_m as f32);
    let (left, top) = config.pixel_of([glass_x - radius, -radius, rim]);
    let (right, bottom) = config.pixel_of([glass_x + radius, -radius, 0.0]);
    let inside = |at: f32, most: usize| (at.max(0.0) as usize).min(most);
    let (left, top) =
        (inside(left, size.0).saturating_sub(MARGIN), inside(top, size.1).saturating_sub(MARGIN));
    let (right, bottom) = (inside(right, size.0) + MARGIN, inside(bottom, size.1) + MARGIN);
    let crop = (left, top, right.min(size.0) - left, bottom.min(size.1) - top);
    CameraImage { infrared: &still.infrared, size, measured, estimated, crop }
}

/// Tracers near the plane y = 0, coloured by speed.
fn slice(lattice: &Lattice, recording: &Recording, state: &[f32]) -> Slice {
    let (q, v) = (&state[group_range(0)], &state[group_range(1)]);
    let near = |tracer: &usize| lattice.columns[tracer / LAYERS][1].abs() < SLICE * recording.glass.radius_m;
    let tracers = (0..TRACERS).filter(near).map(|tracer| {
        let speed = v[3 * tracer..3 * tracer + 3].iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        (1e3 * f64::from(q[3 * tracer]), 1e3 * f64::from(q[3 * tracer + 2]), speed)
    });
    Slice { tracers: tracers.collect() }
}
