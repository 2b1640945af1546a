//! Frames: `glass`, with its origin at the inner bottom, x along the line of motion, y away from the camera, z up; and
//! `meniscus_camera`, the camera's optical frame after REP 103: x to the right of the image, y down, z away from it.
//!
//! ```text
//! t = R^T (g - c),   R = R_x(pitch - 90 deg),   g = (X, 0, 0),   c = (0, -d, h)
//! ```
//! X is the measured position of the glass, d the distance of the camera from its range, h its height above the inner bottom.

use crate::message::{GLASS, Header, Quaternion, Stamp, TransformMessage, TransformStamped, Vector3};
use meniscus::surface::Config;
use meniscus_service::timed_turn::TimedTurn;

/// Frame of the camera.
pub(crate) const CAMERA: &str = "meniscus_camera";

/// Returns the position of the glass in the camera's frame; `None` where its sides were not seen.
pub(crate) fn glass(config: &Config, logged: &TimedTurn, stamp: Stamp) -> Option<TransformMessage> {
    let x = f64::from(logged.turn.profile?.ok()?.glass_x_m?);
    let settings = config.settings();
    let (distance, height) = (f64::from(settings.camera_distance_m), f64::from(settings.camera_height_m));
    // R^T turns by 90 deg - pitch about x.
    let angle = std::f64::consts::FRAC_PI_2 - f64::from(settings.camera_pitch_rad);
    let (sine, cosine) = angle.sin_cos();
    let translation =
        Vector3 { x, y: cosine * distance + sine * height, z: sine * distance - cosine * height };
    let (x, w) = (0.5 * angle).sin_cos();
    let transform = TransformStamped {
        header: Header { stamp, frame_id: CAMERA.into() },
        child_frame_id: GLASS.into(),
        translation,
        rotation: Quaternion { x, y: 0.0, z: 0.0, w },
    };
    Some(TransformMessage { transforms: vec![transform] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
    use meniscus::surface::{POINTS, Settings, SurfaceProfile};
    use meniscus::units::Micros;
    use meniscus_platform::clock::Monotonic;
    use meniscus_platform::files::AlignedBytes;

    #[test]
    fn a_point_of_the_glass_is_where_the_camera_sees_it() {
        let settings = Settings { camera_pitch_rad: -0.2, ..Settings::default() };
        let config = Config::new(settings).expect("sound");
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let estimate = Estimator::new(&model).turn(
            &mut Memory::default(),
            TurnInput::default(),
            &mut Monotonic::start(),
            &mut [],
        );
        let profile = SurfaceProfile {
            height_m: [0.07; POINTS],
            variance_m2: [1e-8; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some(0.02),
            sequence: 0,
            captured: Micros(1),
        };
        let turn = Turn { time: Micros(1), stamp: None, profile: Some(Ok(profile)), estimate };
        let logged = TimedTurn::untimed(turn);
        let message = glass(&config, &logged, Stamp::default()).expect("it was seen");
        let [TransformStamped { translation: t, rotation: q, .. }] = &message.transforms[..] else {
            panic!("one frame");
        };
        let (sine, cosine) = (2.0 * q.x * q.w, q.w * q.w - q.x * q.x);
        // A point of the glass, by this transform and the pinhole, is where the configuration sees the room's point.
        let [x, y, z] = [0.01, -0.03, 0.05];
        let seen = [x + t.x, cosine * y - sine * z + t.y, sine * y + cosine * z + t.z];
        let lens = config.settings().intrinsics;
        let (u, v) = config.pixel_of([x as f32 + 0.02, y as f32, z as f32]);
        assert!((f64::from(lens.fx) * seen[0] / seen[2] + f64::from(lens.ppx) - f64::from(u)).abs() < 0.05);
        assert!((f64::from(lens.fy) * seen[1] / seen[2] + f64::from(lens.ppy) - f64::from(v)).abs() < 0.05);
        let unseen = TimedTurn::untimed(Turn { profile: None, ..turn });
        assert_eq!(glass(&config, &unseen, Stamp::default()), None, "a place that nobody saw is not claimed");
    }
}
