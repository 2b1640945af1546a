//! A colour webcam without depth, rendered and in virtual time: through the session of `meniscus-webcam`, the reader and
//! the estimator, against the recording that was rendered.

mod pictures;
mod reading;
mod rendered;
mod setup;

use meniscus::blob::Model;
use meniscus::runtime::{Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface::Settings;
use meniscus::usb::uvc::Stream;
use meniscus_platform::clock::NoClock;
use meniscus_platform::files::AlignedBytes;
use meniscus_usb::camera::Note;
use meniscus_webcam::PixelFormat;
use reading::{config_of, connect, errors, lens_of, read, stream};
use rendered::{FIRST_US, RECORDED_HZ, Rendered, SHOWN, Troubles, USUAL, mode, recording};
use setup::SAID;
use std::time::Duration;

#[test]
fn the_surface_is_read_without_depth() {
    for (mode, focal_px, payloads) in [
        (USUAL, 610.0, SHOWN / 2),
        (mode(PixelFormat::Yuyv, [640, 480], 60), 610.0, SHOWN),
        (mode(PixelFormat::Mjpg, [1280, 720], 30), 930.0, SHOWN / 2),
        (mode(PixelFormat::Mjpg, [640, 480], 30), 500.0, SHOWN / 2),
    ] {
        let place = Settings::default();
        let mut session = connect(Rendered::new(mode, focal_px, place, Troubles::default()));
        assert_eq!(session.webcam().mode, mode);
        let lens = lens_of(mode, focal_px);
        let seen = read(&mut session, lens, config_of(lens, place), payloads);
        assert_eq!((seen.observations.len(), seen.losses.frames()), (payloads, 0));
        assert!(seen.notes.is_empty(), "{:?}", seen.notes);
        let errors = errors(&seen.observations);
        println!("{mode}, {focal_px} px: {errors:.3?}");
        assert!(errors.heights_rms_mm < 0.25 && errors.points > 0.97, "{mode}: {errors:?}");
        assert!(errors.track_rms_mm < 0.05 && errors.inside > 0.9, "{mode}: {errors:?}");
    }
}

#[test]
fn what_the_driver_loses_is_counted() {
    let troubles = Troubles { lost: vec![20, 50, 51, 52], damaged: vec![90, 91], ..Troubles::default() };
    let place = Settings::default();
    let mut session = connect(Rendered::new(USUAL, 610.0, place, troubles));
    let lens = lens_of(USUAL, 610.0);
    let seen = read(&mut session, lens, config_of(lens, place), 146);
    // 150 frames from the first to the last: four never came, two were damaged.
    assert_eq!(seen.observations.len(), 144);
    assert_eq!((seen.losses.counter_gap, seen.losses.error_bit, seen.losses.frames()), (4, 2, 6));
    assert_eq!(seen.observations.last().map(|last| last.stamp.sequence), Some(149));
    assert!(errors(&seen.observations).heights_rms_mm < 0.25);
}

#[test]
fn a_camera_that_is_unplugged_comes_back() {
    let troubles = Troubles { unplugged: Some((60, Duration::from_secs(4))), ..Troubles::default() };
    let place = Settings::default();
    let mut session = connect(Rendered::new(USUAL, 610.0, place, troubles));
    let lens = lens_of(USUAL, 610.0);
    let seen = read(&mut session, lens, config_of(lens, place), 150);
    assert_eq!(seen.observations.len(), 150);
    let notes: Vec<String> = seen.notes.iter().map(Note::to_string).collect();
    assert_eq!(notes.first().map(String::as_str), Some("the camera has left the bus: Replug"), "{notes:?}");
    assert!(
        notes[1].contains("there is no /dev/video7") && notes[1].contains("/dev/v4l/by-id/"),
        "{notes:?}"
    );
    assert_eq!(notes.last().map(String::as_str), Some("the camera is back"), "{notes:?}");
    assert!((3..=6).contains(&session.health().rungs.iter().sum::<u64>()), "{:?}", session.health());
}

#[test]
fn another_camera_in_its_place_is_not_taken() {
    let unplugged = Some((60, Duration::from_secs(1)));
    let troubles = Troubles { unplugged, replaced: true, ..Troubles::default() };
    let mut session = connect(Rendered::new(USUAL, 610.0, Settings::default(), troubles));
    let (notes, ended) = stream(&mut session, 150, |_| ());
    let notes: Vec<String> = notes.iter().map(Note::to_string).collect();
    assert!(
        notes.iter().any(|note| note.contains("is now a Another Webcam, and was a Rendered Webcam")),
        "{notes:?}"
    );
    let ended = ended.expect_err("it gives up").to_string();
    assert!(ended.contains("no frames for 60 s") && ended.contains("Another Webcam"), "{ended}");
}

#[test]
fn a_rate_that_falls_in_the_dark_is_said_as_such() {
    let troubles = Troubles { dark_from: Some(100), ..Troubles::default() };
    let mut session = connect(Rendered::new(USUAL, 610.0, Settings::default(), troubles));
    let (notes, ended) = stream(&mut session, 200, |_| ());
    ended.expect("frames came");
    let notes: Vec<String> = notes.iter().map(Note::to_string).collect();
    assert_eq!(notes.len(), 1, "{notes:?}");
    for word in ["of 30 images a second", "in the dark", "exposure_dynamic_framerate=0", "/dev/video7"] {
        assert!(notes[0].contains(word), "{word}: {notes:?}");
    }
}

/// Slosh-relative error of the estimated surface over the turns behind the window, with a frame or without.
fn estimated(hz: u32) -> (f64, u64) {
    let mode = mode(PixelFormat::Yuyv, [640, 480], hz);
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let (place, lens) = (Settings::default(), lens_of(mode, 610.0));
    let mut session = connect(Rendered::new(mode, 610.0, place, Troubles::default()));
    let (mut colour, mut grey) =
        (vec![0; lens.rectifier().colour_bytes()], vec![0; lens.rectifier().grey_bytes()]);
    let sensor = ProfileSensor::of_outline(config_of(lens, place), lens.rectifier(), &mut colour, &mut grey);
    let mut tracker = Tracker::new(Estimator::new(&model), sensor);
    let (mut squares, mut slosh, truth) = (0.0, 0.0, recording());
    let first_us = FIRST_US % (1 << 32);
    let (_, ended) = stream(&mut session, SHOWN * hz as usize / RECORDED_HZ as usize, |payload| {
        tracker.accept(Stream::Outline, payload, InputSource::tracked, &mut NoClock, &mut [], |turn, _| {
            let since_s = turn.time.0.saturating_sub(first_us) as f64 * 1e-6;
            let frame = (since_s * f64::from(RECORDED_HZ)).round() as usize;
            if frame >= 60 {
                for (z, truth) in turn.estimate.surface_m.iter().zip(truth.profile(frame)) {
                    squares += f64::from(z - truth).powi(2);
                    slosh += (f64::from(*truth) - truth_fill()).powi(2);
                }
            }
        });
    });
    ended.expect("no trouble");
    ((squares / slosh).sqrt(), tracker.memory.health.frames_missing)
}

fn truth_fill() -> f64 {
    1e-3 * SAID.fill_mm
}

#[test]
fn the_estimator_follows_a_webcam() {
    for (hz, most) in [(60, 0.10), (30, 0.20)] {
        let (error, missing) = estimated(hz);
        println!("{hz} Hz: slosh-relative error {:.1} %, {missing} turns without a frame", 100.0 * error);
        assert!(error < most, "{hz} Hz: {error}");
        assert_eq!(missing > 0, hz == 30);
    }
}
