//! Measures of a glass as a person took them.

use serde::{Deserialize, Serialize};

/// Name, least and greatest value of each measure, mm; in the order of [`MeasuredGlass::values`].
pub const RANGES: [(&str, f64, f64); 3] =
    [("radius_mm", 10.0, 60.0), ("fill_mm", 15.0, 200.0), ("rim_mm", 20.0, 300.0)];

/// Inner measures of a glass, millimetres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredGlass {
    /// Inner radius: half of what a calliper reads between the inner walls.
    pub radius_mm: f64,
    /// Height of the liquid at rest above the inner bottom.
    pub fill_mm: f64,
    /// Height of the rim above the inner bottom.
    pub rim_mm: f64,
}

impl MeasuredGlass {
    /// Radius, fill and rim, mm.
    #[must_use]
    pub fn values(&self) -> [f64; 3] {
        [self.radius_mm, self.fill_mm, self.rim_mm]
    }

    /// The same from three values.
    #[must_use]
    pub fn of([radius_mm, fill_mm, rim_mm]: [f64; 3]) -> Self {
        Self { radius_mm, fill_mm, rim_mm }
    }

    /// Checks that every measure is in its range and the fill below the rim.
    ///
    /// # Errors
    /// The first measure that is out of its range, or a fill at the rim.
    pub fn check(&self) -> Result<(), String> {
        for ((name, least, most), value) in RANGES.into_iter().zip(self.values()) {
            if !(least..=most).contains(&value) {
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
