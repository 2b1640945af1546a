//! Surface errors of the camera on recordings: renders each frame, reads it back, prints the errors.
//!
//! `cargo run --release -p meniscus-examples --example see -- [camera-height-mm] RECORDING...`

use meniscus::surface::{Config, ExtractionState, extract};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus_data::recording::Recording;
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1).peekable();
    let mut settings = SceneSettings::default();
    if let Some(height_mm) = arguments.peek().and_then(|first| first.parse::<f32>().ok()) {
        settings.camera.camera_height_m = 1e-3 * height_mm;
        arguments.next();
    }
    println!(
        "{:28} {:>7} {:>8} {:>8} {:>8} {:>8} {:>10} {:>6}",
        "recording", "frames", "rms mm", "99 % mm", "worst mm", "axis mm", "a m/s2 rms", "seen"
    );
    for path in arguments {
        see(Path::new(&path), settings)?;
    }
    Ok(())
}

/// Prints one row of the table.
fn see(path: &Path, settings: SceneSettings) -> Result<(), Box<dyn std::error::Error>> {
    let recording = Recording::load(path)?;
    let config = Config::new(settings.camera)?;
    let (width, height) = config.image_size();
    let (mut scene, mut images, mut state) =
        (Scene::new(settings), Images::new(&settings), ExtractionState::new());
    let (mut errors_mm, mut axis_mm) = (Vec::new(), Vec::new());
    let mut lost = 0;
    for frame in 0..recording.frames() {
        scene.render(&Liquid::of(&recording, frame), frame as u64, &mut images);
        let stamp = Stamp::default();
        let depth = DepthFrame { bytes: &images.depth, width, height, stamp };
        let infrared = OutlineFrame { bytes: &images.infrared, width, height, stamp };
        match extract(&config, &mut state, depth, infrared) {
            Ok(profile) => {
                let points = profile.height_m.iter().zip(profile.valid).zip(recording.profile(frame));
                let seen = points.filter(|((_, valid), _)| *valid);
                errors_mm.extend(seen.map(|((seen, _), truth)| 1e3 * f64::from((seen - truth).abs())));
                let axis_m = f64::from(profile.glass_x_m.unwrap_or(f32::NAN));
                axis_mm.push(1e3 * (axis_m - recording.glass_x_m[frame]));
            }
            Err(why) => {
                lost += 1;
                eprintln!("frame {frame}: {why}");
            }
        }
    }
    let rms = |numbers: &[f64]| (numbers.iter().map(|x| x * x).sum::<f64>() / numbers.len() as f64).sqrt();
    let points = meniscus::surface::POINTS * recording.frames();
    errors_mm.sort_by(f64::total_cmp);
    let at = |share: f64| errors_mm[(share * (errors_mm.len() - 1) as f64) as usize];
    // The second difference of the axis error is the error of the acceleration.
    let second: Vec<f64> =
        axis_mm.windows(3).map(|a| 1e-3 * (a[2] - 2.0 * a[1] + a[0]) / FRAME_INTERVAL_S.powi(2)).collect();
    println!(
        "{:28} {:>7} {:>8.3} {:>8.3} {:>8.3} {:>8.4} {:>10.4} {:>6.3}",
        path.file_stem().unwrap_or_default().to_string_lossy(),
        recording.frames() - lost,
        rms(&errors_mm),
        at(0.99),
        at(1.0),
        rms(&axis_mm),
        rms(&second),
        errors_mm.len() as f64 / points as f64,
    );
    println!("{:28} {:?}", "", state.tally());
    Ok(())
}
