//! Parts of pictures and films of a run: the camera's image, and a slice through the glass.

use crate::picture::{CameraImage, Slice, SliceTracer};
use meniscus::blob::{FieldGroup, KnownGroups};
use meniscus::runtime::Turn;
use meniscus::surface::{Config, profile_abscissa};
use meniscus_data::recording::{LAYERS, Lattice, Recording, TRACERS, group_range};

/// Half the thickness of the slice through the middle of the glass, in units of the radius.
const SLICE: f64 = 0.12;

/// Pixels around the glass that the camera panel shows.
const MARGIN: usize = 24;

/// The camera's image `infrared` of `frame`, with the measured and the estimated profile of `turn` on it.
#[must_use]
pub fn camera<'s>(
    config: &Config,
    recording: &Recording,
    infrared: &'s [u8],
    turn: &Turn,
    frame: usize,
) -> CameraImage<'s> {
    let pixel = |point: usize, height: f32, glass_x: f32| {
        let [x, y, z] = config.wall_point(profile_abscissa(point) as f32, height);
        config.pixel_of([x + glass_x, y, z])
    };
    let seen = turn.profile.and_then(Result::ok);
    let glass_x = seen.and_then(|profile| profile.glass_x_m).unwrap_or(recording.glass_x_m[frame] as f32);
    let measured = seen.map_or(vec![], |profile| {
        let points = profile.height_m.iter().zip(profile.valid).enumerate();
        points.filter(|(_, (_, valid))| *valid).map(|(k, (z, _))| pixel(k, *z, glass_x)).collect()
    });
    let heights = turn.estimate.surface_m.iter().enumerate();
    let estimated = heights.map(|(k, z)| pixel(k, *z, glass_x)).collect();
    let size = config.image_size();
    let glass = &recording.glass;
    let (radius, rim) = (glass.radius_m as f32, glass.rim_m as f32);
    let (left, top) = config.pixel_of([glass_x - radius, -radius, rim]);
    let (right, bottom) = config.pixel_of([glass_x + radius, -radius, 0.0]);
    let inside = |at: f32, most: usize| (at.max(0.0) as usize).min(most);
    let (left, top) =
        (inside(left, size.0).saturating_sub(MARGIN), inside(top, size.1).saturating_sub(MARGIN));
    let (right, bottom) = (inside(right, size.0) + MARGIN, inside(bottom, size.1) + MARGIN);
    let crop = (left, top, right.min(size.0) - left, bottom.min(size.1) - top);
    CameraImage { infrared, size, measured, estimated, crop }
}

/// Tracers near the plane y = 0 with their speed, m/s, from the `known` groups of a full `state`; none without positions.
#[must_use]
pub fn slice(lattice: &Lattice, recording: &Recording, known: KnownGroups, state: &[f32]) -> Slice {
    if !known.contains(FieldGroup::Position) {
        return Slice::default();
    }
    let (q, v) = (&state[group_range(0)], &state[group_range(1)]);
    let near = |tracer: &usize| lattice.columns[tracer / LAYERS][1].abs() < SLICE * recording.glass.radius_m;
    let tracers = (0..TRACERS).filter(near).map(|tracer| {
        let speed = v[3 * tracer..3 * tracer + 3].iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
        SliceTracer {
            at_mm: (1e3 * f64::from(q[3 * tracer]), 1e3 * f64::from(q[3 * tracer + 2])),
            value: known.contains(FieldGroup::Velocity).then_some(speed),
        }
    });
    Slice { tracers: tracers.collect() }
}
