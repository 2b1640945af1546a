//! Where the glass is: the left and right silhouette of the liquid below its surface, sub-pixel.
//!
//! Every row gives its own position of the axis; the mean of those near the median is taken, because
//! the position will be differentiated twice to give the acceleration.
//!
//! At the start both sides must be seen, as far apart as the glass is wide. Once the glass is tracked,
//! one side will do if the other is covered: the one that lies where the last position puts it. A
//! highlight that splits the body of liquid is bridged.

use super::binarise::Threshold;
use super::config::{Config, MAX_COLUMNS, THICKEST_WALL_M};
use super::deproject::{Camera, Side};
use super::edge::{REACH, SPAN, inside_pixels};
use super::region::{Grey, Region};
use super::settings::Liquid;
use crate::math;
use heapless::Vec;

/// Most rows that are averaged.
const MAX_ROWS: usize = 128;
/// Fewest rows that make a position.
const LEAST_ROWS: usize = 8;
/// A row whose axis is farther from the median than this is an outlier (about 0.3 pixel).
const ROW_TOLERANCE_M: f32 = 3e-4;
/// The same beside a clear liquid, whose sides are a third as strong and carry the images of lamps.
const CLEAR_TOLERANCE_M: f32 = 1e-3;

/// The two positions that the sides of one row give may differ by this much; a wall of unknown thickness moves them
/// apart by twice that.
const SIDES_TOLERANCE_M: f32 = 4.5e-3;
/// Widest highlight that is bridged, as a share of the glass's width.
const BRIDGE: f32 = 0.25;
/// A side of a partly covered glass lies this near to where the last position puts it, pixels.
const TRACKED_PX: f32 = 8.0;

/// Glass as its silhouette places it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Silhouette {
    /// Position of the axis, metres.
    pub(super) axis_m: f32,
    /// Radius of the cylinder whose silhouette it is, metres; `None` if one side alone was seen.
    pub(super) radius_m: Option<f32>,
}

/// Silhouette of the last frame, where there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Tracked {
    /// Position of the axis, metres.
    pub(super) axis_m: Option<f32>,
    /// Radius of the outer wall, metres.
    pub(super) radius_m: Option<f32>,
    /// Error of the stated distance, metres.
    pub(super) offset_m: f32,
}

/// First and last column whose foot is liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    pub(super) left: usize,
    pub(super) right: usize,
    /// Whether the left and the right end are sides of the glass.
    sides: [bool; 2],
    /// Row to which the columns belong.
    row: f32,
    /// Approximate position of the axis, metres.
    near_m: f32,
    /// Radius of the cylinder whose sides are seen, metres, and the distance of its axis.
    radius_m: f32,
    distance_m: f32,
}

impl Body {
    /// Standard deviation of the pixels in the foot, from the differences of neighbours in a column:
    /// the median of `|d|` is 0.954 of it.
    pub(super) fn noise(self, image: Grey<'_>, rows: (usize, usize)) -> f32 {
        let (top, bottom) = rows;
        let row = top + bottom.saturating_sub(top) / 2;
        let differences = (self.left..=self.right).filter_map(|column| {
            let [one, other] = [image.at(column, row)?, image.at(column, row + 1)?].map(f32::from);
            Some((one - other).abs())
        });
        math::median(differences).unwrap_or(0.0) / 0.954
    }
}

/// The longest run of columns that hold mostly liquid in the rows of the foot, if it is as wide as
/// the glass (within a fifth), or if one of its ends is where the glass at `tracked_m` has it.
pub(super) fn find(
    config: &Config,
    image: Grey<'_>,
    region: Region,
    threshold: &Threshold,
    tracked: Tracked,
) -> Option<Body> {
    let (top, bottom) = config.foot_rows;
    let mut liquid = [0_usize; MAX_COLUMNS];
    for row in top..bottom {
        for (count, &grey) in liquid.iter_mut().zip(image.row(row, region.left, region.right)) {
            *count += usize::from(threshold.is_liquid(grey));
        }
    }
    let most = bottom.saturating_sub(top) / 2;
    let bridge = (BRIDGE * config.silhouette_px) as usize;
    let mut best: Option<(usize, usize)> = None;
    let mut run: Option<(usize, usize)> = None;
    for (column, &count) in (region.left..region.right).zip(liquid.iter()) {
        if count <= most {
            continue;
        }
        let begun = run.filter(|(_, last)| column - last <= bridge + 1).map_or(column, |(first, _)| first);
        run = Some((begun, column));
        if best.is_none_or(|(first, last)| column - begun > last.saturating_sub(first)) {
            best = run;
        }
    }
    let (left, right) = best?;
    let row = 0.5 * (top + bottom) as f32;
    let camera = &config.camera;
    let bearing = |u: f32| camera.bearing(camera.ray(u, row));
    let [l, r] = [bearing(left as f32 - 0.5), bearing(right as f32 + 0.5)];
    let width_px = (right.saturating_sub(left) + 1) as f32;
    let settings = &config.settings;
    let radius_m = settings.wall_m.map_or(settings.radius_m, |wall_m| settings.radius_m + wall_m);
    let body = Body {
        left,
        right,
        sides: [true; 2],
        row,
        near_m: camera.axis_of(l, r),
        radius_m,
        distance_m: settings.camera_distance_m + tracked.offset_m,
    };
    let wall_px = width_px * (settings.wall_m.unwrap_or(THICKEST_WALL_M) / settings.radius_m);
    if (-0.2 * config.silhouette_px..0.2 * config.silhouette_px + wall_px)
        .contains(&(width_px - config.silhouette_px))
    {
        return Some(body);
    }
    let near_m = tracked.axis_m.filter(|_| width_px < config.silhouette_px)?;
    let pixel_m = settings.camera_distance_m / settings.intrinsics.fx;
    let radius_m = tracked.radius_m.unwrap_or(radius_m);
    let beside = |edge, sign| {
        (camera.axis_beside(edge, Side { sign, radius_m }, near_m) - near_m).abs() < TRACKED_PX * pixel_m
    };
    let sides = [beside(l, -1.0), beside(r, 1.0)];
    (sides[0] || sides[1]).then_some(Body { sides, near_m, radius_m, ..body })
}

/// Position of the glass from rows (first, behind the last) that all hold liquid.
pub(super) fn axis(
    config: &Config,
    image: Grey<'_>,
    body: Body,
    rows: (usize, usize),
    least: f32,
) -> Option<Silhouette> {
    let (top, bottom) = rows;
    let mut axes: Vec<f32, MAX_ROWS> = Vec::new();
    let mut radii: Vec<f32, MAX_ROWS> = Vec::new();
    for row in top..bottom {
        if let Some(seen) = row_axis(config, image, body, row, least) {
            // A full list is long enough.
            if axes.push(seen.axis_m).is_err() {
                break;
            }
            if let Some(radius_m) = seen.radius_m {
                let _ = radii.push(radius_m);
            }
        }
    }
    let median = math::median(axes.iter().copied())?;
    let tolerance_m =
        if config.settings.liquid == Liquid::Clear { CLEAR_TOLERANCE_M } else { ROW_TOLERANCE_M };
    let near = || axes.iter().filter(|axis| (*axis - median).abs() < tolerance_m);
    let count = near().count();
    (count >= LEAST_ROWS).then(|| Silhouette {
        axis_m: near().sum::<f32>() / count as f32,
        radius_m: math::median(radii.iter().copied()),
    })
}

/// The glass as one row sees it.
fn row_axis(config: &Config, image: Grey<'_>, body: Body, row: usize, least: f32) -> Option<Silhouette> {
    let camera = &config.camera;
    // A pitched camera sees the sides of an upright glass aslant.
    let place = |column: usize| camera.follow(column as f32, body.row, row as f32).max(0.0) as usize;
    let bearing = |u| camera.bearing(camera.ray(u, row as f32));
    // From inside to outside: to the left from REACH - 1 columns right of the first liquid column.
    let left = || {
        let start = place(body.left).saturating_add(REACH - 1);
        let across = profile(image.row(row, (start + 1).checked_sub(SPAN)?, start + 1).iter().rev())?;
        Some(bearing(start as f32 + 0.5 - inside_pixels(&across, least)?))
    };
    let right = || {
        let start = (place(body.right) + 1).checked_sub(REACH)?;
        let across = profile(image.row(row, start, start + SPAN).iter())?;
        Some(bearing(start as f32 - 0.5 + inside_pixels(&across, least)?))
    };
    let beside =
        |edge, sign, near_m| camera.axis_beside(edge, Side { sign, radius_m: body.radius_m }, near_m);
    let one_side = |axis_m| Silhouette { axis_m, radius_m: None };
    match body.sides {
        [true, true] => {
            let (left, right) = (left()?, right()?);
            let axis_m = camera.axis_of(left, right);
            let apart_m = beside(left, -1.0, axis_m) - beside(right, 1.0, axis_m);
            let wall_m = if config.settings.wall_m.is_some() { 0.0 } else { THICKEST_WALL_M };
            let radius_m = Camera::silhouette_radius([left, right], [axis_m, body.distance_m]);
            (-SIDES_TOLERANCE_M - 2.0 * wall_m..SIDES_TOLERANCE_M)
                .contains(&apart_m)
                .then_some(Silhouette { axis_m, radius_m: Some(radius_m) })
        }
        [true, false] => Some(one_side(beside(left()?, -1.0, body.near_m))),
        _ => Some(one_side(beside(right()?, 1.0, body.near_m))),
    }
}

/// A profile of grey levels, if the image has all its pixels.
fn profile<'a>(pixels: impl ExactSizeIterator<Item = &'a u8>) -> Option<[f32; SPAN]> {
    let mut profile = [0.0; SPAN];
    if pixels.len() != SPAN {
        return None;
    }
    profile.iter_mut().zip(pixels).for_each(|(to, &grey)| *to = f32::from(grey));
    Some(profile)
}
