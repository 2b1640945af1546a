//! A glass of liquid with everything that can be hidden in it.

use crate::study::unnamed::laws::HiddenLaw;

/// Liquid of one glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Liquid {
    /// Density, kg/m3.
    pub density_kg_m3: f64,
    /// Consistency K of `tau = tau0 + K rate^n`, Pa s^n.
    pub consistency: f64,
    /// Flow index n.
    pub index: f64,
    /// Yield stress tau0, Pa.
    pub yield_pa: f64,
    /// Length by which it slips along the wall, m.
    pub slip_m: f64,
    /// Modulus of the strain that it remembers, Pa.
    pub modulus_pa: f64,
    /// Time after which it has forgotten, s.
    pub relaxation_s: f64,
    /// Surface tension, N/m.
    pub tension_n_m: f64,
}

/// Rate of shear below which a yield stress is met by creep, and below which a power law ends, 1/s.
const CREEP: f64 = 0.05;
const LEAST_SHEAR: f64 = 0.01;

impl Liquid {
    /// Returns the Newtonian liquid of this laboratory with a viscosity in Pa s.
    #[must_use]
    pub fn plain(viscosity_pa_s: f64) -> Self {
        Self {
            density_kg_m3: DENSITY_KG_M3,
            consistency: viscosity_pa_s,
            index: 1.0,
            yield_pa: 0.0,
            slip_m: 0.0,
            modulus_pa: 0.0,
            relaxation_s: 1.0,
            tension_n_m: 0.0,
        }
    }

    /// Returns the viscosity at a rate of shear (1/s), Pa s.
    #[must_use]
    pub fn viscosity(&self, shear: f64) -> f64 {
        let shear = shear.max(LEAST_SHEAR);
        let flows = if self.index == 1.0 { 1.0 } else { shear.powf(self.index - 1.0) };
        let stands =
            if self.yield_pa > 0.0 { self.yield_pa * -(-shear / CREEP).exp_m1() / shear } else { 0.0 };
        self.consistency * flows + stands
    }

    /// Returns whether the viscosity is the same at every rate.
    #[must_use]
    pub fn is_linear(&self) -> bool {
        self.index == 1.0 && self.yield_pa == 0.0
    }
}

/// Line where the surface meets the wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Spring that holds it, N/m2.
    pub spring_n_m2: f64,
    /// Force at which it slides, N/m.
    pub sliding_n_m: f64,
    /// Coefficient of foam, N/m (s/m)^(2/3).
    pub foam: f64,
}

/// Inner radius of every glass as stated, m.
pub const RADIUS_M: f64 = 0.040;
/// Height of the liquid as stated, m.
pub const FILL_M: f64 = 0.080;
/// Density of the liquid, kg/m3.
pub const DENSITY_KG_M3: f64 = 1100.0;
/// Acceleration of gravity, m/s2.
pub const GRAVITY_M_S2: f64 = 9.80665;

/// One glass.
#[derive(Clone, Copy, Debug)]
pub struct LaboratoryGlass {
    /// Inner radius, m.
    pub radius_m: f64,
    /// Height of the liquid, m.
    pub fill_m: f64,
    /// Gravity less the acceleration downwards, m/s2.
    pub gravity_m_s2: f64,
    /// Liquid.
    pub liquid: Liquid,
    /// Line at the wall.
    pub line: Line,
    /// Force on the first wave that no library holds.
    pub law: Option<HiddenLaw>,
    /// Parts by which the frequencies, the dampings and the second order differ from those of the next glass.
    pub differs: [f64; 3],
}

impl LaboratoryGlass {
    /// Returns the glass as it is stated, of a viscosity in Pa s.
    #[must_use]
    pub fn plain(viscosity_pa_s: f64) -> Self {
        Self {
            radius_m: RADIUS_M,
            fill_m: FILL_M,
            gravity_m_s2: GRAVITY_M_S2,
            liquid: Liquid::plain(viscosity_pa_s),
            line: Line::default(),
            law: None,
            differs: [0.0; 3],
        }
    }
}
