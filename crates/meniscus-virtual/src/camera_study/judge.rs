//! Errors of profiles against the truth, gathered by group.

use super::conditions::{CLUTTERED_FROM, Case, Condition, FRAMES};
use crate::render::{Clutter, Images, Liquid, Scene};
use meniscus::surface::{
    Config, ConfigError, ExtractionError, ExtractionState, POINTS, SurfaceProfile, extract,
};
use meniscus::units::Micros;
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus_numerics::statistics::quantile;

/// One point that was seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Measured less true height, millimetres.
    pub error_mm: f64,
    /// Half width of its stated interval, millimetres.
    pub half_mm: f64,
}

/// Profiles of a scene beside the truth.
#[derive(Clone, Debug)]
pub struct Judged {
    /// The scene.
    pub case: Case,
    /// Frames that gave a profile.
    pub profiles: u32,
    /// All points seen.
    pub points: Vec<Point>,
    /// Why the last frame without a profile had none.
    pub not_seen: Option<ExtractionError>,
    /// The last frame, for a look.
    pub last: (Vec<u8>, Option<SurfaceProfile>),
}

/// Renders a scene and reads it back.
///
/// # Errors
/// [`ConfigError`], which no scene of the set leads to.
pub fn judge(case: Case) -> Result<Judged, ConfigError> {
    let settings = case.settings;
    let config = Config::new(settings.camera)?;
    let (mut scene, mut images, mut state) =
        (Scene::new(settings), Images::new(&settings), ExtractionState::new());
    let mut judged =
        Judged { case, profiles: 0, points: Vec::new(), not_seen: None, last: (Vec::new(), None) };
    let case = &judged.case;
    for frame in 0..FRAMES {
        // Without liquid the clutter is there from the start: what is clear does not become so.
        let cluttered = frame >= CLUTTERED_FROM || case.condition == Condition::NoLiquid;
        scene.disturb(if cluttered { settings.clutter } else { Clutter::default() });
        let glass_x_m = case.glass_m(frame);
        let liquid = Liquid { glass_m: [glass_x_m, 0.0], wall_m: &case.wall_m, column_m: &case.column_m };
        scene.render(&liquid, frame, &mut images);
        let (width, height) = config.image_size();
        let stamp = Stamp { sequence: frame as u32, captured: Micros(frame * 16_667) };
        let depth = DepthFrame { bytes: &images.depth, width, height, stamp };
        let infrared = OutlineFrame { bytes: &images.infrared, width, height, stamp };
        let profile = extract(&config, &mut state, depth, infrared);
        match profile {
            Ok(profile) => {
                judged.profiles += 1;
                judged.points.extend((0..POINTS).filter_map(|i| {
                    let half_mm = 1e3 * f64::from(profile.interval_m(i)?);
                    let error_mm = 1e3 * (f64::from(profile.height_m[i]) - case.truth_m[i]);
                    Some(Point { error_mm, half_mm })
                }));
            }
            Err(why) => judged.not_seen = Some(why),
        }
        judged.last.1 = profile.ok();
    }
    judged.last.0 = images.infrared;
    Ok(judged)
}

/// Counts of a row.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    /// Scenes.
    pub scenes: usize,
    /// Their frames.
    pub frames: u64,
    /// Frames with a profile.
    pub profiles: u32,
}

/// One row of the table.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Row {
    /// By what the scenes are grouped.
    pub group: &'static str,
    /// Which of them.
    pub name: String,
    /// Scenes, frames, and frames with a profile.
    pub scenes: usize,
    /// Frames.
    pub frames: u64,
    /// Frames with a profile.
    pub profiles: u32,
    /// Share of the points of these profiles that were seen.
    pub points_seen: f64,
    /// Root mean square error, millimetres.
    pub rms_mm: f64,
    /// Mean error, millimetres.
    pub bias_mm: f64,
    /// 95 % of the errors are smaller, millimetres.
    pub p95_mm: f64,
    /// The largest error, millimetres.
    pub worst_mm: f64,
    /// Share of the points inside their stated interval.
    pub coverage: f64,
    /// Mean half width of the interval, millimetres.
    pub half_mm: f64,
}

impl Row {
    /// The row of some scenes.
    #[must_use]
    pub fn of(group: &'static str, name: impl Into<String>, scenes: &[&Judged]) -> Self {
        let points: Vec<Point> = scenes.iter().flat_map(|judged| judged.points.iter().copied()).collect();
        let profiles = scenes.iter().map(|judged| judged.profiles).sum();
        let counts = Counts { scenes: scenes.len(), frames: scenes.len() as u64 * FRAMES, profiles };
        Self::of_points(group, name.into(), counts, &points)
    }

    /// The row of the points of some frames.
    #[must_use]
    pub fn of_points(group: &'static str, name: String, counts: Counts, points: &[Point]) -> Self {
        let Counts { scenes, frames, profiles } = counts;
        let mean = |of: &dyn Fn(&Point) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
        let at =
            |share: f64| quantile(points.iter().map(|point| point.error_mm.abs()), share).unwrap_or(f64::NAN);
        Self {
            group,
            name,
            scenes,
            frames,
            profiles,
            points_seen: points.len() as f64 / (f64::from(profiles) * POINTS as f64),
            rms_mm: mean(&|point| point.error_mm * point.error_mm).sqrt(),
            bias_mm: mean(&|point| point.error_mm),
            p95_mm: at(0.95),
            worst_mm: at(1.0),
            coverage: mean(&|point| f64::from(u8::from(point.error_mm.abs() <= point.half_mm))),
            half_mm: mean(&|point| point.half_mm),
        }
    }

    /// Headings of [`Row::cells`].
    pub const HEAD: [&'static str; 12] = [
        "scenes of",
        "which",
        "scenes",
        "frames",
        "profiles",
        "points seen",
        "rms, mm",
        "bias, mm",
        "95 %, mm",
        "worst, mm",
        "inside",
        "+- mm",
    ];

    /// Returns the row in words and figures.
    #[must_use]
    pub fn cells(&self) -> Vec<String> {
        let number = |value: f64, decimals: usize| {
            if value.is_finite() { format!("{value:.decimals$}") } else { "-".into() }
        };
        vec![
            self.group.into(),
            self.name.clone(),
            self.scenes.to_string(),
            self.frames.to_string(),
            self.profiles.to_string(),
            number(self.points_seen, 3),
            number(self.rms_mm, 3),
            number(self.bias_mm, 3),
            number(self.p95_mm, 3),
            number(self.worst_mm, 2),
            number(self.coverage, 3),
            number(self.half_mm, 3),
        ]
    }
}
