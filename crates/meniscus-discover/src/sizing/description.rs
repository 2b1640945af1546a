//! Outcome of a candidate for people: sizes in SI with their intervals.

use super::cautions;
use super::interval::{Component, SizeVariance, spacing_error};
use super::outcome::{SizedCandidate, SizedParameter, SpacingResult};
use super::search::Level;
use super::stage::{Coarse, Stage};
use meniscus::reduced::effects::Parameter;

impl Stage<'_> {
    /// Returns the outcome for people, from the fine search where there was one.
    pub(super) fn described(&self, coarse: &Coarse, fine: Option<Level>) -> SizedCandidate {
        let Coarse { candidate, level: first, scores, weighted } = coarse;
        let spacings = self.settings.spacings_m();
        let last = fine.as_ref().unwrap_or(first);
        let stated = self.findings.known.stated();
        let parameter = candidate.parameter(0);
        let si = |parameter: &Parameter, value: f64| parameter.to_value(value, &stated);
        let result = |level: &Level, spacing_m: f64| SpacingResult {
            spacing_m,
            value: si(parameter, level.fit.size),
            sizes: level.sizes.iter().map(|size| si(parameter, *size)).collect(),
            misfit: level.misfit,
        };
        let spacing = match &fine {
            Some(fine) => spacing_error((spacings[0], weighted.size), (spacings[1], fine.fit.size)),
            None => Component::default(),
        };
        let parts = |which: usize| {
            let [curvature, packings] = last.variance.get(which).copied().unwrap_or_default();
            let spacing = if which == 0 { spacing } else { Component::default() };
            SizeVariance { curvature, packings, spacing }
        };
        let values: Vec<f64> =
            std::iter::once(last.fit.size).chain(last.fit.others.iter().copied()).collect();
        let parameters = (0..candidate.free.len())
            .map(|which| {
                let (parameter, half) = (candidate.parameter(which), parts(which).half_width());
                let (low, high) = parameter.range;
                let (effect, index) = candidate.free[which];
                SizedParameter {
                    effect: candidate.active[effect].entry.name,
                    parameter: parameter.name,
                    unit: parameter.unit,
                    value: si(parameter, values[which]),
                    interval: (
                        si(parameter, (values[which] - half).max(low)),
                        si(parameter, (values[which] + half).min(high)),
                    ),
                    reduced: si(parameter, candidate.active[effect].values[index]),
                    absent: si(parameter, parameter.neutral),
                }
            })
            .collect();
        let viscosity = candidate.viscosity_deviation.map(|_| {
            let which = candidate.free.len();
            let (logarithm, half) = (values[which], parts(which).half_width());
            (logarithm.exp(), ((logarithm - half).exp(), (logarithm + half).exp()))
        });
        let (active, known) = candidate.at(&values, &self.findings.known);
        let mut results = vec![result(first, spacings[0])];
        results.extend(fine.as_ref().map(|fine| result(fine, spacings[1])));
        SizedCandidate {
            names: candidate.names.clone(),
            parameters,
            viscosity,
            active,
            known,
            variance: parts(0),
            spacings: results,
            scores: scores.clone(),
            cautions: cautions::of(candidate, last, parts(0).half_width(), &stated),
            refutation: cautions::refutation(candidate, first, &stated, self.is_controlled()),
        }
    }
}
