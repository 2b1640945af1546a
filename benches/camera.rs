//! What the camera side costs on one core: rendering, wire, extraction; median and worst of many frames.
//!
//! `cargo bench --bench camera`
#![allow(clippy::disallowed_methods, reason = "only storey 1 must compute the same bits on every platform")]

use meniscus::frame::{DepthFrame, InfraredFrame, Stamp};
use meniscus::offline::recording::{COLUMNS, WALL_POINTS, wall_azimuth};
use meniscus::offline::scene::{Images, Liquid, Scene, SceneSettings};
use meniscus::surface::{Config, State, extract};
use meniscus::uvc::{Assembler, Outcome};
use meniscus_hil::{Camera, CameraSettings, Shot, Source, Stream};
use std::hint::black_box;
use std::time::Instant;

const FRAMES: u64 = 600;

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

    fn report(mut self, name: &str) {
        self.0.sort_by(f64::total_cmp);
        let at = |share: f64| self.0[(share * (self.0.len() - 1) as f64) as usize];
        println!("{name:28} median {:8.1} us, 99 % {:8.1} us, worst {:8.1} us", at(0.5), at(0.99), at(1.0));
    }
}

fn main() {
    let settings = SceneSettings::default();
    let config = Config::new(settings.camera).expect("the default settings are sound");
    let (width, height) = config.image_size();
    let (mut scene, mut images, mut state) = (Scene::new(settings), Images::new(&settings), State::new());
    let mut camera = Camera::new(CameraSettings::default());
    let mut room = vec![0; 2 * width * height];
    let mut spare = room.clone();
    let mut assembler = Assembler::new(&mut room);
    let [mut render, mut pack, mut push, mut whole, mut tracked, mut lost] =
        std::array::from_fn(|_| Stage::default());
    for frame in 0..FRAMES {
        let tilt = 0.008 * (0.37 * frame as f64).sin();
        let wall_m: Vec<f32> =
            (0..WALL_POINTS).map(|i| (0.07 + tilt * wall_azimuth(i).cos()) as f32).collect();
        let liquid = Liquid {
            glass_x_m: 0.05 * (0.21 * frame as f64).sin(),
            wall_m: &wall_m,
            column_m: &[0.07; COLUMNS],
        };
        render.time(|| scene.render(&liquid, frame, &mut images));
        let shot =
            Shot { depth: &images.depth, infrared: &images.infrared, captured_us: 1_000 + frame * 16_667 };
        let payloads = pack.time(|| camera.expose(&shot));
        let payload = payloads.iter().find(|p| p.stream == Stream::Depth).expect("a healthy camera");
        let seen = push.time(|| matches!(assembler.push(&payload.bytes), Outcome::Frame(_)));
        assert!(seen, "frame {frame}");
        let mut in_place = Assembler::new(&mut spare);
        assert!(whole.time(|| matches!(in_place.whole(&payload.bytes), Outcome::Frame(_))));
        let stamp = Stamp::default();
        let depth = DepthFrame { bytes: &images.depth, width, height, stamp };
        let infrared = InfraredFrame { bytes: &images.infrared, width, height, stamp };
        let profile = tracked.time(|| extract(&config, &mut state, depth, infrared));
        assert!(profile.is_ok(), "frame {frame}: {profile:?}");
        assert!(lost.time(|| extract(&config, &mut State::new(), depth, infrared)).is_ok());
    }
    render.report("render a pair");
    pack.report("pack both payloads");
    push.report("push a depth payload (copy)");
    whole.report("check a payload in place");
    tracked.report("extract, glass tracked");
    lost.report("extract, glass searched");
}
