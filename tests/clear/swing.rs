//! Clear water in a swing: frames of the simulator's own surfaces, path-traced, read one after the other.

use crate::figures::{DISTANCE_ERRORS_M, Figures};
use crate::scenes::{HEIGHT, JUDGED, WIDTH};
use meniscus::surface::{Config, ExtractionState, POINTS, Settings, extract};
use meniscus::units::Micros;
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus_virtual::camera_study::judge::Point;
use meniscus_virtual::camera_study::traced::degrade::{Faults, degrade};
use meniscus_virtual::camera_study::traced::set::{TracedScene, folder, read, settings};

/// Returns the frames of a set, in windows of consecutive ones.
fn windows(set: &str) -> Vec<Vec<TracedScene>> {
    let frames = read(&folder().join("swing"), set).expect("the repository holds the set");
    let number = |frame: &TracedScene| -> u32 {
        frame.truth.name.rsplit('-').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    frames.chunk_by(|one, next| number(next) == number(one) + 1).map(<[TracedScene]>::to_vec).collect()
}

/// Reads windows under each error of the stated distance.
fn figures(windows: &[Vec<TracedScene>], faults: &Faults) -> Figures {
    let mut all = Figures::default();
    for (window, error_m) in windows.iter().flat_map(|window| DISTANCE_ERRORS_M.map(|error| (window, error)))
    {
        let stated = settings(&window[0].truth);
        let stated = Settings { camera_distance_m: stated.camera_distance_m + error_m, ..stated };
        let config = Config::new(stated).expect("sound settings");
        let mut state = ExtractionState::new();
        for (frame, scene) in (0_u32..).zip(window) {
            let pair = degrade(scene, WIDTH, faults, frame.into());
            let stamp = Stamp { sequence: frame, captured: Micros(16_667 * u64::from(frame)) };
            let depth = DepthFrame { bytes: &pair.depth, width: WIDTH, height: HEIGHT, stamp };
            let outline = OutlineFrame { bytes: &pair.infrared, width: WIDTH, height: HEIGHT, stamp };
            all.frames += 1;
            let Ok(profile) = extract(&config, &mut state, depth, outline) else { continue };
            all.profiles += 1;
            all.points.extend((0..POINTS).filter_map(|i| {
                let half_mm = 1e3 * f64::from(profile.interval_m(i)?);
                Some(Point {
                    error_mm: 1e3 * f64::from(profile.height_m[i]) - scene.truth.contact_line_mm[i],
                    half_mm,
                })
            }));
        }
    }
    all
}

/// Returns the errors of the best flat surface of each frame, in intervals of this half width.
fn flat(windows: &[Vec<TracedScene>], half_mm: f64) -> Figures {
    let of = |scene: &TracedScene| {
        let line = scene.truth.contact_line_mm;
        let mean = line.iter().sum::<f64>() / line.len() as f64;
        line.map(|height| Point { error_mm: mean - height, half_mm })
    };
    Figures { points: windows.iter().flatten().flat_map(of).collect(), frames: 1, profiles: 1 }
}

#[test]
fn water_in_a_swing_is_read_within_the_targets() {
    for set in ["develop", JUDGED] {
        let windows = windows(set);
        for window in &windows {
            let lines = window.iter().flat_map(|scene| scene.truth.contact_line_mm);
            let (low, high) = lines.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
            let name = &window[0].truth.name;
            println!("from {name} on: {} frames, a line from {low:.1} to {high:.1} mm", window.len());
        }
        let read = figures(&windows, &Faults::default());
        read.print(set);
        assert!(read.pass(), "{set}");
        let half_mm = read.points.iter().map(|point| point.half_mm).sum::<f64>() / read.points.len() as f64;
        let flat = flat(&windows, half_mm);
        flat.print("  flat");
        assert!(!flat.pass() && flat.rms_mm() > 2.0 * read.rms_mm(), "{set}");
    }
}

#[test]
fn a_cameras_faults_cost_less_than_the_target_in_a_swing() {
    for (name, faults) in [
        ("dots of 60 grey", Faults { dots: 60.0, ..Faults::default() }),
        ("noise of 4 grey", Faults { grey_rms: 4.0, ..Faults::default() }),
        ("smear of 3 px", Faults { smear_px: 3, ..Faults::default() }),
    ] {
        let read = figures(&windows(JUDGED), &faults);
        read.print(name);
        assert!(read.rms_mm() <= 0.8 && read.seen() >= 0.9, "{name}");
    }
}
