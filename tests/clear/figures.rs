//! Errors of the reader over several scenes.

use meniscus::surface::Settings;
use meniscus_virtual::camera_study::judge::Point;
use meniscus_virtual::camera_study::traced::degrade::Faults;
use meniscus_virtual::camera_study::traced::judge::{FRAMES, read_frames};
use meniscus_virtual::camera_study::traced::set::{TracedScene, settings};

/// Errors of the stated distance, metres: root mean square 3 mm, as the settings state it.
const DISTANCE_ERRORS_M: [f32; 7] = [-0.0045, -0.003, -0.0015, 0.0, 0.0015, 0.003, 0.0045];

/// Readings of several scenes.
#[derive(Default)]
pub(crate) struct Figures {
    pub(crate) points: Vec<Point>,
    pub(crate) frames: u64,
    pub(crate) profiles: u64,
}

impl Figures {
    /// Reads each scene a few times, with each error of its stated distance.
    pub(crate) fn of(scenes: &[TracedScene], faults: &Faults) -> Self {
        let repeated: Vec<_> = scenes.iter().map(|scene| vec![scene.clone(); FRAMES as usize]).collect();
        Self::of_windows(&repeated, faults)
    }

    /// Reads windows of frames of one glass each, with each error of its stated distance.
    pub(crate) fn of_windows(windows: &[Vec<TracedScene>], faults: &Faults) -> Self {
        let mut all = Self::default();
        for (window, error_m) in windows.iter().flat_map(|w| DISTANCE_ERRORS_M.map(|error| (w, error))) {
            let stated = settings(&window[0].truth);
            let stated = Settings { camera_distance_m: stated.camera_distance_m + error_m, ..stated };
            let read = read_frames(stated, window, faults).expect("sound settings");
            all.points.extend(read.points);
            all.frames += window.len() as u64;
            all.profiles += u64::from(read.profiles);
        }
        all
    }

    /// Returns the errors of the best flat surface of each scene, in intervals of the mean width of these.
    pub(crate) fn of_flat<'s>(&self, scenes: impl IntoIterator<Item = &'s TracedScene>) -> Self {
        let half_mm = self.points.iter().map(|point| point.half_mm).sum::<f64>() / self.points.len() as f64;
        let flat = |scene: &TracedScene| {
            let line = scene.truth.contact_line_mm;
            let mean = line.iter().sum::<f64>() / line.len() as f64;
            line.map(|height| Point { error_mm: mean - height, half_mm })
        };
        Self { points: scenes.into_iter().flat_map(flat).collect(), frames: 1, profiles: 1 }
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
