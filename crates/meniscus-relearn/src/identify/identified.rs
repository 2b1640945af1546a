//! Identified liquid: numbers of its law of flow with their intervals, and the liquid file that they make.

use super::viscosity::Value;
use crate::law::Law;
use crate::liquid_file::Sources;
use crate::liquid_source::LiquidSource;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::{Liquid, Rheology};
use serde::{Deserialize, Serialize};

/// Identified liquid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identified {
    /// Law of flow that was taken.
    pub law: Law,
    /// Viscosity or consistency, Pa s^n.
    pub consistency_pa_sn: Value,
    /// Flow index, where the law has one.
    pub index: Option<Value>,
    /// Yield stress, Pa, where the law has one.
    pub yield_stress_pa: Option<Value>,
    /// Stress at a typical rate, where the law has more than one number.
    #[serde(default)]
    pub stress: Option<FlowStress>,
    /// Viscosity below which the liquid lies, Pa s, where the recordings and the simulator cannot tell more.
    pub undetermined_below_pa_s: Option<f64>,
    /// Whitened misfit of the fit.
    pub misfit: f64,
    /// Gain in the information criterion over a constant viscosity.
    pub gain: f64,
    /// Recordings that were fitted.
    pub recordings: Vec<String>,
    /// Simulations by which the numbers were found; none where the reduced model alone was fitted.
    #[serde(default)]
    pub by_simulation: Option<BySimulation>,
}

/// Point of the flow curve. The recordings tell it better than the numbers of the law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowStress {
    /// Rate of shear, 1/s.
    pub rate_per_s: f64,
    /// Stress there, Pa.
    pub stress_pa: Value,
}

/// Result of the simulations beside the liquid itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BySimulation {
    /// Viscosity by the reduced model alone, Pa s^n.
    pub reduced_pa_sn: Value,
    /// Viscosities or consistencies that were simulated with the finest particles, Pa s^n.
    pub tried_pa_sn: Vec<f64>,
    /// Spacing of the finest particles, m.
    pub spacing_m: f64,
    /// Simulated motions.
    pub simulations: usize,
}

impl Identified {
    /// Returns the liquid of `source` with these numbers, and the source of each.
    #[must_use]
    pub fn liquid(&self, source: &LiquidSource) -> Option<(Liquid, Sources)> {
        let LiquidSource::Identified { name, density_kg_m3, stated_viscosity_pa_s, .. } = source else {
            return None;
        };
        let (model, about) = match self.by_simulation {
            Some(_) => ("simulator", ""),
            None => ("reduced model", "roughly "),
        };
        let from = format!("fit of the {model} to {}", self.recordings.join(", "));
        let of =
            |value: &Value| format!("{from}; {about}{:.4} to {:.4}", value.interval[0], value.interval[1]);
        let mut viscosity = (self.consistency_pa_sn.best, of(&self.consistency_pa_sn));
        if let Some(below) = self.undetermined_below_pa_s {
            let undetermined = format!("{from}; undetermined, below {below:.4}");
            viscosity = match stated_viscosity_pa_s.filter(|stated| *stated < below) {
                Some(stated) => (stated, format!("as stated; {undetermined}")),
                None => (viscosity.0, undetermined),
            };
        }
        let rheology = match (self.index, self.yield_stress_pa) {
            (None, None) => Rheology::newtonian(viscosity.0),
            (index, stress) => Rheology {
                consistency: viscosity.0,
                index: index.map_or(1.0, |value| value.best),
                yield_stress: stress.map_or(0.0, |value| value.best),
                largest: Rheology::newtonian(viscosity.0).largest,
            },
        };
        let liquid = Liquid {
            name: name.clone(),
            density_kg_m3: *density_kg_m3,
            rheology,
            effects: Effects::default(),
        };
        let absent = || String::from("not part of the law");
        let sources = Sources {
            density: "as stated".into(),
            viscosity: viscosity.1,
            index: self.index.as_ref().map_or_else(absent, of),
            yield_stress: self.yield_stress_pa.as_ref().map_or_else(absent, of),
        };
        Some((liquid, sources))
    }

    /// Returns the result in a sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let about = if self.by_simulation.is_some() { "" } else { "roughly " };
        let of = |value: &Value, unit: &str| {
            let [low, high] = value.interval;
            if self.by_simulation.is_some() && !value.is_determined() {
                let best = value.best;
                return format!("undetermined between {low:.4} and {high:.4}{unit} ({best:.4} fits best)");
            }
            format!("{:.4} ({about}{low:.4} to {high:.4}){unit}", value.best)
        };
        let mut text = match (self.undetermined_below_pa_s, &self.stress) {
            (Some(below), _) => format!(
                "viscosity undetermined, below {below:.4} Pa s ({:.4} fits best, and is simulated unless a lower one is stated)",
                self.consistency_pa_sn.best
            ),
            (None, Some(stress)) => format!(
                "stress at {:.0} 1/s {}, consistency {}",
                stress.rate_per_s,
                of(&stress.stress_pa, " Pa"),
                of(&self.consistency_pa_sn, " Pa s^n")
            ),
            (None, None) if self.index.is_some() => {
                format!("consistency {}", of(&self.consistency_pa_sn, " Pa s^n"))
            }
            (None, None) => format!("viscosity {}", of(&self.consistency_pa_sn, " Pa s")),
        };
        text += &self.index.as_ref().map_or(String::new(), |value| format!(", flow index {}", of(value, "")));
        let stress = self.yield_stress_pa.as_ref();
        text += &stress.map_or(String::new(), |value| format!(", yield stress {}", of(value, " Pa")));
        if let Some(by) = &self.by_simulation {
            text += &format!(
                ", by {} simulations; the reduced model alone gives {:.4}",
                by.simulations, by.reduced_pa_sn.best
            );
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::Law;

    fn value(best: f64, interval: [f64; 2]) -> Value {
        Value { best, interval }
    }

    #[test]
    fn numbers_that_the_recordings_leave_open_are_said_to_be_undetermined() {
        let known = Identified {
            law: Law::HerschelBulkley,
            consistency_pa_sn: value(3.6, [1.8, 5.7]),
            index: Some(value(0.26, [0.18, 0.34])),
            yield_stress_pa: Some(value(1.4, [0.0, 3.9])),
            stress: Some(FlowStress { rate_per_s: 10.0, stress_pa: value(8.0, [7.5, 8.6]) }),
            undetermined_below_pa_s: None,
            misfit: 2.0,
            gain: 0.0,
            recordings: vec!["one".into()],
            by_simulation: Some(BySimulation {
                reduced_pa_sn: value(2.9, [1.0, 6.0]),
                tried_pa_sn: vec![3.6],
                spacing_m: 0.005,
                simulations: 9,
            }),
        };
        let said = known.sentence();
        assert!(
            said.starts_with("stress at 10 1/s 8.0000 (7.5000 to 8.6000) Pa, consistency undetermined"),
            "{said}"
        );
        assert!(
            said.contains("yield stress undetermined between 0.0000 and 3.9000 Pa (1.4000 fits best)"),
            "{said}"
        );
        let newtonian = Identified { stress: None, index: None, yield_stress_pa: None, ..known };
        let narrow = Identified { consistency_pa_sn: value(0.95, [0.82, 1.08]), ..newtonian };
        assert!(
            narrow.sentence().starts_with("viscosity 0.9500 (0.8200 to 1.0800) Pa s"),
            "{}",
            narrow.sentence()
        );
    }
}
