//! Link proof: the core from blob to field, in a program that has no allocator to link against, and
//! whose panic handler needs a symbol that does not exist.
//!
//! If anything on the way allocates, the linker misses `__rust_alloc`. If any path can panic, the
//! handler stays in the program and the linker misses `a_panic_path_is_left_in_the_core`.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use meniscus::blob::Model;
use meniscus::depth_filters::{
    Decimation, HoleFilling, LANES, Spatial, SpatialDisparity, Temporal, TemporalState, decimate, fill_holes,
    to_depth, to_disparity,
};
use meniscus::runtime::output::{OUTPUT_MAX, Packet};
use meniscus::runtime::{Clock, Estimator, InputSource, ProfileSensor, Tracker};
use meniscus::surface::{Config, Rectifier, Settings};
use meniscus::usb::d4xx;
use meniscus::usb::d4xx::{Colour, Command, DepthTable, Identity, MESSAGE, Table};
use meniscus::usb::uvc::descriptor::{check, interfaces};
use meniscus::usb::uvc::format::{input_header, video_modes};
use meniscus::usb::uvc::{ControlChange, Probe, Stream, Topology, extension_unit};

unsafe extern "C" {
    /// Defined nowhere.
    safe fn a_panic_path_is_left_in_the_core() -> !;
}

/// Reached by no path of a program that links.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_path_is_left_in_the_core()
}

/// A clock as a board would have it: a counter.
struct Ticks(u64);

impl Clock for Ticks {
    fn now_us(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        black_box(self.0)
    }
}

/// The main job on bytes that the compiler cannot see through. Linked, never run.
// SAFETY: the only symbol of that name; the linker's entry point, called by nobody else.
#[unsafe(no_mangle)]
pub extern "C" fn _start() -> ! {
    let (mut depth, mut colour, mut grey, mut numbers) = ([0; 16], [0; 16], [0; 8], [0.0; 16]);
    let mut clock = Ticks(0);
    let blob: &[u8] = black_box(&[]);
    let lens = connect(black_box(&[]));
    filter();
    match (Model::load(blob), Config::new(black_box(Settings::default()))) {
        (Ok(model), Ok(config)) => {
            let (depth, colour, grey): (&mut [u8], &mut [u8], &mut [u8]) =
                (black_box(&mut depth), black_box(&mut colour), black_box(&mut grey));
            let sensor = match black_box(lens) {
                Some(Colour { lens, .. }) => {
                    let rectifier = Rectifier::new(lens, config.settings().intrinsics);
                    ProfileSensor::with_colour(config, depth, rectifier, colour, grey)
                }
                None => ProfileSensor::new(config, depth, grey),
            };
            let mut tracker = Tracker::new(Estimator::new(&model), sensor);
            let field: &mut [f32] = black_box(&mut numbers);
            let mut number = 0_u64;
            loop {
                let payload: &[u8] = black_box(&[]);
                let stream = black_box(Stream::Depth);
                tracker.accept(stream, payload, InputSource::tracked, &mut clock, field, |turn, field| {
                    send(&Packet::of(turn, number, &model.header), field);
                    number = number.wrapping_add(1);
                });
                black_box(tracker.silence(InputSource::tracked, &mut clock, field));
            }
        }
        refused => loop {
            black_box(&refused);
        },
    }
}

/// Writes an estimate as the board would send it.
fn send(packet: &Packet, field: &[f32]) {
    let mut buffer = [0; OUTPUT_MAX];
    let _sent = black_box(packet.write(&mut buffer).is_ok());
    black_box(field);
}

/// Reads everything ahead of the stream: descriptors, probe, status packets, hardware monitor. Returns the colour lens
/// if its table is sound.
fn connect(bytes: &[u8]) -> Option<Colour> {
    black_box(check(bytes).is_ok());
    for interface in interfaces(bytes) {
        black_box((Topology::of(&interface), input_header(&interface), interface.input(2)).0.is_some());
        black_box(extension_unit(&interface, &d4xx::UNIT_GUID).is_some());
        for mode in video_modes(&interface) {
            black_box((mode, mode.interval_of(60), mode.intervals().last()));
        }
    }
    if let Ok(probe) = Probe::read(bytes, black_box(48)) {
        let asked = probe.ask((1, 1), 166_666);
        black_box((asked.bytes(), probe.agrees(&asked, 1).is_ok()));
    }
    black_box(ControlChange::read(bytes).is_some());
    black_box(Identity::read(bytes).is_ok());
    if let Ok(table) = Table::read(bytes, d4xx::COEFFICIENTS) {
        black_box(d4xx::baseline_mm(&table).is_ok());
        black_box(d4xx::coefficients(&table, (640, 480)).is_ok());
    }
    black_box(d4xx::recommended::read(bytes, (640, 480)).is_ok());
    let mut message = [0; MESSAGE];
    if let Ok(table) = DepthTable::read(bytes) {
        table.with_unit_um(black_box(100)).set().write(&mut message);
    }
    Command { data: bytes, ..Command::new(1, [0; 4]) }.write(&mut message);
    black_box(&message);
    Table::read(bytes, d4xx::COLOUR).ok().and_then(|table| d4xx::colour(&table, (640, 480)).ok())
}

/// Every depth filter, on images whose sizes the compiler cannot see.
fn filter() {
    let (mut image, mut disparity, mut small) = ([0; 16], [0.0; 16], [0; 16]);
    let image: &mut [u16] = black_box(&mut image);
    let disparity: &mut [f32] = black_box(&mut disparity);
    let (mut room, mut lanes) = ([[0; LANES]; 4], [[0.0; LANES]; 4]);
    let width = black_box(4);
    let spatial = black_box(Spatial::default());
    black_box(spatial.apply(image, width, black_box(&mut room)).is_ok());
    black_box(to_disparity(image, black_box(1.0), disparity).is_ok());
    let recursive = black_box(SpatialDisparity::default());
    black_box(recursive.apply(disparity, width, black_box(&mut lanes)).is_ok());
    black_box(to_depth(disparity, black_box(1.0), image).is_ok());
    black_box(fill_holes(image, width, black_box(HoleFilling::Farthest)).is_ok());
    let (mut last, mut history) = ([0; 16], [0; 16]);
    let mut state = TemporalState::new(black_box(&mut last), black_box(&mut history));
    black_box(black_box(Temporal::default()).apply(image, &mut state).is_ok());
    let decimation = Decimation::new(black_box(2), (width, black_box(4)));
    black_box(decimate(decimation, image, black_box(&mut small)).is_ok());
}
