//! The checks of a clear liquid: what is behind it, and how much of that light it takes.
//!
//! Behind a path of `d` metres through water the card keeps the share `exp(-a d)`, `a = 4.3 /m` at 850 nm (Kou, Labrie and
//! Chylek, Appl. Opt. 32 (1993) 3531): a glass of 70 mm takes a quarter. Visible light loses next to nothing, and what is
//! left is mirrored by the walls.

use super::body::Body;
use super::finding::{Finding, finding};
use super::portrait::Portrait;
use super::remedy;
use meniscus::surface::Settings;
use meniscus_numerics::statistics::median;
use meniscus_report::checks::Check;
use std::ops::Range;

/// Before a darker background water is a step of less than a quarter of this, 28 grey levels: little above the least.
const BRIGHT: f64 = 110.0;
/// Least share of the light that a liquid takes; the reader's own.
const LEAST_TAKEN: f64 = 0.12;
/// From here on pixels are cut off, grey levels.
const WHITE: f64 = 250.0;
/// The reader's least contrast and a fifth: a lamp is never steady.
const MARGIN: f64 = 1.2;
/// Columns beside the body that show what is behind it.
const BESIDE: Range<usize> = 6..32;
/// Thickest wall of a glass that the silhouette may show beyond the inner radius, mm.
pub(super) const WALL_MM: f64 = 4.5;

/// Appearance of a clear liquid and of what is behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Appearance {
    /// Grey level of what is behind.
    background: f64,
    /// Difference of the liquid from it, grey levels, if a body was found.
    contrast: Option<f64>,
}

impl Appearance {
    /// Looks beside the body, or, without one, at the columns and the upper half of the image.
    pub(super) fn of(portrait: &Portrait, body: Option<&Body>, columns: &Range<usize>) -> Self {
        let beside = body.map(|body| {
            let mut greys = Vec::new();
            for (row, [left, right]) in &body.sides {
                for away in BESIDE {
                    let pixels = [(*left as usize).checked_sub(away), Some(*right as usize + away)];
                    greys.extend(pixels.into_iter().flatten().map(|column| portrait.grey(column, *row)));
                }
            }
            greys
        });
        let all = || {
            let rows = portrait.height / 4..portrait.height / 2;
            rows.flat_map(|row| columns.clone().map(move |column| portrait.grey(column, row))).collect()
        };
        let greys: Vec<f32> = beside.unwrap_or_else(all);
        let background = median(greys).map_or(f64::NAN, f64::from);
        Self { background, contrast: body.map(|body| body.contrast.into()) }
    }

    /// Returns the remedy for a liquid that does not stand out.
    pub(super) fn remedy(self) -> &'static str {
        if self.background < BRIGHT { remedy::CLEAR_CARD } else { remedy::CLEAR_LAMP }
    }

    /// Returns the checks of the liquid in the infrared image; `lost` is the remedy of a glass that was not measured.
    pub(super) fn findings(self, lost: &str, place_known: bool) -> Vec<Finding> {
        let Self { background, contrast } = self;
        let least = f64::from(Settings::default().of_clear_liquid().least_contrast) * MARGIN;
        let (seen, contrast) = (f64::from(u8::from(contrast.is_some())), contrast.unwrap_or(f64::NAN));
        let place = if seen > 0.0 { f64::from(u8::from(place_known)) } else { f64::NAN };
        vec![
            finding(Check::exactly("liquid_seen", seen, "1", 1.0), self.remedy()),
            finding(Check::at_least("contrast", contrast, "grey", least), self.remedy()),
            finding(Check::at_most("background", background, "grey", WHITE), remedy::CLEAR_BRIGHT),
            finding(Check::at_least("light_taken", contrast / background, "1", LEAST_TAKEN), self.remedy()),
            finding(Check::exactly("place_known", place, "1", 1.0), lost),
        ]
    }
}
