//! Whole runs: before the simulated camera, which draws the tag above the glass, and of a recording in which the tag is lost.

use crate::program::{errors, folder, json, meniscus};
use meniscus::surface::POINTS;
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags::{Calibration, Image, McapWriter};
use meniscus_data::recording::{EstimateRecording, Recording};
use meniscus_usb::camera::OutlineImage;
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings, TagPattern, TagPlate};
use serde_json::Value;
use std::path::Path;

/// Turns that are left out: the camera has to agree to the motion first, and the window of the encoder to fill.
const SETTLED: usize = 90;
/// Frames of the recording, and the first one without the tag.
const FRAMES: usize = 150;
const COVERED: usize = 90;

/// A run that has ended.
struct Run {
    report: Value,
    said: String,
    estimates: EstimateRecording,
}

impl Run {
    fn of(folder: &Path, arguments: &[&str]) -> Self {
        let all = format!("run --seconds 6 --json --estimates estimates.safetensors {}", arguments.join(" "));
        let output = meniscus(folder, &all);
        let said = errors(&output);
        assert!(output.status.success(), "{arguments:?}: {said}");
        let report = json(&output);
        let estimates = EstimateRecording::load(&folder.join("estimates.safetensors")).expect("estimates");
        Self { report, said, estimates }
    }

    fn tag(&self, name: &str) -> u64 {
        let tag = &self.report["motion"]["tag"];
        tag[name].as_u64().unwrap_or_else(|| panic!("no {name}: {tag} {}", self.said))
    }

    fn sigma(&self) -> f64 {
        self.report["field_error"]["sigma"].as_f64().expect("scored")
    }
}

/// Root mean squares over the settled turns of both runs: difference of the surfaces, to the slosh; difference of the
/// accelerations, to their own size.
fn apart(is: &EstimateRecording, due: &EstimateRecording) -> [f64; 2] {
    let heights =
        |of: &EstimateRecording, row: usize| of.surface_m[row * POINTS..(row + 1) * POINTS].to_vec();
    let (mut surface, mut slosh, mut acceleration, mut size) = (0.0, 0.0, 0.0, 0.0);
    for (k, camera_us) in is.camera_us.iter().enumerate().skip(SETTLED) {
        let other = due.camera_us.binary_search(camera_us).expect("the same frames");
        let (is_m, due_m) = (heights(is, k), heights(due, other));
        let mean = due_m.iter().sum::<f32>() / POINTS as f32;
        for (is_m, due_m) in is_m.iter().zip(&due_m) {
            surface += f64::from(is_m - due_m).powi(2);
            slosh += f64::from(due_m - mean).powi(2);
        }
        acceleration += f64::from(is.acceleration_m_s2[k] - due.acceleration_m_s2[other]).powi(2);
        size += f64::from(due.acceleration_m_s2[other]).powi(2);
    }
    [(surface / slosh).sqrt(), (acceleration / size).sqrt()]
}

/// With a camera that waits for the estimator: the same on every machine.
#[test]
fn the_slosh_under_the_motion_of_the_tag_is_that_under_the_true_motion() {
    let patient =
        |name: &str, motion: &[&str]| Run::of(&folder("tag", name), &[&["--patient"], motion].concat());
    let truth = patient("truth", &["--motion", "truth"]);
    let tag = patient("tag", &["--motion", "tag:7,40"]);
    let edges = patient("edges", &[]);
    let of = |name: &str, run: &Run, due: &Run| {
        let [surface, acceleration] = apart(&run.estimates, &due.estimates);
        println!(
            "{name}: surface {:.2} % of the slosh, acceleration {:.1} %; error of the stress {:.1} %",
            100.0 * surface,
            100.0 * acceleration,
            100.0 * run.sigma()
        );
        [surface, acceleration]
    };
    of("edges to truth", &edges, &truth);
    let [surface, acceleration] = of("tag to truth", &tag, &truth);
    println!("{}\n{}", tag.report["motion"], tag.said);
    assert!(surface < 0.015 && acceleration < 0.1, "{surface} {acceleration}");
    // The first image is searched in a quarter of its size, and the corners come with the second.
    assert_eq!(["images", "seen", "missing"].map(|name| tag.tag(name)), [360, 359, 1]);
    let motion = &tag.report["motion"];
    let commanded = motion["commanded"].as_u64().expect("a number");
    assert!(commanded > 320 && motion["contradictions"] == 0, "{motion}");
    // It is the tag's motion that was used, not that of the edges.
    assert!(of("tag to edges", &tag, &edges)[1] > 0.01);
}

/// Writes a recording of a glass with a tag that is covered behind [`COVERED`] frames.
fn record(path: &Path) {
    let recording =
        Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING).expect("a recording");
    let plain = SceneSettings::of(&recording.glass);
    let pattern = TagPattern::of(7).expect("in the family");
    let tag = TagPlate { pattern, size_m: 0.04, height_m: 0.155, lean_rad: 0.35 };
    let (mut with, mut without) = (Scene::new(SceneSettings { tag: Some(tag), ..plain }), Scene::new(plain));
    let lens = plain.camera.intrinsics;
    let calibration = Calibration {
        size: (lens.width as u32, lens.height as u32),
        focal_px: [lens.fx, lens.fy],
        centre_px: [lens.ppx, lens.ppy],
        depth_unit_m: plain.camera.depth_unit_m,
        baseline_m: plain.baseline_m as f32,
        camera: "a test".into(),
        outline: OutlineImage::Infrared,
        depth_lens_m: [0.0; 3],
    };
    let mut writer = McapWriter::create(path, &calibration).expect("a file");
    let mut images = Images::new(&plain);
    for frame in 0..FRAMES {
        let scene = if frame < COVERED { &mut with } else { &mut without };
        scene.render(&Liquid::of(&recording, frame), frame as u64, &mut images);
        let captured = Micros(1_000_000 + frame as u64 * 1_000_000 / 60);
        let stamp = Stamp { sequence: frame as u32, captured };
        for (stream, pixels) in [(Stream::Depth, &images.depth), (Stream::Outline, &images.infrared)] {
            writer.write(&Image { stream, stamp, pixels: pixels.clone() }).expect("written");
        }
    }
    writer.finish().expect("closed");
}

#[test]
fn a_tag_that_is_lost_in_a_recording_is_reported_and_the_edges_are_used() {
    let folder = folder("tag", "lost");
    let path = folder.join("lost.mcap");
    record(&path);
    let run = Run::of(&folder, &["--source", "lost.mcap", "--motion", "tag:7,40"]);
    let motion = &run.report["motion"];
    println!("{motion}\n{}", run.said);
    // A busy machine may drop payloads: those of both kinds came.
    let (images, seen) = (run.tag("images"), run.tag("seen"));
    assert!(images > FRAMES as u64 / 2 && seen > 20 && images - seen > 20, "{motion}");
    assert_eq!(run.tag("missing"), images - seen, "{motion}");
    assert_eq!(motion["stamped"]["stops"], 1, "{motion}");
    assert!(run.said.contains("the tag is lost (no tag in the image"), "{}", run.said);
    let turns = |name: &str| motion[name].as_u64().expect("a number");
    assert!(turns("commanded") <= seen && turns("commanded") > 10 && turns("tracked") > 20, "{motion}");
}
