//! Edge points as points of the wall that faces the camera, with a depth image or without one.
//!
//! Without a depth image nothing measures the wall. Its distance is the stated one then, and the standard deviation of
//! that goes into the variance of every height ([`Settings::distance_std_m`](super::Settings)). Nothing tells either
//! whether the edge is that of the liquid at the wall: something before the glass passes for it, and so does liquid that
//! rises behind the contact line in the liquid's own tone.

use super::config::Config;
use super::edge_points::{Edge, EdgePoint, Sample, Samples};
use super::refraction::{GlassWall, InnerPoint};

/// Standard deviation of the border of liquid behind, as a share of a row and of its thickness.
const BORDER_ROWS: f32 = 0.25;
const BORDER_SHARE: f32 = 0.15;

/// Position of the glass and its wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    pub(super) axis_m: f32,
    pub(super) wall: GlassWall,
}

/// Readings of the wall in the depth image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Wall {
    /// `r0`, the wall's distance beyond the stated one, metres.
    pub(super) offset_m: f32,
    /// Standard error of `r0`, metres.
    pub(super) scatter_m: f32,
}

/// An edge point and the rows by which the depth image has lowered it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowered {
    pub(super) point: EdgePoint,
    pub(super) rows: f32,
}

/// Places every edge point at the stated distance.
pub(super) fn at_stated_distance(config: &Config, glass: Glass, edge: &Edge, samples: &mut Samples) -> Wall {
    samples.clear();
    for &point in edge {
        if let Some(sample) = sample(config, glass, 0.0, Lowered { point, rows: 0.0 }) {
            let _ = samples.push(sample);
        }
    }
    Wall { offset_m: 0.0, scatter_m: config.settings.distance_std_m }
}

/// Point of the wall, `offset_m` beyond the stated distance, at which an edge point is seen; `None` beside the glass.
pub(super) fn sample(config: &Config, glass: Glass, offset_m: f32, lowered: Lowered) -> Option<Sample> {
    let (camera, Glass { axis_m, wall }, Lowered { point, rows }) = (&config.camera, glass, lowered);
    let ray = camera.ray(point.column as f32, point.row);
    let (x_m, z_m) = if wall.bends() {
        let InnerPoint { x_m, z_m } = wall.inner_point(config, ray, axis_m, offset_m)?;
        (x_m, z_m)
    } else {
        // The ray of an outermost column, half covered, may pass beside the glass.
        let wall_m = camera.wall_depth(ray, axis_m)?;
        let (x_m, z_m) = camera.point(ray, wall_m + offset_m);
        (x_m - axis_m, z_m)
    };
    let border = if rows > 0.0 { (BORDER_ROWS + BORDER_SHARE * rows) * camera.pitch_m() } else { 0.0 };
    let pitch_m = camera.pitch_m();
    let faint = if point.moved.faint { 1.0 } else { 0.0 };
    Some(Sample {
        x_m,
        z_m,
        rise: camera.rise(ray),
        own_m2: border * border + point.own_px2 * pitch_m * pitch_m,
        lowered_m: (rows + point.moved.rows) * pitch_m,
        faint_m: faint * point.moved.rows * pitch_m,
        faint_m2: faint * point.moved.variance_px2 * pitch_m * pitch_m,
    })
}
