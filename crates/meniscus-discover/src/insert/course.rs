//! Motion of a glass that is simulated, and the particle simulator's answer to it.

use meniscus_data::motion::Motion;
use meniscus_sph::{Setup, record_surfaces};

/// Motion of a glass along x and the frames that are simulated of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Times, s, and positions, m.
    pub samples: Vec<(f64, f64)>,
    /// Frames at the camera's rate.
    pub frames: usize,
}

/// Simulates `courses` of one settled glass; returns the heights of each, frame after frame, m.
///
/// # Errors
/// In words, when a motion cannot be joined to a curve or the simulator stops.
pub(super) fn run(setup: &Setup, courses: &[&Course]) -> Result<Vec<Vec<f32>>, String> {
    let mut motions = Vec::with_capacity(courses.len());
    for course in courses {
        let motion = Motion::sampled(&course.samples).ok_or("its motion cannot be joined to a curve")?;
        motions.push((motion, course.frames, String::new()));
    }
    let recordings = record_surfaces(setup, &motions).map_err(|error| format!("{error}"))?;
    Ok(recordings.into_iter().map(|recording| recording.profile_m).collect())
}
