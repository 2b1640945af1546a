//! The checks of an inspection: the liquid in the image, the camera's position, the measures, the surface at rest.

use super::body::Body;
use super::clear::{self, Appearance};
use super::file::{Tone, View};
use super::finding::{Finding, finding};
use super::measured_glass::MeasuredGlass;
use super::remedy;
use super::rest::Rest;
use super::survey::{Blind, Survey};
use meniscus::surface::Settings;
use meniscus_report::checks::Check;

/// Radius: this many mm or this share of it, the larger.
const RADIUS_MM: f64 = 1.5;
const RADIUS_SHARE: f64 = 0.05;
/// Height of the liquid: what a meniscus at either end makes uncertain.
const FILL_MM: f64 = 4.0;
/// The camera's distance, mm, and its pitch, degrees.
const DISTANCE_MM: (f64, f64) = (250.0, 700.0);
const PITCH_DEG: f64 = 15.0;
/// Height of the camera above the foot of the glass, as a share of the fill.
const HEIGHT_SHARE: (f64, f64) = (0.05, 0.97);
/// Least share of valid points at rest. Light comes into a bright liquid through its surface and its sides: of path-traced milk,
/// whose heights are right to 0.3 mm, 0.81 of the points are valid.
const VALID_SHARE: f64 = 0.9;
const VALID_SHARE_BRIGHT: f64 = 0.75;
/// Everything that the checks of the glass are made from.
#[derive(Clone, Copy)]
pub(super) struct GlassFacts<'f> {
    pub(super) body: Option<&'f Body>,
    pub(super) blind: Option<Blind>,
    pub(super) survey: Option<&'f Survey>,
    /// Inner radius that the sides of the liquid show behind the stated wall; the outer one where none is stated.
    pub(super) radius_m: Option<f64>,
    pub(super) view: Option<&'f View>,
    pub(super) said: MeasuredGlass,
    /// Appearance of a clear liquid, where one is looked for.
    pub(super) clear: Option<Appearance>,
    /// Whether the camera has depth images.
    pub(super) has_depth: bool,
    /// Column of the optical axis.
    pub(super) ppx: f64,
}

impl GlassFacts<'_> {
    /// Returns the checks of the glass: the liquid in the image, the camera's position, the measures.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let mut all = self.liquid();
        all.extend(self.position());
        all.extend(self.measures());
        all
    }

    /// Returns the remedy for a glass of which nothing can be measured.
    fn lost(&self) -> &'static str {
        if let Some(clear) = self.clear {
            return if self.body.is_some() { remedy::CLEAR_PLACE } else { clear.remedy() };
        }
        match (self.body, self.blind) {
            (None, _) => remedy::NOTHING,
            (_, Some(Blind::Transparent(..))) => remedy::TRANSPARENT,
            (_, Some(Blind::NoEdge)) => remedy::NOTHING,
            _ => remedy::NO_DEPTH,
        }
    }

    /// Returns `remedy`, or that of a glass that cannot be measured: the first cause comes first.
    fn or_lost(&self, remedy: &'static str) -> &'static str {
        if self.survey.is_none() { self.lost() } else { remedy }
    }

    /// Returns the checks of the liquid in both images.
    fn liquid(&self) -> Vec<Finding> {
        if let Some(clear) = self.clear {
            return clear.findings(self.lost(), self.survey.is_some());
        }
        let opaque = match self.blind {
            Some(Blind::Transparent(..)) => 0.0,
            Some(Blind::NoDepth(_) | Blind::NoEdge) => f64::NAN,
            None => measured(self.body.map(|_| 1.0)),
        };
        let share = match self.blind {
            Some(Blind::NoDepth(share)) => f64::from(share),
            _ => measured(self.survey.and_then(|survey| survey.depth_share)),
        };
        let contrast = measured(self.body.map(|body| body.contrast.into()));
        let least = f64::from(Settings::default().least_contrast) * 1.2;
        let contrast_remedy = if self.body.is_none() { self.lost() } else { remedy::CONTRAST };
        let seen = f64::from(u8::from(self.body.is_some()));
        let mut findings = vec![
            finding(Check::exactly("liquid_seen", seen, "1", 1.0), self.lost()),
            finding(Check::at_least("contrast", contrast, "grey", least), contrast_remedy),
        ];
        if self.has_depth {
            findings.push(finding(Check::exactly("opaque", opaque, "1", 1.0), self.lost()));
            findings.push(finding(Check::at_least("depth_share", share, "1", 0.5), self.lost()));
        }
        findings
    }

    /// Returns the checks of the camera's position.
    fn position(&self) -> Vec<Finding> {
        let offset_px = measured(self.survey.zip(self.body).map(|(_, body)| middle_px(body)));
        let offset_mm =
            measured(self.survey.zip(self.view).map(|(survey, view)| survey.bearing * view.distance_mm));
        let half_px = measured(self.body.map(|body| 0.5 * f64::from(body.width_px())));
        let reach = Settings::default().search_half_width_px as f64 - 20.0;
        let free_px = reach - (offset_px - self.ppx).abs() - half_px;
        let view = |of: fn(&View) -> f64| measured(self.view.map(of));
        let (lowest, highest) = (HEIGHT_SHARE.0 * self.said.fill_mm, HEIGHT_SHARE.1 * self.said.fill_mm);
        let (near, far) = DISTANCE_MM;
        let (distance, height) = (view(|view| view.distance_mm), view(|view| view.height_mm));
        vec![
            finding(Check::informational("offset_mm", offset_mm, "mm"), self.or_lost(remedy::OFFSET)),
            finding(Check::at_least("room_beside_px", free_px, "px", 0.0), self.or_lost(remedy::OFFSET)),
            finding(Check::within("distance_mm", distance, "mm", near, far), self.or_lost(remedy::DISTANCE)),
            finding(
                Check::within("camera_height_mm", height, "mm", tenth(lowest), tenth(highest)),
                self.or_lost(remedy::HEIGHT),
            ),
            finding(
                Check::within("pitch_deg", view(|view| view.pitch_deg), "deg", -PITCH_DEG, PITCH_DEG),
                self.or_lost(remedy::PITCH),
            ),
        ]
    }

    /// Returns the checks of the measures that a person has taken.
    fn measures(&self) -> Vec<Finding> {
        let said = self.said;
        let radius_mm = measured(self.radius_m.map(|radius_m| 1e3 * radius_m));
        let fill_mm = measured(self.survey.and_then(|survey| survey.fill_m).map(|fill_m| 1e3 * fill_m));
        let unstated = self.clear.filter(|_| said.wall_mm.is_none());
        let wall_mm = unstated.map_or(0.0, |_| clear::WALL_MM);
        let (least, most) = (said.radius_mm - tolerance(said), said.radius_mm + tolerance(said).max(wall_mm));
        // The lower face of the base mirrors the liquid above it, or the card behind it: either is right.
        let (lowest, highest) =
            (said.fill_mm - FILL_MM, said.fill_mm + FILL_MM + said.base_mm.unwrap_or(0.0));
        let radius = match (self.clear, self.has_depth) {
            (Some(_), _) => remedy::CLEAR_RADIUS,
            (None, true) => remedy::RADIUS,
            (None, false) => remedy::RADIUS_STATED,
        };
        let fill = if self.has_depth { remedy::FILL } else { remedy::FILL_STATED };
        vec![
            finding(
                Check::within("radius_seen_mm", radius_mm, "mm", tenth(least), tenth(most)),
                self.or_lost(radius),
            ),
            finding(
                Check::within("fill_seen_mm", fill_mm, "mm", tenth(lowest), tenth(highest)),
                self.or_lost(fill),
            ),
        ]
    }
}

/// Returns the value, or NaN where there is none: a check of NaN is "not measured".
fn measured(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// The checks of the surface at rest.
pub(super) fn surface(
    rest: Option<&Rest>,
    said: MeasuredGlass,
    tone: Option<Tone>,
    refused: Option<String>,
) -> Vec<Finding> {
    let least_valid = if tone == Some(Tone::Bright) { VALID_SHARE_BRIGHT } else { VALID_SHARE };
    let of = |value: fn(&Rest) -> f64| rest.map_or(f64::NAN, value);
    let why = rest.and_then(|rest| rest.why).map(|why| format!(": {why}")).unwrap_or_default();
    let finding = |check, remedy: &str| Finding {
        check,
        remedy: refused.clone().unwrap_or_else(|| format!("{remedy}{why}")),
    };
    vec![
        finding(Check::at_least("rest_seen", of(|rest| rest.seen), "1", 0.95), remedy::SEEN),
        finding(
            Check::at_least("rest_points_valid", of(|rest| rest.valid), "1", least_valid),
            remedy::POINTS,
        ),
        finding(
            Check::within(
                "rest_level_mm",
                of(|rest| rest.level_mm),
                "mm",
                tenth(said.fill_mm - 0.5),
                tenth(said.fill_mm + 0.5),
            ),
            remedy::LEVEL,
        ),
        finding(Check::within("rest_slope_mm", of(|rest| rest.slope_mm), "mm", -1.0, 1.0), remedy::SLOPE),
        finding(Check::at_most("rest_noise_mm", of(|rest| rest.noise_mm), "mm", 0.5), remedy::NOISE),
        finding(Check::at_most("rest_bend_mm", of(|rest| rest.bend_mm), "mm", 0.5), remedy::BEND),
    ]
}

/// Returns the largest difference between the measured and the stated radius, mm.
fn tolerance(said: MeasuredGlass) -> f64 {
    RADIUS_MM.max(RADIUS_SHARE * said.radius_mm)
}

/// To a tenth, for targets that people read.
fn tenth(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

/// Column of the middle of the body.
fn middle_px(body: &Body) -> f64 {
    let middle = body.sides.get(body.sides.len() / 2).map(|(_, [left, right])| 0.5 * (left + right));
    middle.map_or(f64::NAN, f64::from)
}
