//! The liquid in space: where the glass and the camera are, the surface on the wall.
//!
//! Frames: `world`, with the axis of the glass at x = 0 where the camera's range has its middle, y away from the
//! camera, z up from the inner bottom; `glass`, the same carried along with the glass; `camera`.

use super::{camera, name};
use ::foxglove::messages::line_primitive::Type as LineType;
use ::foxglove::messages::{
    Color, CylinderPrimitive, FrameTransform, LinePrimitive, Point3, Pose, Quaternion, SceneEntity,
    SceneUpdate, SpherePrimitive, Timestamp, Vector3,
};
use meniscus::blob::Model;
use meniscus::surface::{Config, profile_abscissa};
use meniscus_service::timed_turn::TimedTurn;

const WORLD: &str = "world";
pub(super) const GLASS: &str = "glass";

/// Colours after Okabe and Ito (2008): what was estimated, what was measured, the glass.
const ESTIMATED: Color = Color { r: 0.0, g: 0.447, b: 0.698, a: 1.0 };
const MEASURED: Color = Color { r: 0.902, g: 0.624, b: 0.0, a: 1.0 };
const WALL: Color = Color { r: 0.7, g: 0.8, b: 0.9, a: 0.15 };

/// Where the glass is; `None` where its edges were not found: a place that nobody knows is not claimed.
pub(super) fn glass(logged: &TimedTurn, stamp: Timestamp) -> Option<FrameTransform> {
    let x = logged.turn.profile?.ok()?.glass_x_m?;
    Some(FrameTransform {
        timestamp: Some(stamp),
        parent_frame_id: name(WORLD),
        child_frame_id: name(GLASS),
        translation: Some(Vector3 { x: f64::from(x), y: 0.0, z: 0.0 }),
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    })
}

/// Where the camera stands and looks: its axes follow from the world's by a turn of `pitch - 90 deg` about x.
pub(super) fn stand(config: &Config, stamp: Timestamp) -> FrameTransform {
    let settings = config.settings();
    let half = 0.5 * (f64::from(settings.camera_pitch_rad) - std::f64::consts::FRAC_PI_2);
    FrameTransform {
        timestamp: Some(stamp),
        parent_frame_id: name(WORLD),
        child_frame_id: name(camera::FRAME),
        translation: Some(Vector3 {
            x: 0.0,
            y: -f64::from(settings.camera_distance_m),
            z: f64::from(settings.camera_height_m),
        }),
        rotation: Some(Quaternion { x: half.sin(), y: 0.0, z: 0.0, w: half.cos() }),
    }
}

/// The glass, the estimated edge of the liquid on its wall with its interval, and the measured points.
pub(super) fn surface(
    model: &Model<'_>,
    config: &Config,
    logged: &TimedTurn,
    stamp: Timestamp,
) -> SceneUpdate {
    let (header, estimate) = (&model.header, &logged.turn.estimate);
    let on_wall = |point: usize, z: f32| {
        let [x, y, z] = config.wall_point(profile_abscissa(point) as f32, z).map(f64::from);
        Point3 { x, y, z }
    };
    let line = |side: f32, thickness: f64| LinePrimitive {
        r#type: LineType::LineStrip as i32,
        pose: Some(here([0.0; 3])),
        thickness,
        scale_invariant: true,
        points: estimate
            .surface_m
            .iter()
            .zip(&estimate.interval.surface_m)
            .enumerate()
            .map(|(point, (z, half))| on_wall(point, z + side * half))
            .collect(),
        color: Some(ESTIMATED),
        ..LinePrimitive::default()
    };
    let measured = logged.turn.profile.and_then(Result::ok).map(|profile| {
        let seen =
            profile.height_m.into_iter().zip(profile.valid).enumerate().filter(|(_, (_, valid))| *valid);
        let sphere = |(point, (z, _)): (usize, (f32, bool))| {
            let at = on_wall(point, z);
            SpherePrimitive {
                pose: Some(here([at.x, at.y, at.z])),
                size: Some(Vector3 { x: 1.2e-3, y: 1.2e-3, z: 1.2e-3 }),
                color: Some(MEASURED),
            }
        };
        seen.map(sphere).collect::<Vec<_>>()
    });
    let entity = |id: &str| SceneEntity {
        timestamp: Some(stamp),
        frame_id: name(GLASS),
        id: name(id),
        frame_locked: true,
        ..SceneEntity::default()
    };
    let wall = CylinderPrimitive {
        pose: Some(here([0.0, 0.0, 0.5 * header.rim_m])),
        size: Some(Vector3 { x: 2.0 * header.radius_m, y: 2.0 * header.radius_m, z: header.rim_m }),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(WALL),
    };
    let entities = vec![
        SceneEntity { cylinders: vec![wall], ..entity("glass") },
        SceneEntity { lines: vec![line(0.0, 3.0), line(1.0, 1.0), line(-1.0, 1.0)], ..entity("estimated") },
        // An entity that comes again takes the place of the old one: nothing seen leaves no points standing.
        SceneEntity { spheres: measured.unwrap_or_default(), ..entity("measured") },
    ];
    SceneUpdate { deletions: Vec::new(), entities }
}

/// A place, unturned.
pub(super) fn here([x, y, z]: [f64; 3]) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::surface::Settings;

    fn rotated(by: &Quaternion, [x, y, z]: [f64; 3]) -> [f64; 3] {
        // A turn about x alone.
        let (sine, cosine) = (2.0 * by.x * by.w, by.w * by.w - by.x * by.x);
        [x, cosine * y - sine * z, sine * y + cosine * z]
    }

    #[test]
    fn the_camera_looks_along_y_and_up_by_its_pitch() {
        let pitch = 0.1_f32;
        let config = Config::new(Settings { camera_pitch_rad: pitch, ..Settings::default() }).expect("sound");
        let stand = stand(&config, Timestamp::new(0, 0));
        let turn = stand.rotation.expect("it is turned");
        let [_, y, z] = rotated(&turn, [0.0, 0.0, 1.0]);
        assert!((y - f64::from(pitch).cos()).abs() < 1e-9 && (z - f64::from(pitch).sin()).abs() < 1e-9);
        let [_, y, z] = rotated(&turn, [0.0, 1.0, 0.0]);
        assert!(z < -0.99 && y > 0.0, "down in the image is down in the room");
        // A point of the room, by this frame and the pinhole, is where the configuration sees it.
        let (point, at) = ([0.01_f64, -0.02, 0.05], stand.translation.expect("it stands"));
        let away = [point[0] - at.x, point[1] - at.y, point[2] - at.z];
        let back = Quaternion { x: -turn.x, ..turn };
        let [x, y, z] = rotated(&back, away);
        let lens = config.settings().intrinsics;
        let (u, v) = config.pixel_of(point.map(|x| x as f32));
        assert!((f64::from(lens.fx) * x / z + f64::from(lens.ppx) - f64::from(u)).abs() < 0.05);
        assert!((f64::from(lens.fy) * y / z + f64::from(lens.ppy) - f64::from(v)).abs() < 0.05);
    }
}
