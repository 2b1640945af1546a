//! The camera side in a program of one's own without `std` and without an allocator: payload bytes in, the liquid out.
//!
//! ```toml
//! [dependencies]
//! meniscus = { path = "../meniscus", default-features = false }    # the core alone
//! ```
//!
//! Everything in `board` uses `core` and the core, so that it goes onto a microcontroller as it stands
//! (`firmware-config/src/main.rs` is that program with the proof that it links; `firmware-config/bare-metal` runs it
//! on a Cortex-M7). `main` stands for the USB driver of the board: it plays two seconds of the simulated camera.
//!
//! `cargo run --release -p meniscus-examples --example board`
#![no_std]

extern crate std;

use meniscus_data::recording::Recording;
use meniscus_virtual::camera::SimulatedCamera;
use meniscus_virtual::render::SceneSettings;
use std::boxed::Box;
use std::error::Error;
use std::path::Path;
use std::{print, println, vec};

/// Program of a board.
mod board {
    use meniscus::blob::{LoadError, Model};
    use meniscus::runtime::{Clock, Estimator, InputSource, ProfileSensor, Tracker, Turn};
    use meniscus::surface::Config;
    use meniscus::usb::uvc::Stream;

    /// The shipped model in the program's own read-only memory, where its weights are read in place.
    #[repr(align(64))]
    struct Aligned<T: ?Sized>(T);
    static BLOB: &Aligned<[u8]> = &Aligned(*include_bytes!("../models/glycerine.blob"));

    /// A clock that stands; a board reads a counter of its own here, and late frames are then dropped and counted.
    struct NoClock;

    impl Clock for NoClock {
        fn now_us(&mut self) -> u64 {
            0
        }
    }

    /// The checked model.
    pub(super) fn model() -> Result<Model<'static>, LoadError> {
        Model::load(&BLOB.0)
    }

    /// Every byte of memory that the job needs, lent by whoever has it: the two images and the field.
    pub(super) struct Room<'r> {
        pub(super) depth: &'r mut [u8],
        pub(super) infrared: &'r mut [u8],
        pub(super) field: &'r mut [f32],
    }

    /// Takes payloads from `next` until there are no more, and gives each turn with its field to `done`.
    pub(super) fn run<'p>(
        model: &Model<'_>,
        config: Config,
        room: Room<'_>,
        mut next: impl FnMut() -> Option<(Stream, &'p [u8])>,
        mut done: impl FnMut(&Turn, &[f32]),
    ) {
        let sensor = ProfileSensor::new(config, room.depth, room.infrared);
        let mut tracker = Tracker::new(Estimator::new(model), sensor);
        while let Some((stream, payload)) = next() {
            tracker.accept(stream, payload, InputSource::tracked, &mut NoClock, room.field, |turn, field| {
                done(turn, field);
            });
        }
    }
}

/// Frames that are played: two seconds.
const FRAMES: usize = 120;

fn main() -> Result<(), Box<dyn Error>> {
    let recording = Recording::load(Path::new("recordings/glycerine-unseen.safetensors"))?;
    let scene = SceneSettings::of(&recording.glass);
    let mut payloads = vec::Vec::new();
    SimulatedCamera::new(&recording, scene, meniscus_hil::FaultList::default())
        .send_first(FRAMES, |stream, payload| payloads.push((stream, payload.to_vec())));

    let model = board::model()?;
    let config = meniscus::surface::Config::new(scene.camera)?;
    let (width, height) = config.image_size();
    let (mut depth, mut infrared) = (vec![0; 2 * width * height], vec![0; width * height]);
    let mut field = vec![0.0; meniscus::runtime::Estimator::new(&model).field_len()];
    let room = board::Room { depth: &mut depth, infrared: &mut infrared, field: &mut field };
    let mut payloads = payloads.iter().map(|(stream, payload)| (*stream, payload.as_slice()));
    board::run(
        &model,
        config,
        room,
        || payloads.next(),
        |turn, field| {
            let estimate = &turn.estimate;
            let highest = estimate.surface_m.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            print!("{:.3} s {:?}: highest {:.2} mm", turn.time.0 as f64 * 1e-6, estimate.mode, 1e3 * highest);
            println!(", {} numbers of the field", field.len());
        },
    );
    Ok(())
}
