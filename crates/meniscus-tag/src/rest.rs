//! Pose of the tag at rest, and the largest distances from it.
//!
//! The tag is at rest where the positions of half a second lie within a millimetre of their mean. The mean of those poses is where
//! lift, path and inclination count from.

use crate::pose::TagPose;
use meniscus_service::commanded_motion::TagTravel;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// Images that have to agree.
const IMAGES: usize = 30;
/// Distance from their mean, m.
const STILL_M: f64 = 0.001;

/// Finds the rest, and then follows the distance from it.
#[derive(Clone, Debug)]
pub struct Rest {
    /// Sine and cosine of the camera's pitch, positive when it looks up.
    pitch: (f64, f64),
    /// Candidates, in the order of the images.
    poses: Vec<TagPose>,
    found: Option<(UnitQuaternion<f64>, Vector3<f64>)>,
    travel: TagTravel,
}

impl Rest {
    /// Returns a rest that is not known yet, before a camera of this pitch.
    #[must_use]
    pub fn unknown(pitch_rad: f64) -> Self {
        let (poses, travel) = (Vec::with_capacity(IMAGES), TagTravel::default());
        Self { pitch: pitch_rad.sin_cos(), poses, found: None, travel }
    }

    /// Returns the largest distances so far; `None` before the rest.
    #[must_use]
    pub fn travel(&self) -> Option<TagTravel> {
        self.found.map(|_| self.travel)
    }

    /// Takes the pose of the next image.
    pub fn take(&mut self, pose: &TagPose) {
        match self.found {
            Some(rest) => self.follow(rest, pose),
            None => self.look(pose),
        }
    }

    fn look(&mut self, pose: &TagPose) {
        if self.poses.len() == IMAGES {
            self.poses.remove(0);
        }
        self.poses.push(*pose);
        let mean =
            self.poses.iter().map(|pose| pose.position_m).sum::<Vector3<f64>>() / self.poses.len() as f64;
        let is_still = self.poses.iter().all(|pose| (pose.position_m - mean).norm() < STILL_M);
        if self.poses.len() == IMAGES && is_still {
            self.found = Some((mean_of(&self.poses), mean));
        }
    }

    /// Of a vector in the camera's axes (right, down, forward): right as it is, away = d cos + w sin, up = d sin - w cos, with w
    /// down and d forward.
    fn follow(&mut self, (rotation, position_m): (UnitQuaternion<f64>, Vector3<f64>), pose: &TagPose) {
        let (sin, cos) = self.pitch;
        let [right, down, forward]: [f64; 3] = (pose.position_m - position_m).into();
        let [turn_std, place_std] = pose.std();
        let travel = &mut self.travel;
        let larger = |largest: &mut f64, value: f64| *largest = largest.max(value.abs());
        larger(&mut travel.along_mm, 1e3 * right);
        larger(&mut travel.away_mm, 1e3 * (forward * cos + down * sin));
        larger(&mut travel.lift_mm, 1e3 * (forward * sin - down * cos));
        larger(&mut travel.position_std_mm, 1e3 * place_std);
        if pose.other.is_none() {
            let normal = |rotation: &UnitQuaternion<f64>| rotation * Vector3::z();
            larger(
                &mut travel.inclination_deg,
                normal(&rotation).angle(&normal(&pose.rotation)).to_degrees(),
            );
            larger(&mut travel.attitude_std_deg, turn_std.to_degrees());
        }
    }
}

/// Mean of attitudes that are near each other: their quaternions, on the side of the first one, summed and made unit again.
fn mean_of(poses: &[TagPose]) -> UnitQuaternion<f64> {
    let sum = poses.iter().fold(Quaternion::new(0.0, 0.0, 0.0, 0.0), |sum, pose| {
        let next = pose.rotation.into_inner();
        if next.dot(&sum) < 0.0 { sum - next } else { sum + next }
    });
    UnitQuaternion::new_normalize(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix6;

    fn at(position_m: [f64; 3], pitch: f64) -> TagPose {
        TagPose {
            rotation: UnitQuaternion::from_euler_angles(pitch, 0.0, 0.0),
            position_m: position_m.into(),
            covariance: Matrix6::identity() * 1e-8,
            other: None,
        }
    }

    #[test]
    fn distances_count_from_the_rest_and_along_the_axes_of_the_room() {
        // The camera looks down by 0.2 rad.
        let mut rest = Rest::unknown(-0.2);
        for n in 0..20 {
            rest.take(&at([0.01 * f64::from(n), 0.0, 0.4], 0.0));
        }
        assert_eq!(rest.travel(), None, "it moves");
        for _ in 0..IMAGES {
            rest.take(&at([0.0, 0.0, 0.4], 0.1));
        }
        assert!(rest.travel().is_some());
        // 10 mm up in the room: the camera's down is (cos, sin) of 0.2 rad there.
        let up = [0.0, -0.010 * 0.2_f64.cos(), 0.4 - 0.010 * 0.2_f64.sin()];
        rest.take(&at(up, 0.15));
        let travel = rest.travel().expect("at rest");
        assert!(
            (travel.lift_mm - 10.0).abs() < 1e-9 && travel.away_mm < 1e-9 && travel.along_mm < 1e-9,
            "{travel:?}"
        );
        assert!((travel.inclination_deg - 0.05_f64.to_degrees()).abs() < 1e-6, "{travel:?}");
        assert!((travel.position_std_mm - 0.1).abs() < 1e-9, "{travel:?}");
    }
}
