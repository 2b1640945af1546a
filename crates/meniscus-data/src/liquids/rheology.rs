//! Stress against rate of shear: Herschel-Bulkley, as a generalised Newtonian viscosity.
//!
//! ```text
//! tau = tau0 + k rate^n                          (Herschel and Bulkley 1926)
//! mu(rate) = min( mu_max, k rate^(n-1) + tau0 (1 - exp(-m rate)) / rate )
//! ```
//! The exponential regularises the yield stress (Papanastasiou 1987) with `m = 10 s`; `mu_max` caps
//! what is left of the growth towards zero rate, because the explicit step shrinks as `1/mu`. An
//! "unyielded" liquid thus creeps at `tau / mu_max` instead of standing still.

/// Cap of the viscosity where a file gives none, Pa s.
pub(super) const LARGEST: f64 = 20.0;

/// The time `m` of the regularisation, s: the stress is within 1 % of `tau0` above 0.5 /s.
pub const SHEAR_RATE_SCALE: f64 = 10.0;

/// A generalised Newtonian liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rheology {
    /// Consistency k, Pa s^n.
    pub consistency: f64,
    /// Flow index n.
    pub index: f64,
    /// Yield stress tau0, Pa.
    pub yield_stress: f64,
    /// Cap of the viscosity, Pa s.
    pub largest: f64,
}

impl Rheology {
    /// A liquid of constant viscosity, Pa s.
    #[must_use]
    pub fn newtonian(viscosity: f64) -> Self {
        Self { consistency: viscosity, index: 1.0, yield_stress: 0.0, largest: viscosity.max(LARGEST) }
    }

    /// Whether the viscosity is the same at every rate.
    #[must_use]
    pub fn is_newtonian(&self) -> bool {
        self.index == 1.0 && self.yield_stress == 0.0
    }

    /// Viscosity at `rate` (1/s), Pa s.
    #[must_use]
    pub fn viscosity(&self, rate: f64) -> f64 {
        if self.is_newtonian() {
            return self.consistency;
        }
        let rate = rate.max(1e-6);
        let plastic = self.yield_stress * -(-SHEAR_RATE_SCALE * rate).exp_m1() / rate;
        (self.consistency * rate.powf(self.index - 1.0) + plastic).min(self.largest)
    }

    /// The largest viscosity at any rate, Pa s; it bounds the time step.
    #[must_use]
    pub fn largest(&self) -> f64 {
        if self.is_newtonian() { self.consistency } else { self.largest }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_is_met_above_the_regularised_rates_and_capped_below() {
        let law = Rheology { consistency: 0.5, index: 0.5, yield_stress: 3.0, largest: 20.0 };
        for rate in [1.0, 10.0, 100.0_f64] {
            let stress = law.viscosity(rate) * rate;
            assert!((stress / (3.0 + 0.5 * rate.sqrt()) - 1.0).abs() < 1e-3);
        }
        assert_eq!(law.viscosity(0.0), 20.0);
        assert_eq!(Rheology::newtonian(0.95).viscosity(7.0), 0.95);
    }
}
