//! Messages as nalgebra's rotations and rigid transforms.

use crate::message::{Point, Quaternion, Vector3};
use meniscus_service::commanded_motion::SampleFault;
use nalgebra::{Isometry3, Quaternion as Numbers, UnitQuaternion};

/// Difference of the length from one that rounding explains: that of tf2.
const LENGTH_TOLERANCE: f64 = 0.01;

/// Returns the rotation of `q`; a quaternion that is not of unit length is refused.
pub(crate) fn rotation(q: Quaternion) -> Result<UnitQuaternion<f64>, SampleFault> {
    let numbers = Numbers::new(q.w, q.x, q.y, q.z);
    let length = numbers.norm();
    if !length.is_finite() {
        return Err(SampleFault::Malformed("a number of its quaternion is not finite".into()));
    }
    if (length - 1.0).abs() > LENGTH_TOLERANCE {
        return Err(SampleFault::Rotation(length));
    }
    Ok(UnitQuaternion::new_normalize(numbers))
}

/// Returns the transform at `share` of the way between two, which turn by less than half a turn; a larger one keeps the first rotation.
pub(crate) fn between(from: &Isometry3<f64>, to: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    let translation = from.translation.vector.lerp(&to.translation.vector, share);
    from.try_lerp_slerp(to, share, f64::EPSILON)
        .unwrap_or_else(|| Isometry3::from_parts(translation.into(), from.rotation))
}

/// Returns the numbers of a vector.
pub(crate) fn vector(v: Vector3) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// Returns the numbers of a point.
pub(crate) fn point(p: Point) -> [f64; 3] {
    [p.x, p.y, p.z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Translation3, Vector3 as Numbers3};

    #[test]
    fn the_parts_of_a_message_are_in_their_places() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let quarter = rotation(Quaternion { x: 0.0, y: 0.0, z: half, w: half }).expect("of unit length");
        let turned = quarter * Numbers3::new(1.0, 0.0, 0.5);
        assert!((turned - Numbers3::new(0.0, 1.0, 0.5)).norm() < 1e-12, "{turned}");
        let start = Isometry3::identity();
        let end = Isometry3::from_parts(Translation3::new(0.2, 0.0, 0.0), quarter);
        let middle = between(&start, &end, 0.5);
        assert!((middle.translation.x - 0.1).abs() < 1e-12);
        assert!((middle.rotation.angle() - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    }

    #[test]
    fn a_quaternion_of_another_length_is_refused() {
        let of = |w: f64| rotation(Quaternion { x: 0.0, y: 0.0, z: 0.0, w });
        assert!(of(1.005).is_ok_and(|rotation| rotation.angle() < 1e-12));
        assert_eq!(of(0.5), Err(SampleFault::Rotation(0.5)));
        assert_eq!(of(0.0), Err(SampleFault::Rotation(0.0)));
        assert!(matches!(of(f64::NAN), Err(SampleFault::Malformed(_))));
    }
}
