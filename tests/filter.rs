//! The filter on the shipped model and its unseen recording: with and without any knowledge of how the glass moves, with
//! points that are far off, on a liquid that the model does not know.

use meniscus::blob::Model;
use meniscus::runtime::{InputSource, Mode};
use meniscus::surface::{POINTS, SurfaceProfile};
use meniscus_data::recording::{GROUP_NAMES, Recording};
use meniscus_platform::files::AlignedBytes;
use meniscus_score::baseline::linear_with_motion;
use meniscus_score::score::score;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::{DISPARITY_RMS_PX, perfect, sightings, turns_with};
use meniscus_virtual::render::SceneSettings;
use std::path::Path;

/// The shipped recording, which the shipped model has never seen.
fn shipped() -> Recording {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors"));
    Recording::load(path).expect("the shipped recording is good")
}

/// Returns the profiles that the simulated camera sees of it.
fn filmed(recording: &Recording) -> Vec<Option<SurfaceProfile>> {
    let scene =
        SceneSettings { disparity_rms_px: DISPARITY_RMS_PX, seed: 3, ..SceneSettings::of(&recording.glass) };
    sightings(recording, scene).expect("the glass can be seen")
}

#[test]
fn without_the_motion_the_heights_alone_tell_the_liquid() {
    let recording = shipped();
    let seen = filmed(&recording);
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let linear = linear_with_motion(&recording);
    let with = |drive: InputSource, seen: &[Option<SurfaceProfile>]| {
        let turns = turns_with(&model, seen, |_| drive, |_, _, _| {});
        for logged in &turns {
            let estimate = &logged.turn.estimate;
            assert!(estimate.audit.heat >= 0.0 && estimate.audit.energy_residual.abs() < 1e-9);
        }
        let tracked = turns.iter().filter(|t| t.turn.estimate.mode == Mode::Tracking).count();
        let score = score(&model, &recording, &linear, &turns, START);
        println!(
            "{drive:?}: {tracked} tracked, surface {:.2} % of the slosh, held {:.1} %",
            100.0 * score.estimate.slosh_rel(),
            100.0 * score.held.share()
        );
        for ((name, error), held) in GROUP_NAMES.iter().zip(score.field).zip(&score.field_held) {
            println!("  {name}: {:.2} %, held {:.1} %", 100.0 * error, 100.0 * held.share());
        }
        score
    };
    let tracked = with(InputSource::Tracked, &seen);
    let blind = with(InputSource::Unobserved, &seen);
    // The next frame tells the acceleration that sigma follows at once.
    println!("sigma: {:.3}, a frame late {:.3}", tracked.field[3], tracked.late_sigma);
    assert!(tracked.late_sigma < 0.6 * tracked.field[3], "{} {}", tracked.late_sigma, tracked.field[3]);
    // 15 and 20 % are asked for; the glass's own track is better still, or this would not be blind.
    assert!(blind.estimate.slosh_rel() <= 0.15, "{}", blind.estimate.slosh_rel());
    assert!(blind.field[1] <= 0.2 && blind.field[1] > tracked.field[1], "{:?}", blind.field);
    // A camera that loses the sides of the glass on the way comes to the same.
    let mut lost = seen.clone();
    lost.iter_mut().flatten().skip(120).for_each(|profile| profile.glass_x_m = None);
    let lost = with(InputSource::Tracked, &lost);
    assert!(lost.estimate.slosh_rel() <= 0.15 && lost.field[1] <= 0.2, "{:?}", lost.field);
}

/// Slosh-relative error of the estimate behind the first second, and the share of the heights within their interval.
fn followed(
    model: &Model<'_>,
    seen: &[Option<SurfaceProfile>],
    truth: impl Fn(usize) -> [f32; POINTS],
) -> (f64, f64) {
    let rest = model.header.fill_m as f32;
    let (mut miss, mut size, mut held, mut all) = (0.0, 0.0, 0.0, 0.0);
    turns_with(
        model,
        seen,
        |_| InputSource::Tracked,
        |frame, _, estimate| {
            if frame < 60 {
                return;
            }
            let points = truth(frame).into_iter().zip(estimate.surface_m).zip(estimate.interval.surface_m);
            for ((z, said), half) in points {
                miss += f64::from(z - said).powi(2);
                size += f64::from(z - rest).powi(2);
                held += f64::from(u8::from((z - said).abs() <= half));
                all += 1.0;
            }
        },
    );
    ((miss / size).sqrt(), held / all)
}

#[test]
fn a_point_that_is_far_off_moves_little() {
    let recording = shipped();
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let truth = |frame: usize| recording.profile(frame).try_into().expect("21 heights");
    let clean = perfect(&recording);
    let (fair, _) = followed(&model, &clean, truth);
    // One point of fifty a centimetre off, and the sides of the glass taken for something else in every hundredth frame.
    let mut off = clean.clone();
    for (frame, profile) in off.iter_mut().enumerate() {
        let profile = profile.as_mut().expect("a profile");
        for (point, height) in profile.height_m.iter_mut().enumerate() {
            if (7 * frame + 13 * point) % 50 == 0 {
                *height += if frame % 2 == 0 { 0.01 } else { -0.01 };
            }
        }
        if frame % 100 == 50 {
            profile.glass_x_m = profile.glass_x_m.map(|x| x + 0.02);
        }
    }
    let (error, _) = followed(&model, &off, truth);
    println!("slosh-rel {:.2} %, with outliers {:.2} %", 100.0 * fair, 100.0 * error);
    assert!(fair < 0.05 && error < 0.08, "{fair} {error}");
}

/// The same surfaces, played faster by a sixth: no liquid of this viscosity in this glass sloshes so.
#[test]
fn a_liquid_that_the_model_does_not_know_is_followed() {
    let recording = shipped();
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let frames = recording.frames() * 6 / 7 - 1;
    let at = |frame: usize| (frame * 7 / 6, (frame * 7 % 6) as f32 / 6.0);
    let played = |frame: usize| -> [f32; POINTS] {
        let (n, part) = at(frame);
        let (now, next) = (recording.profile(n), recording.profile(n + 1));
        std::array::from_fn(|point| (1.0 - part) * now[point] + part * next[point])
    };
    let seen: Vec<_> = perfect(&recording)
        .into_iter()
        .take(frames)
        .enumerate()
        .map(|(frame, profile)| {
            let (n, part) = at(frame);
            let x = &recording.glass_x_m;
            let place = (1.0 - f64::from(part)) * x[n] + f64::from(part) * x[n + 1];
            profile.map(|p| SurfaceProfile { height_m: played(frame), glass_x_m: Some(place as f32), ..p })
        })
        .collect();
    let (error, held) = followed(&model, &seen, played);
    println!("slosh-rel {:.2} %, {:.0} % of the heights within their interval", 100.0 * error, 100.0 * held);
    assert!(error < 0.1, "{error}");
    assert!(held > 0.75, "{held}");
}

/// The same glass pushed across its line too, three times: what then rises and falls at the camera is taken for what it is,
/// and heats the liquid no further. Taken for the wave that the model knows, it would be heat: 0.065 J for 0.038.
#[test]
fn a_glass_that_leaves_its_line_is_followed() {
    let recording = shipped();
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let mode = model.cross_axis;
    let straight = perfect(&recording);
    let (mut seen, mut y) = (straight.clone(), [0.0_f64; 2]);
    let mut tops = Vec::new();
    for (frame, profile) in seen.iter_mut().enumerate() {
        let push = if frame % 150 > 90 && frame % 150 < 105 { 0.15 * mode.kick_m } else { 0.0 };
        y = mode.next(y);
        y[0] += push;
        mode.add_to(&mut profile.as_mut().expect("a profile").height_m, y[0]);
        tops.push(y[0]);
    }
    let highest = tops.iter().copied().fold(0.0, f64::max);
    assert!(highest > 1e-3 && highest < 2.5e-3, "{highest}");
    let heat = |seen: &[Option<SurfaceProfile>]| {
        let turns = turns_with(&model, seen, |_| InputSource::Tracked, |_, _, _| {});
        turns.last().map_or(f64::NAN, |logged| logged.turn.estimate.heat_j)
    };
    let (due, found) = (heat(&straight), heat(&seen));
    let truth = |frame: usize| seen[frame].expect("a profile").height_m;
    let (error, held) = followed(&model, &seen, truth);
    println!(
        "{:.1} mm across: slosh-rel {:.2} %, held {:.0} %, heat {:.4} J for {due:.4}",
        1e3 * highest,
        100.0 * error,
        100.0 * held,
        found
    );
    assert!(error < 0.05, "{error}");
    assert!((found / due - 1.0).abs() < 0.1, "{found} J for {due}");
}

#[test]
fn a_height_that_is_no_number_is_refused_and_forgotten() {
    let mut seen = perfect(&shipped());
    seen[100].as_mut().expect("a profile").height_m[3] = f32::NAN;
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let mut refused = 0;
    let turns = turns_with(
        &model,
        &seen,
        |_| InputSource::Unobserved,
        |_, memory, _| refused = memory.health.measurement_refused,
    );
    let mode = |frame: usize| turns[frame].turn.estimate.mode;
    assert_eq!((mode(99), mode(100), mode(101)), (Mode::Tracking, Mode::Coasting, Mode::Tracking));
    assert_eq!(refused, 1);
    assert!(turns.iter().all(|t| t.turn.estimate.latent.iter().all(|x| x.is_finite())));
}

/// An IMU whose offset has carried the glass metres away by the time it falls silent: from then on the edges of the
/// glass tell, and nothing is left of the commanded position.
#[test]
fn a_motion_that_is_commanded_no_more_leaves_nothing_behind() {
    let recording = shipped();
    let seen = filmed(&recording);
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let surfaces = |drive: &dyn Fn(usize) -> InputSource| -> Vec<[f32; POINTS]> {
        let turns = turns_with(&model, &seen, drive, |_, _, _| {});
        turns.iter().map(|logged| logged.turn.estimate.surface_m).collect()
    };
    let a = |n: usize| recording.acceleration_m_s2[n] + 0.3;
    let commanded = |n: usize| InputSource::Measured { before: a(n.saturating_sub(1)), now: a(n) };
    let tracked = surfaces(&|_| InputSource::Tracked);
    let switched = surfaces(&|n| if n < 240 { commanded(n) } else { InputSource::Tracked });
    let apart = |frames: std::ops::Range<usize>| {
        let pairs = tracked[frames.clone()].iter().flatten().zip(switched[frames].iter().flatten());
        1e3 * pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f32::max)
    };
    let (commanded, behind, later) = (apart(60..240), apart(240..300), apart(300..600));
    println!(
        "heights at most apart: commanded {commanded} mm, in the second behind it {behind} mm, later {later} mm"
    );
    assert!(commanded > 0.1 && behind < 0.3 && later < 0.01);
}
