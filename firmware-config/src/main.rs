//! Link proof: storey 1 from blob to field, in a program that has no allocator to link against, and
//! whose panic handler needs a symbol that does not exist.
//!
//! If anything on the way allocates, the linker misses `__rust_alloc`. If any path can panic, the
//! handler stays in the program and the linker misses `a_panic_path_is_left_in_storey_1`.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use meniscus::model::Model;
use meniscus::output::{OUTPUT_MAX, OUTPUT_VERSION, Packet};
use meniscus::runtime::{Clock, Estimator, Eye, Tracker, Turn};
use meniscus::surface::{Config, Settings};
use meniscus::uvc::Stream;

unsafe extern "C" {
    /// Defined nowhere.
    safe fn a_panic_path_is_left_in_storey_1() -> !;
}

/// Reached by no path of a program that links.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_path_is_left_in_storey_1()
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
    let (mut depth, mut infrared, mut numbers) = ([0; 16], [0; 8], [0.0; 16]);
    let mut clock = Ticks(0);
    let blob: &[u8] = black_box(&[]);
    match (Model::load(blob), Config::new(black_box(Settings::default()))) {
        (Ok(model), Ok(config)) => {
            let eye = Eye::new(config, black_box(&mut depth), black_box(&mut infrared));
            let mut tracker = Tracker::new(Estimator::new(&model), eye);
            let field: &mut [f32] = black_box(&mut numbers);
            loop {
                let payload: &[u8] = black_box(&[]);
                let stream = black_box(Stream::Depth);
                tracker.accept(stream, payload, &mut clock, field, |turn, field| send(turn, field));
                black_box(tracker.silence(&mut clock, field));
            }
        }
        refused => loop {
            black_box(&refused);
        },
    }
}

/// What leaves the board.
fn send(turn: &Turn, field: &[f32]) {
    let mut buffer = [0; OUTPUT_MAX];
    let packet = Packet {
        version: OUTPUT_VERSION,
        time: turn.time,
        sequence: turn.stamp.map(|stamp| stamp.sequence),
        estimate: turn.estimate,
    };
    let _sent = black_box(packet.write(&mut buffer).is_ok());
    black_box(field);
}
