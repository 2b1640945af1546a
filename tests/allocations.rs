//! The turn allocates nothing: counted over 10,000 of them, payloads to field, faults included.
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

#[path = "support/glass.rs"]
mod glass;
mod support;

use meniscus::blob::Model;
use meniscus::runtime::{Estimator, Eye, InputSource, Mode, Tracker};
use meniscus::surface::{Config, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_hil::{Camera, CameraSettings, FaultInjector, FaultList, Shot, Source};
use meniscus_platform::allocations::{CountingAllocator, allocations_of_this_thread};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn ten_thousand_turns_allocate_nothing() {
    let bytes = support::random_blob(3, 0.1);
    let model = Model::load(&bytes).expect("a sound blob");
    let mut field = vec![0.0; model.field_len()];
    let (mut depth_room, mut infrared_room) = (vec![0; 640 * 480 * 2], vec![0; 640 * 480]);
    let eye = Eye::new(Config::new(Settings::default()).expect("sound"), &mut depth_room, &mut infrared_room);
    let mut tracker = Tracker::new(Estimator::new(&model), eye);

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
