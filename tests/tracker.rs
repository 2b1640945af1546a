//! The modes of the turn: what an estimate is worth, whatever the camera and the clock do.

#[path = "support/glass.rs"]
mod glass;
mod support;

use glass::Ticks;
use meniscus::blob::Model;
use meniscus::runtime::{COAST_LIMIT, Estimator, InputSource, Mode, ProfileSensor, Tracker, Turn};
use meniscus::surface::{Config, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_hil::{Camera, CameraSettings, Payload, Shot, Source};

/// A camera before a resting glass.
struct Bench {
    camera: Camera,
    images: (Vec<u8>, Vec<u8>),
    /// Number of the next frame.
    frame: u64,
}

impl Bench {
    fn new() -> Self {
        Self { camera: Camera::new(CameraSettings::default()), images: glass::images(), frame: 0 }
    }

    /// The payloads of the next frame.
    fn payloads(&mut self) -> Vec<Payload> {
        let captured_us = 1_000_000 + self.frame * 16_667;
        self.frame += 1;
        self.camera.expose(&Shot::infrared(&self.images.0, &self.images.1, captured_us))
    }
}

/// Hands payloads over and gives the turns they led to.
fn take(
    tracker: &mut Tracker<'_, '_>,
    payloads: &[Payload],
    clock: &mut Ticks,
    field: &mut [f32],
) -> Vec<Turn> {
    let mut turns = Vec::new();
    for payload in payloads {
        let stream = match payload.stream {
            meniscus_hil::Stream::Depth => Stream::Depth,
            meniscus_hil::Stream::Infrared | meniscus_hil::Stream::Colour => Stream::Outline,
        };
        tracker
            .accept(stream, &payload.bytes, InputSource::tracked, clock, field, |turn, _| turns.push(*turn));
    }
    turns
}

/// Runs `test` with a tracker on a random model.
fn with_tracker(test: impl FnOnce(&mut Tracker<'_, '_>, &mut Bench, &mut [f32])) {
    let bytes = support::random_blob(3, 0.1);
    let model = Model::load(&bytes).expect("a sound blob");
    let (mut depth, mut infrared) = (vec![0; 640 * 480 * 2], vec![0; 640 * 480]);
    let sensor =
        ProfileSensor::new(Config::new(Settings::default()).expect("sound"), &mut depth, &mut infrared);
    let mut field = vec![0.0; model.field_len()];
    test(&mut Tracker::new(Estimator::new(&model), sensor), &mut Bench::new(), &mut field);
}

#[test]
fn it_fills_tracks_coasts_halts_and_comes_back() {
    with_tracker(|tracker, bench, field| {
        let mut clock = Ticks::every_us(1);
        assert!(
            tracker.silence(InputSource::tracked, &mut clock, field).is_none(),
            "nothing to predict before the first frame"
        );
        for frame in 1..=20 {
            let turns = take(tracker, &bench.payloads(), &mut clock, field);
            let [turn] = turns.as_slice() else { panic!("one turn a frame, not {}", turns.len()) };
            let expected = if frame < 16 { Mode::Filling } else { Mode::Tracking };
            assert_eq!(turn.estimate.mode, expected, "frame {frame}");
            assert!(turn.estimate.field_fresh);
        }
        for silent in 1..=COAST_LIMIT + 5 {
            bench.frame += 1;
            let turn = tracker.silence(InputSource::tracked, &mut clock, field).expect("a turn in silence");
            let halted = silent > COAST_LIMIT;
            assert_eq!(turn.estimate.mode, if halted { Mode::Halted } else { Mode::Coasting }, "{silent}");
            assert_eq!(turn.estimate.field_fresh, !halted, "a halted estimate is never labelled fresh");
        }
        // Four of the silent turns are in the window already; the rest of it has to be seen.
        for frame in 1..=12 {
            let turns = take(tracker, &bench.payloads(), &mut clock, field);
            let [turn] = turns.as_slice() else { panic!("one turn a frame, not {}", turns.len()) };
            let expected = if frame < 12 { Mode::Halted } else { Mode::Tracking };
            assert_eq!(turn.estimate.mode, expected, "frame {frame} after the gap");
        }
        let health = tracker.memory.health;
        assert_eq!((health.filling, health.tracking), (15, 6));
        assert_eq!((health.coasting, health.halted), (u64::from(COAST_LIMIT), 5 + 11));
        assert_eq!(health.frames_missing, u64::from(COAST_LIMIT) + 5);
    });
}

#[test]
fn missing_frames_are_turns_and_late_frames_are_not() {
    with_tracker(|tracker, bench, field| {
        let mut clock = Ticks::every_us(1);
        for _ in 0..20 {
            take(tracker, &bench.payloads(), &mut clock, field);
        }
        let late = bench.payloads();
        bench.payloads();
        let turns = take(tracker, &bench.payloads(), &mut clock, field);
        let modes: Vec<Mode> = turns.iter().map(|turn| turn.estimate.mode).collect();
        assert_eq!(modes, [Mode::Coasting, Mode::Coasting, Mode::Tracking]);
        assert!(turns.windows(2).all(|pair| pair[1].time.since(pair[0].time).abs_diff(16_667) < 2));
        assert!(take(tracker, &late, &mut clock, field).is_empty(), "its turn has been taken");
        let turns = take(tracker, &bench.payloads(), &mut clock, field);
        assert_eq!(turns.len(), 1, "the next frame is the next turn");
        assert_eq!(turns[0].estimate.mode, Mode::Tracking);
    });
}

/// A frame that comes behind the turn that was taken in silence: no turn of its own, and the next one is that of a frame in time.
#[test]
fn a_late_frame_is_used_from_the_next_turn_on() {
    let after = |late: bool| {
        let mut last = None;
        with_tracker(|tracker, bench, field| {
            let mut clock = Ticks::every_us(1);
            for _ in 0..20 {
                take(tracker, &bench.payloads(), &mut clock, field);
            }
            // Five in a row: more than the tracker takes for late before it follows the time of the camera.
            for _ in 0..5 {
                if late {
                    let turn = tracker.silence(InputSource::tracked, &mut clock, field).expect("a turn");
                    assert_eq!(turn.estimate.mode, Mode::Coasting);
                }
                let turns = take(tracker, &bench.payloads(), &mut clock, field);
                assert_eq!(turns.len(), usize::from(!late));
            }
            let health = tracker.memory.health;
            assert_eq!((health.frames_stale, health.frames_caught_up), if late { (5, 5) } else { (0, 0) });
            assert_eq!((health.turns, health.coasting), if late { (25, 5) } else { (25, 0) });
            let turns = take(tracker, &bench.payloads(), &mut clock, field);
            let [turn] = turns.as_slice() else { panic!("one turn, not {}", turns.len()) };
            assert_eq!(turn.estimate.mode, Mode::Tracking);
            last = Some((turn.time, turn.estimate.latent, turn.estimate.surface_m, turn.estimate.interval));
        });
        last
    };
    assert_eq!(after(true), after(false), "the same state, whether frames came in time or late");
}

/// A frame behind two turns taken in silence belongs to neither the newest nor a future one. The frame behind it, in the same burst, is
/// that of the newest turn.
#[test]
fn of_a_burst_behind_two_turns_the_newest_frame_is_used() {
    with_tracker(|tracker, bench, field| {
        let mut clock = Ticks::every_us(1);
        for _ in 0..20 {
            take(tracker, &bench.payloads(), &mut clock, field);
        }
        for _ in 0..2 {
            tracker.silence(InputSource::tracked, &mut clock, field).expect("a turn");
        }
        let before = tracker.memory.clone();
        assert!(take(tracker, &bench.payloads(), &mut clock, field).is_empty());
        let health = tracker.memory.health;
        assert_eq!((health.frames_stale, health.frames_caught_up), (1, 0));
        assert_eq!(tracker.memory.lateral_m(), before.lateral_m());
        assert_eq!(health.turns, before.health.turns);
        assert!(take(tracker, &bench.payloads(), &mut clock, field).is_empty());
        let health = tracker.memory.health;
        assert_eq!((health.frames_stale, health.frames_caught_up), (2, 1));
        let turns = take(tracker, &bench.payloads(), &mut clock, field);
        assert_eq!((turns.len(), turns[0].estimate.mode), (1, Mode::Tracking));
    });
}

#[test]
fn a_late_turn_leaves_the_field_out_and_keeps_the_surface() {
    with_tracker(|tracker, bench, field| {
        let mut clock = Ticks::every_us(1);
        for _ in 0..20 {
            take(tracker, &bench.payloads(), &mut clock, field);
        }
        field.fill(-1.0);
        let turns = take(tracker, &bench.payloads(), &mut Ticks::every_us(5_000), field);
        let estimate = &turns[0].estimate;
        assert!(!estimate.field_fresh && field.iter().all(|&x| x == -1.0), "the field was left alone");
        assert_eq!(estimate.mode, Mode::Tracking);
        assert!(estimate.surface_m.iter().any(|&z| z != 0.0), "the surface never is");
        let health = tracker.memory.health;
        assert_eq!((health.field_shed, health.deadline_missed), (1, 1));
    });
}

#[test]
fn a_camera_that_sees_no_liquid_lets_the_estimate_coast() {
    with_tracker(|tracker, bench, field| {
        let mut clock = Ticks::every_us(1);
        for _ in 0..20 {
            take(tracker, &bench.payloads(), &mut clock, field);
        }
        bench.images.1.fill(180);
        let turns = take(tracker, &bench.payloads(), &mut clock, field);
        assert!(matches!(turns[0].profile, Some(Err(_))), "{:?}", turns[0].profile);
        assert_eq!(turns[0].estimate.mode, Mode::Coasting);
        assert_eq!(tracker.memory.health.not_seen, 1);
    });
}
