//! The turn allocates nothing: counted over 10,000 of them, payloads to field, faults included.

#[path = "support/glass.rs"]
mod glass;
mod support;

use meniscus::blob::Model;
use meniscus::runtime::{Estimator, InputSource, Mode, ProfileSensor, Tracker};
use meniscus::surface::{Config, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_hil::{Camera, CameraSettings, FaultInjector, FaultList, Shot, Source};
use meniscus_platform::allocations::{CountingAllocator, allocations_of_this_thread};
use meniscus_service::identify::channel;
use meniscus_service::live::{CrestImage, FlightRecorder, Log, Silence, Worker};
use meniscus_service::publish::{Destination, Publisher};
use meniscus_service::sink::{LatestTurn, TurnRecord, TurnSink};
use meniscus_service::snapshot::{ImageSchedule, SnapshotOutlet, TurnSnapshot};
use meniscus_usb::link::link;
use std::net::UdpSocket;
use std::sync::atomic::{AtomicBool, Ordering};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn ten_thousand_turns_allocate_nothing() {
    let bytes = support::random_blob(3, 0.1);
    let model = Model::load(&bytes).expect("a sound blob");
    let mut field = vec![0.0; model.field_len()];
    let (mut depth_room, mut infrared_room) = (vec![0; 640 * 480 * 2], vec![0; 640 * 480]);
    let sensor = ProfileSensor::new(
        Config::new(Settings::default()).expect("sound"),
        &mut depth_room,
        &mut infrared_room,
    );
    let mut tracker = Tracker::new(Estimator::new(&model), sensor);

    let faults: FaultList =
        "drop:0.02,tear:0.02,split:0.02,length2:0.01,duplicate:0.02".parse().expect("known");
    let mut camera = FaultInjector::new(Camera::new(CameraSettings::default()), faults, 5);
    let (depth, infrared) = glass::images();
    let (mut clock, mut turns, mut tracked, mut allocations) = (glass::Ticks::every_us(1), 0, 0, 0);
    for frame in 0_u64.. {
        let captured_us = 1_000_000 + frame * 16_667;
        let payloads = camera.expose(&Shot::infrared(&depth, &infrared, captured_us));
        let before = allocations_of_this_thread();
        for payload in &payloads {
            let stream = match payload.stream {
                meniscus_hil::Stream::Depth => Stream::Depth,
                meniscus_hil::Stream::Infrared | meniscus_hil::Stream::Colour => Stream::Outline,
            };
            tracker.accept(
                stream,
                &payload.bytes,
                InputSource::tracked,
                &mut clock,
                &mut field,
                |turn, _| {
                    turns += 1;
                    tracked += u32::from(turn.estimate.mode == Mode::Tracking);
                },
            );
        }
        allocations += allocations_of_this_thread() - before;
        if turns >= 10_000 {
            break;
        }
    }
    assert_eq!(allocations, 0);
    assert!(tracked > 8_000, "most turns must have seen the liquid, or nothing is tested: {tracked}");
    assert!(tracker.memory.health.coasting > 100, "{:?}", tracker.memory.health);
}

/// The counter counts: without this, zero would prove nothing.
#[test]
fn an_allocation_is_counted() {
    let before = allocations_of_this_thread();
    let boxed = std::hint::black_box(Box::new(1_u64));
    assert_eq!(allocations_of_this_thread() - before, *boxed);
}

/// A sink that breaks the contract: it allocates in every turn.
struct Careless(Vec<String>);

impl TurnSink for Careless {
    fn accept(&mut self, record: &TurnRecord<'_>) {
        self.0.push(record.logged.turn_us.to_string());
    }
}

/// Runs a worker over `frames` frames of a camera that waits for it, and returns the log; `more` comes behind every
/// sink of the library.
fn worked(frames: u64, more: &mut dyn TurnSink) -> Log {
    let bytes = support::random_blob(3, 0.1);
    let model = Model::load(&bytes).expect("a sound blob");
    let config = Config::new(Settings::default()).expect("sound");
    let reader = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let destination = Destination::Udp(reader.local_addr().expect("an address"));
    let (mut publish, publisher) =
        Publisher::start(&[destination], &model.header, 30.0, model.field_len()).expect("it opens");
    let mut snapshots = SnapshotOutlet::new(640 * 480);
    let viewer = snapshots.clone();
    let (mut profiles, _feed) = channel();
    let (recorder, latest, over) = (FlightRecorder::default(), LatestTurn::default(), AtomicBool::new(false));
    recorder.open();
    let (camera_end, worker_end) = link(8, 640 * 480 * 2 + 8192);
    let log = std::thread::scope(|scope| {
        scope.spawn(move || {
            let mut camera = Camera::new(CameraSettings::default());
            let (depth, infrared) = glass::images();
            for frame in 0..frames {
                for payload in camera.expose(&Shot::infrared(&depth, &infrared, 1_000_000 + frame * 16_667)) {
                    let stream = match payload.stream {
                        meniscus_hil::Stream::Depth => Stream::Depth,
                        meniscus_hil::Stream::Infrared | meniscus_hil::Stream::Colour => Stream::Outline,
                    };
                    camera_end.send_patiently(stream, &payload.bytes);
                }
            }
        });
        let over = &over;
        scope.spawn(move || {
            let mut schedule = ImageSchedule::default();
            schedule.want_depth(true);
            let mut images = 0;
            while !over.load(Ordering::Relaxed) {
                let taken = viewer.take(&mut schedule);
                let both = |s: &TurnSnapshot| s.image_of.is_some() && s.depth.len() == 2 * s.infrared.len();
                images += usize::from(taken.is_some_and(|(snapshot, _)| both(&snapshot)));
            }
            assert!(images > 0, "a viewer that gets no image proves little");
        });
        let mut log = Log::for_frames(frames as usize);
        let (mut crest, mut ring, mut newest) = (CrestImage::new(0.07, 640 * 480), recorder.ring(), &latest);
        let worker = Worker { silence: Silence::WaitOut, ..Worker::new(Estimator::new(&model), config) };
        let mut sinks: [&mut dyn TurnSink; 8] =
            [&mut publish, &mut snapshots, &mut profiles, &mut newest, &mut ring, &mut crest, &mut log, more];
        worker.run(&worker_end, &AtomicBool::new(false), &mut sinks);
        over.store(true, Ordering::Relaxed);
        assert!(crest.turn.is_some() && latest.get().is_some());
        log
    });
    drop(publish);
    publisher.finish();
    log
}

/// Sinks run in the worker's thread and keep its promise, whoever reads at their other end.
#[test]
fn no_sink_of_the_library_allocates_and_one_that_does_is_counted() {
    let log = worked(600, &mut Log::with_room(0));
    assert!(log.turns.len() >= 590, "{} turns", log.turns.len());
    assert_eq!((log.sink_allocations, log.allocations()), (0, 0));
    let log = worked(60, &mut Careless(Vec::new()));
    assert!(log.sink_allocations >= log.turns.len() as u64, "{}", log.sink_allocations);
}
