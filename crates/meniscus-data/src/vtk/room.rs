//! Pose of the glass: from its frame to the room.
//!
//! ```text
//! X = x_g + R(tilt) (x - p) + p        p pivot, R turns about y: a tilt towards +x lowers that side
//! ```

use crate::recording::Recording;

/// Position and inclination of the glass at one frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose {
    moved_m: [f64; 3],
    pivot_m: [f64; 2],
    sin: f64,
    cos: f64,
}

impl Pose {
    /// Returns the pose at `frame` of `recording`.
    pub(super) fn of(recording: &Recording, frame: usize) -> Self {
        let at = |channel: &[f64]| channel.get(frame).copied().unwrap_or(0.0);
        let (sin, cos) = at(&recording.tilt_rad).sin_cos();
        Self {
            moved_m: [at(&recording.glass_x_m), at(&recording.glass_y_m), at(&recording.glass_z_m)],
            pivot_m: recording.provenance.pivot_m,
            sin,
            cos,
        }
    }

    /// Returns the place in the room of the place `x` in the glass, m.
    pub(super) fn place(&self, x: [f64; 3]) -> [f32; 3] {
        let [across, along, up] = self.turn([x[0] - self.pivot_m[0], x[1], x[2] - self.pivot_m[1]]);
        let in_room = [across + self.pivot_m[0], along, up + self.pivot_m[1]];
        std::array::from_fn(|i| (in_room[i] + self.moved_m[i]) as f32)
    }

    /// Returns the vector `v` of the glass in the axes of the room.
    fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        [self.cos * v[0] + self.sin * v[2], v[1], self.cos * v[2] - self.sin * v[0]]
    }
}
