//! Inspection: the measures of a glass against what the camera sees of it, and the setup.

use super::body::Body;
use super::clear::{self, Appearance};
use super::file::{LiquidAppearance, Setup, Tone, View};
use super::finding::Finding;
use super::findings::{GlassFacts, surface};
use super::lens::StatedLens;
use super::portrait::{Pair, Portrait};
use super::rest::Rest;
use super::survey::{Blind, StatedPlace, Survey};
use crate::setup::measured_glass::MeasuredGlass;
use meniscus::surface::{Liquid, Optics, Settings};
use meniscus_usb::camera::OutlineImage;
use std::ops::Range;

/// Index of refraction of glass, near infrared (soda-lime glass 1.51, borosilicate 1.47).
const GLASS_INDEX: f64 = 1.5;
/// Times that the camera's height is corrected by the level that the reader finds.
const ROUNDS: usize = 3;

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
    inspect_by(pairs, said, origin, Sight::Depth(optics))
}

/// Compares the measures `said` of a glass with what images of a camera without depth show, whose lens and place are stated.
#[must_use]
pub fn inspect_outline(
    pairs: &[Pair],
    camera: StatedCamera,
    said: MeasuredGlass,
    origin: SetupOrigin<'_>,
) -> Inspection {
    inspect_by(pairs, said, origin, Sight::Stated(camera.lens, camera.place))
}

/// Compares the measures `said` of a glass of clear liquid with what `pairs` of a camera of these optics show. Without a
/// stated `place` the depth image has to show the wall of the glass.
#[must_use]
pub fn inspect_clear(
    pairs: &[Pair],
    optics: Optics,
    place: Option<StatedPlace>,
    said: MeasuredGlass,
    origin: SetupOrigin<'_>,
) -> Inspection {
    inspect_by(pairs, said, origin, Sight::Clear(optics, place))
}

/// Lens and place of a camera without depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedCamera {
    /// Its lens.
    pub lens: StatedLens,
    /// Its place.
    pub place: StatedPlace,
}

/// Source of the camera's place.
#[derive(Clone, Copy)]
enum Sight {
    /// Its depth image.
    Depth(Optics),
    /// A person.
    Stated(StatedLens, StatedPlace),
    /// A person, or the depth of the wall before a clear liquid.
    Clear(Optics, Option<StatedPlace>),
}

impl Sight {
    fn optics(&self) -> Optics {
        match self {
            Self::Depth(optics) | Self::Clear(optics, _) => *optics,
            Self::Stated(lens, _) => lens.optics(),
        }
    }

    fn lens(&self) -> Option<StatedLens> {
        match self {
            Self::Depth(_) | Self::Clear(..) => None,
            Self::Stated(lens, _) => Some(*lens),
        }
    }

    /// Distance from the facing wall as it was measured to the inner wall behind it, which is `wall_mm` thick, mm. A person
    /// measures to the outer wall. A depth image sees opaque liquid at the inner one, too near by refraction.
    fn beyond_mm(&self, wall_mm: f64) -> f64 {
        match self {
            Self::Depth(_) => wall_mm * (1.0 - 1.0 / GLASS_INDEX),
            Self::Stated(..) | Self::Clear(..) => wall_mm,
        }
    }

    fn is_clear(&self) -> bool {
        matches!(self, Self::Clear(..))
    }

    fn body(&self, portrait: &Portrait, columns: &Range<usize>) -> Option<Body> {
        if self.is_clear() {
            Body::of_tone(portrait, columns, Liquid::Dark)
        } else {
            Body::find(portrait, columns)
        }
    }

    fn survey(&self, portrait: &Portrait, body: &Body, said: MeasuredGlass) -> Result<Survey, Blind> {
        let lens = self.optics().intrinsics;
        match self {
            Self::Depth(_) | Self::Clear(_, None) => Survey::of(portrait, body, &lens),
            Self::Stated(_, place) | Self::Clear(_, Some(place)) => {
                Survey::at(body, &lens, *place, 1e-3 * said.fill_mm).ok_or(Blind::NoEdge)
            }
        }
    }
}

fn inspect_by(pairs: &[Pair], said: MeasuredGlass, origin: SetupOrigin<'_>, sight: Sight) -> Inspection {
    let optics = sight.optics();
    let lens = optics.intrinsics;
    let defaults = Settings::default();
    let (middle, reach) = (lens.ppx.max(0.0) as usize, defaults.search_half_width_px);
    let columns = middle.saturating_sub(reach)..(middle + reach).min(lens.width);
    let portrait = Portrait::of(pairs, &optics);
    let body = portrait.as_ref().and_then(|portrait| sight.body(portrait, &columns));
    let looked = portrait.as_ref().zip(body.as_ref());
    let looked = looked.map(|(portrait, body)| sight.survey(portrait, body, said));
    let (survey, blind) = match looked {
        Some(Ok(survey)) => (Some(survey), None),
        Some(Err(blind)) => (None, Some(blind)),
        None => (None, None),
    };
    let wanted = if sight.is_clear() { defaults.of_clear_liquid() } else { defaults };
    let mut setup = survey.as_ref().zip(body.as_ref()).map(|(survey, body)| Setup {
        made_by: origin.made_by.into(),
        glass: said,
        liquid: LiquidAppearance {
            tone: match (wanted.liquid, body.liquid) {
                (Liquid::Clear, _) => Tone::Clear,
                (_, Liquid::Bright) => Tone::Bright,
                _ => Tone::Dark,
            },
            least_contrast: wanted.least_contrast,
        },
        view: view(survey, said, origin, sight),
        lens: sight.lens(),
    });
    let rest = setup.as_mut().and_then(|setup| settle(setup, pairs, optics));
    setup.iter_mut().for_each(|setup| setup.view.round());
    let config = setup.as_ref().and_then(|setup| setup.config(optics).err());
    let facts = GlassFacts {
        body: body.as_ref(),
        blind,
        survey: survey.as_ref(),
        radius_m: survey.as_ref().map(|survey| {
            let wall_mm = said.wall_mm.unwrap_or(0.0);
            survey.inner_radius_m(1e-3 * wall_mm, 1e-3 * sight.beyond_mm(wall_mm))
        }),
        view: setup.as_ref().map(|setup| &setup.view),
        said,
        clear: portrait
            .as_ref()
            .filter(|_| sight.is_clear())
            .map(|portrait| Appearance::of(portrait, body.as_ref(), &columns)),
        has_depth: sight.lens().is_none(),
        ppx: lens.ppx.into(),
    };
    let mut findings = facts.findings();
    let tone = setup.as_ref().map(|setup| setup.liquid.tone);
    findings.extend(surface(rest.as_ref(), said, tone, config.map(|error| format!("{error}"))));
    Inspection { body, survey, rest, setup, findings }
}

/// The place of the camera that makes the facing wall of the said glass lie where it was measured. Without a stated
/// thickness the wall of a clear liquid is as thick as the silhouette is wider than the glass.
fn view(survey: &Survey, said: MeasuredGlass, origin: SetupOrigin<'_>, sight: Sight) -> View {
    let thickest_mm = if sight.is_clear() { clear::WALL_MM } else { 0.0 };
    let shown_mm = (1e3 * survey.radius_m - said.radius_mm).clamp(0.0, thickest_mm);
    let beyond_mm = sight.beyond_mm(said.wall_mm.unwrap_or(shown_mm));
    let away_mm = 1e3 * survey.wall_m + said.radius_mm + beyond_mm;
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
