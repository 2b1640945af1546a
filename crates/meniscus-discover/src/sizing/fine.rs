//! Size at the fine spacing, from size and derivatives at the coarse one.

use super::error::SizingError;
use super::search::{Level, SizeSearch, Start};
use super::stage::{Coarse, MOST_SIZES, Stage};

/// Distance of the second size from the first, relative to the effect: least and largest.
const STEP: (f64, f64) = (0.08, 0.3);

impl Stage<'_> {
    /// Sizes a candidate at the fine spacing. Residuals of neighbouring frames count once ([`Coarse::weighted`]).
    pub(super) fn fine(&self, coarse: &Coarse) -> Result<Level, SizingError> {
        let Coarse { candidate, level, scores, weighted } = coarse;
        let alike = scores.correlation.max(1.0);
        let mut observed = self.observed(&self.fitted);
        let channels = observed.iter_mut().flat_map(|observed| &mut observed.channels);
        channels.for_each(|channel| channel.sigma_m *= alike.sqrt());
        let forward = self.forward(candidate, &self.fitted, self.settings.spacing_m);
        let range = candidate.range();
        let typical = candidate.parameter(0).typical.abs();
        let found = weighted.size - range.neutral;
        let excess = found.abs().max(0.1 * typical);
        let deviation = level.variance[0].iter().map(|component| component.variance).sum::<f64>().sqrt();
        let step = (2.0 * deviation).clamp(STEP.0 * excess, STEP.1 * excess);
        // Away from the absent effect, unless the range ends there.
        let step =
            step.copysign(if found == 0.0 { candidate.first_sizes()[1] - range.neutral } else { found });
        let (low, high) = range.bounds;
        let second = if (low..=high).contains(&(weighted.size + step)) {
            weighted.size + step
        } else {
            weighted.size - step
        };
        let start = Start {
            sizes: vec![weighted.size, second],
            others: weighted.others.clone(),
            slopes: Some(level.slopes.clone()),
        };
        let search = SizeSearch {
            forward: &forward,
            observed: &observed,
            range,
            others: &candidate.others(),
            packings: self.settings.packings,
            most_sizes: MOST_SIZES,
        };
        let level = search.run(&start)?;
        Ok(Level { misfit: alike * level.misfit, ..level })
    }
}
