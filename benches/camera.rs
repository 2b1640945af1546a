//! Times of the camera side on one core: rendering, wire, extraction, the reference filters; median and
//! worst of many frames.
//!
//! The filters are given as ratios to the reference library: 9.4 ms of processor time for its spatial
//! filter on a 640x480 frame with 15 % holes, 0.7 ms for its hole filling, on another server core of the
//! same class. A ratio across machines is a rough one; the targets have room for that.
//!
//! `cargo bench -p meniscus-benches --bench camera`

use meniscus::depth_filters::{HoleFilling, LANES, Spatial, SpatialDisparity, fill_holes, to_disparity};
use meniscus::surface::{ColourLens, Config, ExtractionState, Intrinsics, Rectifier, extract};
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus::usb::uvc::{Assembler, AssemblyOutcome, DeviceClock};
use meniscus_data::recording::{COLUMNS, WALL_POINTS, wall_azimuth};
use meniscus_hil::{Camera, CameraSettings, Shot, Source, Stream};
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use std::hint::black_box;
use std::time::Instant;

const FRAMES: u64 = 600;

/// The reference library's times, microseconds: spatial on Z16 and on disparities, hole filling.
const REFERENCE_US: [f64; 3] = [9_400.0, 4_200.0, 700.0];
/// The region-of-interest path, payload to profile, must not take longer, microseconds.
const ROI_US: f64 = 500.0;

/// Durations of one stage, microseconds.
#[derive(Default)]
struct Stage(Vec<f64>);

impl Stage {
    fn time<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = black_box(work());
        self.0.push(start.elapsed().as_secs_f64() * 1e6);
        result
    }

    /// Prints the stage; gives the median.
    fn report(mut self, name: &str) -> f64 {
        self.0.sort_by(f64::total_cmp);
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        println!("{name:28} median {:8.1} us, 99 % {:8.1} us, worst {:8.1} us", at(0.5), at(0.99), at(1.0));
        at(0.5)
    }
}

/// The filters on a rendered frame.
fn filters(depth: &[u8], width: usize) {
    let image: Vec<u16> = depth.as_chunks().0.iter().map(|z| u16::from_le_bytes(*z)).collect();
    let holes = image.iter().filter(|&&z| z == 0).count() as f64 / image.len() as f64;
    println!("filters on a frame with {:.0} % holes", 100.0 * holes);
    let (mut room, mut lanes) = (vec![[0; LANES]; width], vec![[0.0; LANES]; width]);
    let mut disparity = vec![0.0; image.len()];
    let [mut z16, mut recursive, mut farthest] = std::array::from_fn(|_| Stage::default());
    for _ in 0..FRAMES / 4 {
        let mut work = image.clone();
        z16.time(|| Spatial::default().apply(&mut work, width, &mut room)).expect("sizes fit");
        let mut work = image.clone();
        farthest.time(|| fill_holes(&mut work, width, HoleFilling::Farthest)).expect("sizes fit");
        to_disparity(&image, 6_128_000.0, &mut disparity).expect("sizes fit");
        let spatial = SpatialDisparity::default();
        recursive.time(|| spatial.apply(&mut disparity, width, &mut lanes)).expect("sizes fit");
    }
    let stages =
        [("spatial, Z16", z16), ("spatial, disparity", recursive), ("hole filling, farthest", farthest)];
    for ((name, stage), reference_us) in stages.into_iter().zip(REFERENCE_US) {
        let median_us = stage.report(name);
        println!(
            "{:28} {:.1} times as fast as the reference's {reference_us} us",
            "",
            reference_us / median_us
        );
    }
}

/// Of a D435's colour lens, turned and distorted a little.
fn rectifier(to: Intrinsics) -> Rectifier {
    let intrinsics = Intrinsics { fx: 612.4, fy: 610.6, ppx: 322.1, ppy: 244.7, ..to };
    let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, -0.004], [0.0, 0.004, 1.0]];
    Rectifier::new(ColourLens { intrinsics, distortion: [0.1, -0.2, 0.0, 0.0, 0.1], rotation }, to)
}

fn main() {
    let settings = SceneSettings::default();
    let config = Config::new(settings.camera).expect("the default settings are sound");
    let (width, height) = config.image_size();
    let (mut scene, mut images, mut state) =
        (Scene::new(settings), Images::new(&settings), ExtractionState::new());
    let mut camera = Camera::new(CameraSettings::default());
    let mut room = vec![0; 2 * width * height];
    let mut spare = room.clone();
    let mut third = room.clone();
    let (mut assembler, mut reader) = (Assembler::new(&mut room), Assembler::new(&mut third));
    let mut clock = DeviceClock::default();
    let [mut render, mut pack, mut push, mut whole, mut tracked, mut lost, mut roi] =
        std::array::from_fn(|_| Stage::default());
    for frame in 0..FRAMES {
        let tilt = 0.008 * (0.37 * frame as f64).sin();
        let wall_m: Vec<f32> =
            (0..WALL_POINTS).map(|i| (0.07 + tilt * wall_azimuth(i).cos()) as f32).collect();
        let liquid = Liquid {
            glass_m: [0.05 * (0.21 * frame as f64).sin(), 0.0],
            wall_m: &wall_m,
            column_m: &[0.07; COLUMNS],
        };
        render.time(|| scene.render(&liquid, frame, &mut images));
        let shot = Shot::infrared(&images.depth, &images.infrared, 1_000 + frame * 16_667);
        let payloads = pack.time(|| camera.expose(&shot));
        let payload = payloads.iter().find(|p| p.stream == Stream::Depth).expect("a healthy camera");
        let seen =
            push.time(|| matches!(assembler.push(&payload.bytes, &mut clock), AssemblyOutcome::Frame(_)));
        assert!(seen, "frame {frame}");
        let mut in_place = Assembler::new(&mut spare);
        assert!(
            whole.time(|| matches!(in_place.whole(&payload.bytes, &mut clock), AssemblyOutcome::Frame(_)))
        );
        let stamp = Stamp::default();
        let depth = DepthFrame { bytes: &images.depth, width, height, stamp };
        let infrared = OutlineFrame { bytes: &images.infrared, width, height, stamp };
        let profile = tracked.time(|| extract(&config, &mut state, depth, infrared));
        assert!(profile.is_ok(), "frame {frame}: {profile:?}");
        let profile = roi.time(|| {
            let AssemblyOutcome::Frame(frame) = reader.whole(&payload.bytes, &mut clock) else { return None };
            let depth = DepthFrame { bytes: frame.pixels, width, height, stamp: frame.stamp };
            extract(&config, &mut state, depth, infrared).ok()
        });
        assert!(profile.is_some(), "frame {frame}");
        assert!(lost.time(|| extract(&config, &mut ExtractionState::new(), depth, infrared)).is_ok());
    }
    for (name, stage) in [
        ("render a pair", render),
        ("pack both payloads", pack),
        ("push a depth payload (copy)", push),
        ("check a payload in place", whole),
        ("extract, glass tracked", tracked),
        ("extract, glass searched", lost),
    ] {
        stage.report(name);
    }
    let rectifier = rectifier(settings.camera.intrinsics);
    let (yuy2, mut grey) = (vec![90; rectifier.colour_bytes()], vec![0; rectifier.grey_bytes()]);
    let mut rectify = Stage::default();
    let region = state.region(&config);
    (0..FRAMES).for_each(|_| rectify.time(|| rectifier.rectify(&yuy2, &mut grey, region)));
    rectify.report("rectify colour, glass tracked");
    let roi_us = roi.report("payload to profile");
    println!("{:28} {:.2} of the {ROI_US} us that it may take", "", roi_us / ROI_US);
    filters(&images.depth, width);
}
