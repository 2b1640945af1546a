//! Inspection: the measures of a glass against what the camera sees of it, and the setup.

use super::body::Body;
use super::file::{LiquidAppearance, Setup, Tone, View};
use super::portrait::{Pair, Portrait};
use super::remedy;
use super::rest::Rest;
use super::survey::{Blind, Survey};
use crate::setup::measured_glass::MeasuredGlass;
use meniscus::surface::{Liquid, Optics, Settings};
use meniscus_report::checks::Check;
use meniscus_usb::camera::OutlineImage;

/// Radius: this many mm or this share of it, the larger.
const RADIUS_MM: f64 = 1.5;
const RADIUS_SHARE: f64 = 0.05;
/// Height of the liquid: half of what a meniscus at its foot and a thick bottom make uncertain.
const FILL_MM: f64 = 4.0;
/// The camera's distance, mm, and its pitch, degrees.
const DISTANCE_MM: (f64, f64) = (250.0, 700.0);
const PITCH_DEG: f64 = 15.0;
/// Height of the camera above the foot of the glass, as a share of the fill.
const HEIGHT_SHARE: (f64, f64) = (0.05, 0.97);
/// Times that the camera's height is corrected by the level that the reader finds.
const ROUNDS: usize = 3;

/// One check with what to do if it is missed.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The check.
    pub check: Check,
    /// Action for a person.
    pub remedy: String,
}

/// Result of an inspection.
#[derive(Clone, Debug)]
pub struct Inspection {
    /// The body of liquid in the image, if there is one.
    pub body: Option<Body>,
    /// Measures of the glass from its body.
    pub survey: Option<Survey>,
    /// The surface as a run will see it.
    pub rest: Option<Rest>,
    /// The settings, whether all checks are met or not; none where the glass was not seen.
    pub setup: Option<Setup>,
    /// The checks of the glass, then those of the surface at rest.
    pub findings: Vec<Finding>,
}

impl Inspection {
    /// Whether every check is met.
    #[must_use]
    pub fn ok(&self) -> bool {
        self.findings.iter().all(|finding| !finding.check.missed())
    }

    /// Returns the findings to remedy: those measured and missed, or else the first that could not be measured.
    #[must_use]
    pub fn remedies(&self) -> Vec<&Finding> {
        let missed = || self.findings.iter().filter(|finding| finding.check.missed());
        let measured: Vec<_> = missed().filter(|finding| finding.check.value.is_some()).collect();
        if measured.is_empty() { missed().take(1).collect() } else { measured }
    }
}

/// Origin of a setup, written into its file.
#[derive(Clone, Copy, Debug)]
pub struct SetupOrigin<'o> {
    /// Image in which the outline is traced.
    pub outline: OutlineImage,
    /// The camera, in words.
    pub camera: &'o str,
    /// The command, in words.
    pub made_by: &'o str,
}

/// Compares the measures `said` of a glass with what `pairs` of a camera of these optics show.
#[must_use]
pub fn inspect(pairs: &[Pair], optics: Optics, said: MeasuredGlass, origin: SetupOrigin<'_>) -> Inspection {
    let lens = optics.intrinsics;
    let defaults = Settings::default();
    let (middle, reach) = (lens.ppx.max(0.0) as usize, defaults.search_half_width_px);
    let columns = middle.saturating_sub(reach)..(middle + reach).min(lens.width);
    let portrait = Portrait::of(pairs, &optics);
    let body = portrait.as_ref().and_then(|portrait| Body::find(portrait, &columns));
    let looked = portrait.as_ref().zip(body.as_ref());
    let looked = looked.map(|(portrait, body)| Survey::of(portrait, body, &lens));
    let (survey, blind) = match looked {
        Some(Ok(survey)) => (Some(survey), None),
        Some(Err(blind)) => (None, Some(blind)),
        None => (None, None),
    };
    let mut setup = survey.as_ref().zip(body.as_ref()).map(|(survey, body)| Setup {
        made_by: origin.made_by.into(),
        glass: said,
        liquid: LiquidAppearance {
            tone: if body.liquid == Liquid::Dark { Tone::Dark } else { Tone::Bright },
            least_contrast: defaults.least_contrast,
        },
        view: view(survey, said, origin),
    });
    let rest = setup.as_mut().and_then(|setup| settle(setup, pairs, optics));
    setup.iter_mut().for_each(|setup| setup.view.round());
    let config = setup.as_ref().and_then(|setup| setup.config(optics).err());
    let facts = GlassFacts {
        body: body.as_ref(),
        blind,
        survey: survey.as_ref(),
        view: setup.as_ref().map(|setup| &setup.view),
        said,
        ppx: lens.ppx.into(),
    };
    let mut findings = facts.findings();
    findings.extend(surface(rest.as_ref(), said, config.map(|error| format!("{error}"))));
    Inspection { body, survey, rest, setup, findings }
}

/// The place of the camera that makes the facing wall of the said glass lie where it was measured.
fn view(survey: &Survey, said: MeasuredGlass, origin: SetupOrigin<'_>) -> View {
    let away_mm = 1e3 * survey.wall_m + said.radius_mm;
    View {
        camera: origin.camera.into(),
        distance_mm: away_mm * survey.bearing.atan().cos(),
        height_mm: said.fill_mm - 1e3 * survey.top_m,
        pitch_deg: survey.pitch_rad.to_degrees(),
        outline: origin.outline,
    }
}

/// The reader's own level brought to the said one: half of the pairs move the camera, the other half tell the rest.
fn settle(setup: &mut Setup, pairs: &[Pair], optics: Optics) -> Option<Rest> {
    let (first, second) = pairs.split_at(pairs.len() / 2);
    for _ in 0..ROUNDS {
        let rest = Rest::of(if first.is_empty() { second } else { first }, &setup.config(optics).ok()?);
        if rest.level_mm.is_finite() {
            setup.view.height_mm += setup.glass.fill_mm - rest.level_mm;
        }
    }
    Some(Rest::of(second, &setup.config(optics).ok()?))
}

/// Everything that the checks of the glass are made from.
#[derive(Clone, Copy)]
struct GlassFacts<'f> {
    body: Option<&'f Body>,
    blind: Option<Blind>,
    survey: Option<&'f Survey>,
    view: Option<&'f View>,
    said: MeasuredGlass,
    /// Column of the optical axis.
    ppx: f64,
}

impl GlassFacts<'_> {
    /// Returns the checks of the glass: the liquid in the image, the camera's position, the measures.
    fn findings(&self) -> Vec<Finding> {
        let mut all = self.liquid();
        all.extend(self.position());
        all.extend(self.measures());
        all
    }

    /// Returns the remedy for a glass of which nothing can be measured.
    fn lost(&self) -> &'static str {
        match (self.body, self.blind) {
            (None, _) => remedy::NOTHING,
            (_, Some(Blind::Transparent(..))) => remedy::TRANSPARENT,
            _ => remedy::NO_DEPTH,
        }
    }

    /// Returns `remedy`, or that of a glass that cannot be measured: the first cause comes first.
    fn or_lost(&self, remedy: &'static str) -> &'static str {
        if self.survey.is_none() { self.lost() } else { remedy }
    }

    /// Returns the checks of the liquid in both images.
    fn liquid(&self) -> Vec<Finding> {
        let opaque = match self.blind {
            Some(Blind::Transparent(..)) => 0.0,
            Some(Blind::NoDepth(_)) => f64::NAN,
            None => measured(self.body.map(|_| 1.0)),
        };
        let share = match self.blind {
            Some(Blind::NoDepth(share)) => f64::from(share),
            _ => measured(self.survey.map(|survey| survey.depth_share)),
        };
        let contrast = measured(self.body.map(|body| body.contrast.into()));
        let least = f64::from(Settings::default().least_contrast) * 1.2;
        let contrast_remedy = if self.body.is_none() { self.lost() } else { remedy::CONTRAST };
        let seen = f64::from(u8::from(self.body.is_some()));
        vec![
            finding(Check::exactly("liquid_seen", seen, "1", 1.0), self.lost()),
            finding(Check::at_least("contrast", contrast, "grey", least), contrast_remedy),
            finding(Check::exactly("opaque", opaque, "1", 1.0), self.lost()),
            finding(Check::at_least("depth_share", share, "1", 0.5), self.lost()),
        ]
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
        let radius_mm = measured(self.survey.map(|survey| 1e3 * survey.radius_m));
        let fill_mm = measured(self.survey.and_then(|survey| survey.fill_m).map(|fill_m| 1e3 * fill_m));
        let (least, most) = (said.radius_mm - tolerance(said), said.radius_mm + tolerance(said));
        let (lowest, highest) = (said.fill_mm - FILL_MM, said.fill_mm + FILL_MM);
        vec![
            finding(
                Check::within("radius_seen_mm", radius_mm, "mm", tenth(least), tenth(most)),
                self.or_lost(remedy::RADIUS),
            ),
            finding(
                Check::within("fill_seen_mm", fill_mm, "mm", tenth(lowest), tenth(highest)),
                self.or_lost(remedy::FILL),
            ),
        ]
    }
}

/// Returns a check with its remedy.
fn finding(check: Check, remedy: &str) -> Finding {
    Finding { check, remedy: remedy.into() }
}

/// Returns the value, or NaN where there is none: a check of NaN is "not measured".
fn measured(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

/// The checks of the surface at rest.
fn surface(rest: Option<&Rest>, said: MeasuredGlass, refused: Option<String>) -> Vec<Finding> {
    let of = |value: fn(&Rest) -> f64| rest.map_or(f64::NAN, value);
    let why = rest.and_then(|rest| rest.why).map(|why| format!(": {why}")).unwrap_or_default();
    let finding = |check, remedy: &str| Finding {
        check,
        remedy: refused.clone().unwrap_or_else(|| format!("{remedy}{why}")),
    };
    vec![
        finding(Check::at_least("rest_seen", of(|rest| rest.seen), "1", 0.95), remedy::SEEN),
        finding(Check::at_least("rest_points_valid", of(|rest| rest.valid), "1", 0.9), remedy::POINTS),
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
