//! Glass and liquid as stated.

use meniscus::reduced::effects::Stated;

/// Standard deviation of a radius that was measured with callipers, m.
pub const CALLIPERS_M: f64 = 1e-4;

/// Glass and liquid as stated, before a recording is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Inner radius of the glass, m.
    pub radius_m: f64,
    /// Standard deviation of the survey that it is stated from, m.
    pub radius_error_m: f64,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Viscosity, Pa s.
    pub viscosity_pa_s: f64,
    /// Share of the recorded inclination, and of the recorded vertical acceleration, that enters the model.
    pub motion_share: [f64; 2],
}

impl Known {
    /// Returns the liquid and fill that coordinates of effects are counted from.
    #[must_use]
    pub fn stated(&self) -> Stated {
        Stated { consistency_pa_sn: self.viscosity_pa_s, radius_m: self.radius_m, fill_m: self.fill_m }
    }
}
