//! Effects of a candidate as parameters of a search: the first one's size, then all others and the viscosity.

use super::emulator::Prior;
use super::search::{OtherParameter, SizeRange};
use crate::baseline::calibrate::Calibration;
use crate::baseline::predict::NAMES;
use crate::decision::verdict::Verdict;
use crate::findings::Findings;
use crate::fitting::fit::{Fitted, Free};
use crate::recordings::stated::Known;
use meniscus::reduced::effects::{Active, EffectKind, Parameter, Simulator};

/// Exponent of the damping of the first mode in the viscosity, between a thin layer (0.5) and the bulk (1).
const DAMPING_EXPONENT: f64 = 0.65;

/// Least and largest standard deviation of the logarithm of the viscosity.
const VISCOSITY_DEVIATION: (f64, f64) = (0.01, 0.2);

/// Step of the logarithm of the viscosity.
const VISCOSITY_STEP: f64 = 0.1;

/// Standard deviation of a second parameter, relative to the one that the reduced model finds.
const OTHER_DEVIATION: f64 = 0.5;

/// Step of a second parameter, relative to its distance from the absent effect.
const OTHER_STEP: f64 = 0.15;

/// Effects that may be missing, as the reduced model fits them.
#[derive(Clone, Debug)]
pub struct SizingCandidate {
    /// Names.
    pub names: Vec<&'static str>,
    /// Effects with the values of the reduced model.
    pub active: Vec<Active>,
    /// Parameters that are sized; the first is searched, the others follow by their derivatives.
    pub free: Vec<Free>,
    /// Standard deviation of the logarithm of the viscosity; none where the viscosity is one of the effects.
    pub viscosity_deviation: Option<f64>,
}

impl SizingCandidate {
    /// Returns the candidate with the effects of `fitted`.
    #[must_use]
    pub fn new(fitted: &Fitted, calibration: &Calibration) -> Option<Self> {
        if fitted.free.is_empty() {
            return None;
        }
        let is_viscosity = |active: &Active| active.entry.kind == EffectKind::Viscosity;
        let damping = NAMES.iter().position(|name| *name == "damping 1").unwrap_or(0);
        let (least, largest) = VISCOSITY_DEVIATION;
        let deviation = (calibration.deviation[damping] / DAMPING_EXPONENT).clamp(least, largest);
        Some(Self {
            names: fitted.active.iter().map(|active| active.entry.name).collect(),
            active: fitted.active.clone(),
            free: fitted.free.clone(),
            viscosity_deviation: (!fitted.active.iter().any(is_viscosity)).then_some(deviation),
        })
    }

    /// Returns whether the particles show an effect. Those of camera, clock and drive are none of theirs, and another fill is
    /// another packing. An inclination is theirs, because the reduced model has it half as large again. So is a radius: it is
    /// another packing as well, but what it does to the slosh is far larger.
    #[must_use]
    pub fn is_of_the_particles(&self) -> bool {
        self.active.iter().any(|active| {
            let carried = matches!(active.entry.simulator, Simulator::Law(_));
            let kind = active.entry.kind;
            active.entry.class.in_liquid()
                || kind == EffectKind::Radius
                || (carried && kind != EffectKind::Fill)
        })
    }

    /// Returns the parameter `which` of those that are free.
    #[must_use]
    pub fn parameter(&self, which: usize) -> &'static Parameter {
        let (effect, parameter) = self.free[which];
        &self.active[effect].entry.parameters[parameter]
    }

    fn value(&self, which: usize) -> f64 {
        let (effect, parameter) = self.free[which];
        self.active[effect].values[parameter]
    }

    /// Returns the range of the size.
    #[must_use]
    pub fn range(&self) -> SizeRange {
        let parameter = self.parameter(0);
        SizeRange { bounds: parameter.range, neutral: parameter.neutral }
    }

    /// Returns the other parameters.
    #[must_use]
    pub fn others(&self) -> Vec<OtherParameter> {
        let one = |which: usize| {
            let (parameter, value) = (self.parameter(which), self.value(which));
            let excess = (value - parameter.neutral).abs().max(0.2 * parameter.typical.abs());
            // A step towards the middle of the range stays inside it.
            let (low, high) = parameter.range;
            let away = if value > 0.5 * (low + high) && high.is_finite() { -1.0 } else { 1.0 };
            OtherParameter {
                prior: Prior { mean: value, deviation: OTHER_DEVIATION * excess },
                step: away * OTHER_STEP * excess,
            }
        };
        let mut others: Vec<OtherParameter> = (1..self.free.len()).map(one).collect();
        if let Some(deviation) = self.viscosity_deviation {
            let prior = Prior { mean: 0.0, deviation };
            others.push(OtherParameter { prior, step: VISCOSITY_STEP });
        }
        others
    }

    /// Returns the sizes from which the search begins: none of the effect, that of the reduced model, and twice that.
    #[must_use]
    pub fn first_sizes(&self) -> Vec<f64> {
        let SizeRange { bounds: (low, high), neutral } = self.range();
        let found = self.value(0) - neutral;
        let least = 0.2 * self.parameter(0).typical.abs();
        let found = if found.abs() < least { least.copysign(found) } else { found };
        let mut sizes = vec![neutral, neutral + found, neutral + 2.0 * found];
        sizes.iter_mut().for_each(|size| *size = size.clamp(low, high));
        sizes.dedup();
        sizes
    }

    /// Returns the values of the other parameters that the reduced model finds.
    #[must_use]
    pub fn first_others(&self) -> Vec<f64> {
        self.others().iter().map(|other| other.prior.mean).collect()
    }

    /// Returns the effects and the liquid at `parameters`.
    #[must_use]
    pub fn at(&self, parameters: &[f64], known: &Known) -> (Vec<Active>, Known) {
        let mut active = self.active.clone();
        for ((effect, which), value) in self.free.iter().zip(parameters) {
            active[*effect].values[*which] = *value;
        }
        let factor = match self.viscosity_deviation {
            Some(_) => parameters.last().map_or(1.0, |logarithm| logarithm.exp()),
            None => 1.0,
        };
        (active, Known { viscosity_pa_s: factor * known.viscosity_pa_s, ..*known })
    }
}

/// Returns the candidates of `findings`, the chosen one first: its best `rivals` follow.
///
/// Rivals of an ambiguous verdict are those that it names; otherwise the next of the ranking that were fitted in full.
#[must_use]
pub fn candidates(findings: &Findings, rivals: usize) -> Vec<SizingCandidate> {
    let assessment = &findings.assessment;
    let Some(claim) = assessment.verdict.claim() else { return Vec::new() };
    let Some(best) = SizingCandidate::new(&claim.fitted, &findings.calibration) else { return Vec::new() };
    let ambiguous = matches!(assessment.verdict, Verdict::Ambiguous(_));
    let pair = claim.fitted.active.len() > 1;
    let ranking = if pair { &assessment.search.pairs } else { &assessment.search.ranking };
    let named = |names: &[&'static str]| names.iter().all(|name| claim.names.contains(name));
    let others = ranking
        .iter()
        .filter(|c| c.gain > findings.limits.gain && (!ambiguous || pair || named(&c.names)))
        .filter_map(|c| SizingCandidate::new(c.fitted.as_ref()?, &findings.calibration))
        .filter(|c| c.names != best.names)
        .take(rivals);
    std::iter::once(best.clone()).chain(others).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use meniscus::reduced::effects::find;

    pub(in crate::sizing) const KNOWN: Known = Known {
        radius_m: 0.035,
        radius_error_m: 1e-4,
        fill_m: 0.07,
        density_kg_m3: 1261.0,
        viscosity_pa_s: 0.2,
        motion_share: [1.0; 2],
    };

    fn candidate(name: &str, value: f64) -> SizingCandidate {
        let entry = find(name).expect("in the library");
        let mut values = entry.neutral();
        values[0] = value;
        SizingCandidate {
            names: vec![entry.name],
            active: vec![Active { entry, values }],
            free: vec![(0, 0)],
            viscosity_deviation: Some(0.05),
        }
    }

    #[test]
    fn the_first_sizes_lie_on_the_side_of_the_reduced_model_and_in_the_range() {
        assert_eq!(candidate("yield_stress", 2.5).first_sizes(), [0.0, 2.5, 5.0]);
        assert_eq!(candidate("actuation_gain", 0.95).first_sizes().len(), 3);
        assert!(candidate("actuation_gain", 0.95).first_sizes()[2] < 0.95);
        assert_eq!(candidate("yield_stress", 80.0).first_sizes(), [0.0, 80.0, 100.0]);
        // A size of nothing is no place to begin.
        assert!(candidate("yield_stress", 0.0).first_sizes()[1] > 0.1);
    }

    #[test]
    fn camera_clock_drive_and_fill_are_none_of_the_particles() {
        for (name, value) in [("fill", 0.003), ("actuation_gain", 1.08), ("camera_latency", 0.03)] {
            assert!(!candidate(name, value).is_of_the_particles(), "{name}");
        }
        for (name, value) in [
            ("yield_stress", 3.0),
            ("container_tilt", 0.035),
            ("vertical_acceleration", 0.5),
            ("radius", -0.003),
        ] {
            assert!(candidate(name, value).is_of_the_particles(), "{name}");
        }
    }

    #[test]
    fn the_last_parameter_is_the_logarithm_of_the_viscosity() {
        let (active, liquid) = candidate("yield_stress", 2.5).at(&[4.0, 0.1], &KNOWN);
        assert_eq!(active[0].values[0], 4.0);
        assert!((liquid.viscosity_pa_s - 0.2 * 0.1_f64.exp()).abs() < 1e-12);
    }
}
