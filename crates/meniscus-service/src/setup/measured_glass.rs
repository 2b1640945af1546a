//! Measures of a glass as a person took them.

use serde::{Deserialize, Serialize};

/// Name, least and greatest value of each measure, mm; in the order of [`MeasuredGlass::values`]. The thickest wall is
/// that of the reader ([`meniscus::surface::THICKEST_WALL_M`]).
pub const RANGES: [(&str, f64, f64); 5] = [
    ("radius_mm", 10.0, 60.0),
    ("fill_mm", 15.0, 200.0),
    ("rim_mm", 20.0, 300.0),
    ("wall_mm", 0.0, 6.0),
    ("base_mm", 0.0, 30.0),
];

/// Measures of a glass, millimetres.
///
/// ```
/// use meniscus_service::setup::MeasuredGlass;
///
/// let glass = MeasuredGlass { wall_mm: Some(3.0), ..MeasuredGlass::of([35.0, 70.0, 110.0]) };
/// assert_eq!(glass.check(), Ok(()));
/// let overfull = MeasuredGlass { fill_mm: 120.0, ..glass };
/// assert!(overfull.check().is_err_and(|what| what.contains("not below rim_mm = 110")));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredGlass {
    /// Inner radius: half of what a calliper reads between the inner walls.
    pub radius_mm: f64,
    /// Height of the liquid at rest above the inner bottom.
    pub fill_mm: f64,
    /// Height of the rim above the inner bottom.
    pub rim_mm: f64,
    /// Thickness of the wall at the height of the liquid. Without it the reader takes it from the silhouette.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall_mm: Option<f64>,
    /// Thickness of the base below the inner bottom. It shows the colour of the liquid above it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_mm: Option<f64>,
}

impl MeasuredGlass {
    /// A glass of an inner radius, a fill and a rim, mm, of whose wall and base nothing is known.
    #[must_use]
    pub const fn of([radius_mm, fill_mm, rim_mm]: [f64; 3]) -> Self {
        Self { radius_mm, fill_mm, rim_mm, wall_mm: None, base_mm: None }
    }

    /// Radius, fill, rim, wall and base, mm; none where nobody measured it.
    #[must_use]
    pub fn values(&self) -> [Option<f64>; 5] {
        [Some(self.radius_mm), Some(self.fill_mm), Some(self.rim_mm), self.wall_mm, self.base_mm]
    }

    /// Checks that every measure is in its range and the fill below the rim.
    ///
    /// # Errors
    /// The first measure that is out of its range, or a fill at the rim.
    pub fn check(&self) -> Result<(), String> {
        for ((name, least, most), value) in RANGES.into_iter().zip(self.values()) {
            if let Some(value) = value.filter(|value| !(least..=most).contains(value)) {
                return Err(format!("{name} = {value} is out of range: {least} to {most} mm"));
            }
        }
        if self.fill_mm >= self.rim_mm {
            let Self { fill_mm, rim_mm, .. } = self;
            return Err(format!(
                "fill_mm = {fill_mm} is not below rim_mm = {rim_mm}: both from the inner bottom"
            ));
        }
        Ok(())
    }
}
