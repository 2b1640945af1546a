//! Time that the camera side takes on this machine: medians, with the processor as it is loaded.

use crate::render::{Images, Liquid, Scene, SceneSettings};
use meniscus::depth_filters::{LANES, Spatial};
use meniscus::surface::{Config, ExtractionState, extract};
use meniscus::usb::frame::{DepthFrame, OutlineFrame};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock};
use meniscus_data::recording::{COLUMNS, WALL_POINTS};
use meniscus_hil::{Camera, CameraSettings, Shot, Source};
use meniscus_numerics::statistics::median;
use std::hint::black_box;
use std::time::Instant;

/// Repetitions.
const FRAMES: u64 = 60;

/// Median of the seconds of each of `FRAMES` tries; a try gives the moment at which its work began, and
/// ends with it.
fn median_s(mut one: impl FnMut(u64) -> Instant) -> f64 {
    median((0..FRAMES).map(|frame| one(frame).elapsed().as_secs_f64())).unwrap_or(f64::NAN)
}

fn rendered(scene: &mut Scene, images: &mut Images, frame: u64) {
    let heights = ([0.07; WALL_POINTS], [0.07; COLUMNS]);
    let liquid = Liquid { glass_m: [0.001 * frame as f64, 0.0], wall_m: &heights.0, column_m: &heights.1 };
    scene.render(&liquid, frame, images);
}

/// From a depth payload in its buffer and an infrared image to the profile, microseconds; NaN when one
/// of the frames gave none.
pub(super) fn roi_path_us() -> f64 {
    let settings = SceneSettings::default();
    let Ok(config) = Config::new(settings.camera) else { return f64::NAN };
    let (width, height) = config.image_size();
    let (mut scene, mut images, mut state) =
        (Scene::new(settings), Images::new(&settings), ExtractionState::new());
    let mut room = vec![0; 2 * width * height];
    let mut clock = DeviceClock::default();
    let (mut camera, mut assembler) = (Camera::new(CameraSettings::default()), Assembler::new(&mut room));
    let mut missed = false;
    let median = median_s(|frame| {
        rendered(&mut scene, &mut images, frame);
        let shot = Shot::infrared(&images.depth, &images.infrared, frame * 16_667);
        let payloads = camera.expose(&shot);
        let started = Instant::now();
        let seen = match assembler.whole(&payloads[0].bytes, &mut clock) {
            AssemblyOutcome::Frame(frame) => {
                let depth = DepthFrame { bytes: frame.pixels, width, height, stamp: frame.stamp };
                let infrared = OutlineFrame { bytes: &images.infrared, width, height, stamp: frame.stamp };
                black_box(extract(&config, &mut state, depth, infrared)).is_ok()
            }
            _ => false,
        };
        missed |= !seen;
        started
    });
    if missed { f64::NAN } else { 1e6 * median }
}

/// The spatial filter with the library's settings on a whole rendered frame, milliseconds.
pub(super) fn spatial_filter_ms() -> f64 {
    let settings = SceneSettings { hole_share: 0.15, ..SceneSettings::default() };
    let (mut scene, mut images) = (Scene::new(settings), Images::new(&settings));
    rendered(&mut scene, &mut images, 0);
    let frame: Vec<u16> = images.depth.as_chunks().0.iter().map(|z| u16::from_le_bytes(*z)).collect();
    let width = settings.camera.intrinsics.width;
    let (mut work, mut room) = (frame.clone(), vec![[0; LANES]; width]);
    let mut refused = false;
    let median = median_s(|_| {
        work.copy_from_slice(&frame);
        let started = Instant::now();
        refused |= Spatial::default().apply(black_box(&mut work), width, &mut room).is_err();
        started
    });
    if refused { f64::NAN } else { 1e3 * median }
}
