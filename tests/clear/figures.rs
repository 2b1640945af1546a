//! Errors of the reader over several scenes.

use meniscus::surface::Settings;
use meniscus_virtual::camera_study::judge::Point;
use meniscus_virtual::camera_study::traced::degrade::Faults;
use meniscus_virtual::camera_study::traced::judge::{FRAMES, read_scene};
use meniscus_virtual::camera_study::traced::set::TracedScene;

/// Errors of the stated distance, metres: root mean square 3 mm, as the settings state it.
pub(crate) const DISTANCE_ERRORS_M: [f32; 7] = [-0.0045, -0.003, -0.0015, 0.0, 0.0015, 0.003, 0.0045];

/// Readings of several scenes.
#[derive(Default)]
pub(crate) struct Figures {
    pub(crate) points: Vec<Point>,
    pub(crate) frames: u64,
    pub(crate) profiles: u64,
}

impl Figures {
    /// Reads each scene with each error of its stated distance.
    pub(crate) fn of(scenes: &[TracedScene], faults: &Faults) -> Self {
        let mut all = Self::default();
        for (scene, error_m) in scenes.iter().flat_map(|s| DISTANCE_ERRORS_M.map(|error| (s, error))) {
            let elsewhere = |s: Settings| Settings { camera_distance_m: s.camera_distance_m + error_m, ..s };
            let read = read_scene(scene, faults, &elsewhere).expect("sound settings");
            all.points.extend(read.points);
            all.frames += FRAMES;
            all.profiles += u64::from(read.profiles);
        }
        all
    }

    pub(crate) fn rms_mm(&self) -> f64 {
        (self.points.iter().map(|point| point.error_mm.powi(2)).sum::<f64>() / self.points.len() as f64)
            .sqrt()
    }

    fn bias_mm(&self) -> f64 {
        self.points.iter().map(|point| point.error_mm).sum::<f64>() / self.points.len() as f64
    }

    fn inside(&self) -> f64 {
        let inside = self.points.iter().filter(|point| point.error_mm.abs() <= point.half_mm).count();
        inside as f64 / self.points.len() as f64
    }

    pub(crate) fn seen(&self) -> f64 {
        self.profiles as f64 / self.frames as f64
    }

    /// Whether all targets are met.
    pub(crate) fn pass(&self) -> bool {
        self.rms_mm() <= 0.8 && self.seen() >= 0.9 && (0.9..=0.98).contains(&self.inside())
    }

    pub(crate) fn print(&self, name: &str) {
        println!(
            "{name}: rms {:.3} mm, bias {:+.3} mm, inside {:.3}, seen in {} of {} frames",
            self.rms_mm(),
            self.bias_mm(),
            self.inside(),
            self.profiles,
            self.frames
        );
    }
}
