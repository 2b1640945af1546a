//! Where the camera stands, and how wide the glass is: from the body's sides and its depth.
//!
//! The wall of an upright glass that faces the camera is a vertical line at the horizontal distance `Y`; its depth
//! tells the pitch `p` (frame and letters as in `surface::deproject`):
//!
//! ```text
//! 1 / Z = (cos p + b sin p) / Y        b = (v - ppy) / fy       a straight line over the rows
//! ```
//!
//! The sides are tangent to the cylinder. With the half angle `h` between them, the axis at the distance `A`, the
//! facing wall at `F`:
//!
//! ```text
//! sin h = R / A,  F = A - R     =>     R = F sin h / (1 - sin h)
//! ```
//!
//! and a point of the facing wall in row `v` lies `Y (sin p - b cos p) / (cos p + b sin p)` above the camera.

use super::body::Body;
use super::portrait::Portrait;
use meniscus::surface::Intrinsics;
use meniscus_numerics::statistics::median;

/// Half width of the strip whose depth is taken for that of the facing wall, as a share of half the body: there it is
/// at most 0.5 % of the radius farther than on the axis.
const STRIP: f32 = 0.1;
/// Rows at either end of the body that are left out, and fewest rows that tell the pitch.
const MARGIN: usize = 4;
const LEAST_ROWS: usize = 12;
/// A row whose inverse depth is farther from the line than this many robust deviations is left out.
const OUTLIER: f64 = 4.0;
/// Columns beside the body whose depth is that of the background.
const BESIDE: std::ops::Range<usize> = 12..32;
/// A body whose depth is more than this share of its background's is looked through.
const THROUGH: f32 = 0.93;

/// Why a body tells nothing of the place of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blind {
    /// Less than half of the facing wall has a depth; the share.
    NoDepth(f32),
    /// The depth in the body is that of the background: both in metres.
    Transparent(f32, f32),
    /// No upper edge of the body was found near its axis.
    NoEdge,
}

/// Place of a camera without depth, as somebody measured it; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedPlace {
    /// From the lens to the wall of the glass that faces it, horizontally.
    pub wall_m: f64,
    /// Height of the lens above the inner bottom of the glass.
    pub height_m: f64,
}

/// Measures of camera and glass from a portrait; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Survey {
    /// Horizontal distance of the camera from the facing wall.
    pub wall_m: f64,
    /// Tangent of the bearing of the axis, positive to the right.
    pub bearing: f64,
    /// Pitch of the camera, radians, positive when it looks up.
    pub pitch_rad: f64,
    /// Radius of the cylinder to which the sides are tangent, if it begins at the facing wall.
    pub radius_m: f64,
    /// Height of the upper edge of the body above the camera, at the facing wall.
    pub top_m: f64,
    /// Height of the liquid from its lower edge to its upper one, if the lower edge was seen.
    pub fill_m: Option<f64>,
    /// Share of the facing wall's pixels that have a depth; `None` of a camera without.
    pub depth_share: Option<f64>,
}

impl Survey {
    /// Returns the inner radius of a glass whose wall is `thickness_m` thick. The axis is the inner radius and `beyond_m` behind
    /// the facing wall as it was measured; the sides are tangent to the outer wall:
    ///
    /// ```text
    /// sin h = (R + t) / (F + R + b)     =>     R = (sin h (F + b) - t) / (1 - sin h)
    /// ```
    pub(super) fn inner_radius_m(&self, thickness_m: f64, beyond_m: f64) -> f64 {
        let sine = self.radius_m / (self.radius_m + self.wall_m);
        (sine * (self.wall_m + beyond_m) - thickness_m) / (1.0 - sine)
    }

    /// The survey of `body`.
    ///
    /// # Errors
    /// [`Blind`].
    pub(super) fn of(portrait: &Portrait, body: &Body, lens: &Intrinsics) -> Result<Self, Blind> {
        let wall = wall(portrait, body);
        let share = wall.share;
        if share < 0.5 || wall.rows.len() < LEAST_ROWS {
            return Err(Blind::NoDepth(share));
        }
        let depths = |rows: &[(usize, f32)]| median(rows.iter().map(|(_, depth_m)| *depth_m));
        // The upper half of the body: near the foot the table before it is as near as the glass.
        let upper = wall.rows.get(..wall.rows.len() / 2).unwrap_or_default();
        if let (Some(front), Some(back)) = (depths(upper), beside(portrait, body))
            && front > THROUGH * back
        {
            return Err(Blind::Transparent(front, back));
        }
        let b = |row: f64| (row - f64::from(lens.ppy)) / f64::from(lens.fy);
        let inverse = |&(row, depth_m): &(usize, f32)| (b(row as f64), 1.0 / f64::from(depth_m));
        let points: Vec<(f64, f64)> = wall.rows.iter().map(inverse).collect();
        let (at_0, slope) = line(&points).ok_or(Blind::NoDepth(share))?;
        let (pitch, y_m) = (slope.atan2(at_0), 1.0 / at_0.hypot(slope));
        let depth_share = Some(f64::from(share));
        Ok(Self { depth_share, ..Self::along(body, lens, Line { pitch, y_m }) })
    }

    /// The survey of `body` by a camera without depth: the row of the surface at rest, `fill_m` high, tells the pitch,
    ///
    /// ```text
    /// p = atan b + atan((fill - height) / Y)
    /// ```
    ///
    /// and the silhouette and the lower edge of the body check the lens and the stated lengths.
    #[must_use]
    pub(super) fn at(body: &Body, lens: &Intrinsics, place: StatedPlace, fill_m: f64) -> Option<Self> {
        let StatedPlace { wall_m, height_m } = place;
        let (_, [left, right]) = body.sides.get(body.sides.len() / 2)?;
        let middle = 0.5 * (left + right);
        let near = |(column, _): &&(usize, f32)| (*column as f32 - middle).abs() < 6.0;
        let rest = median(body.top.iter().filter(near).map(|(_, row)| *row))?;
        let b = (f64::from(rest) - f64::from(lens.ppy)) / f64::from(lens.fy);
        // The wall is Y / cos away, as below.
        let bearing = f64::from((middle - lens.ppx) / lens.fx).atan();
        let y_m = wall_m * bearing.cos();
        let pitch = b.atan() + ((fill_m - height_m) / y_m).atan();
        Some(Self::along(body, lens, Line { pitch, y_m }))
    }

    /// The survey along the line that the facing wall is.
    fn along(body: &Body, lens: &Intrinsics, line: Line) -> Self {
        let Line { pitch, y_m } = line;
        let b = |row: f64| (row - f64::from(lens.ppy)) / f64::from(lens.fy);
        let (sin, cos) = pitch.sin_cos();
        let tangent = |column: f32, row: usize| {
            let a = f64::from(column - lens.ppx) / f64::from(lens.fx);
            (a / (cos + b(row as f64) * sin)) as f32
        };
        let side = |end: usize| median(body.sides.iter().map(|(row, ends)| tangent(ends[end], *row)));
        let [left, right] = [side(0), side(1)].map(|t| t.map_or(f64::NAN, |t| f64::from(t).atan()));
        let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
        let bearing = middle.tan();
        // The depth line is that of the axis' own column: Y along y, so that the wall is Y / cos away.
        let wall_m = y_m / middle.cos();
        let radius_m = wall_m * half.sin() / (1.0 - half.sin());
        let height = |row: f32| y_m * (sin - b(row.into()) * cos) / (cos + b(row.into()) * sin);
        let axis_column = f64::from(lens.ppx) + f64::from(lens.fx) * bearing;
        let near = |(column, _): &&(usize, f32)| (*column as f64 - axis_column).abs() < 6.0;
        let rest = body.top.iter().filter(near).map(|(_, row)| *row);
        let top_m = median(rest).or_else(|| body.top.first().map(|(_, row)| *row)).map_or(f64::NAN, height);
        let fill_m = body.foot.map(|foot| top_m - height(foot));
        Self { wall_m, bearing, pitch_rad: pitch, radius_m, top_m, fill_m, depth_share: None }
    }
}

/// The facing wall as the camera sees it: a vertical line.
struct Line {
    /// Pitch of the camera, radians.
    pitch: f64,
    /// `Y`, metres.
    y_m: f64,
}

/// The depths of the wall that faces the camera.
struct Wall {
    /// Median depth of each row of the strip that has any, metres.
    rows: Vec<(usize, f32)>,
    /// Share of the strip's pixels that have a depth.
    share: f32,
}

fn wall(portrait: &Portrait, body: &Body) -> Wall {
    let (first, last) = body.rows();
    let inner = (first + MARGIN)..last.saturating_sub(MARGIN);
    let (mut rows, mut all, mut seen) = (Vec::new(), 0, 0);
    for (row, [left, right]) in body.sides.iter().filter(|(row, _)| inner.contains(row)) {
        let (axis, half) = (0.5 * (left + right), 0.5 * (right - left) * STRIP);
        let strip = ((axis - half).round() as usize)..=((axis + half).round() as usize);
        all += strip.clone().count();
        let depths: Vec<f32> = strip.filter_map(|column| portrait.depth_m(column, *row)).collect();
        seen += depths.len();
        rows.extend(median(depths).map(|depth_m| (*row, depth_m)));
    }
    Wall { rows, share: if all == 0 { 0.0 } else { seen as f32 / all as f32 } }
}

/// Median depth beside the upper half of the body, metres.
fn beside(portrait: &Portrait, body: &Body) -> Option<f32> {
    let upper = body.sides.get(..body.sides.len() / 2)?;
    let mut depths = Vec::new();
    for (row, [left, right]) in upper {
        for away in BESIDE {
            let columns = [(*left as usize).checked_sub(away), Some(*right as usize + away)];
            depths.extend(columns.into_iter().flatten().filter_map(|column| portrait.depth_m(column, *row)));
        }
    }
    median(depths)
}

/// Least squares `y = at_0 + slope x`, twice: the second time without outliers.
fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let fit = |points: &[(f64, f64)]| {
        let n = points.len() as f64;
        let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
        let (xx, xy) = points
            .iter()
            .fold((0.0, 0.0), |(xx, xy), p| (xx + (p.0 - x) * (p.0 - x), xy + (p.0 - x) * (p.1 - y)));
        (xx > 0.0).then(|| (y - xy / xx * x, xy / xx))
    };
    let (at_0, slope) = fit(points)?;
    let off = |(x, y): &(f64, f64)| (y - at_0 - slope * x).abs();
    let deviation = 1.4826 * f64::from(median(points.iter().map(|point| off(point) as f32))?);
    let near: Vec<(f64, f64)> =
        points.iter().copied().filter(|point| off(point) <= OUTLIER * deviation.max(1e-9)).collect();
    if near.len() < LEAST_ROWS { Some((at_0, slope)) } else { fit(&near) }
}
