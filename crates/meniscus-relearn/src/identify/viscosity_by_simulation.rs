//! A constant viscosity by simulation: coarse particles over a factor of 25, then those of the training.

use super::by_simulation::{APART, COARSE_M, Fit, PACKINGS, sets_of};
use super::identified::Identified;
use super::viscosity::Value;
use meniscus_discover::recordings::stated::Known;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::interval::SizeVariance;
use meniscus_discover::sizing::search::{Level, SizeSearch, Start};

/// Viscosities that are tried first, over the one that the search starts from.
const FIRST: [f64; 3] = [0.65, 1.0, 1.5];

/// Most sizes that are tried at the coarse and at the fine spacing.
const MOST: [usize; 2] = [7, 4];

/// Sizes that the fine search starts from, over the one that the coarse search found.
const FINE: [f64; 2] = [1.0, 1.12];

/// Searches with coarse particles: each ends within a factor of five of where it starts.
const CENTRES: usize = 3;

impl Fit<'_> {
    /// The liquid whose viscosity fits best, from where the reduced model stands.
    pub(super) fn viscosity(&self, known: &Known) -> Result<Identified, SizingError> {
        let (known, coarse) = self.coarse(known)?;
        let fine = if self.spacing_m < APART * COARSE_M { Some(self.fine(&known, &coarse)?) } else { None };
        Ok(self.identified(&known, &coarse, fine.as_ref()))
    }

    /// Searches from `start` with particles at `spacing_m`.
    fn search(
        &self,
        known: &Known,
        spacing_m: f64,
        start: &Start,
        limits: (usize, usize),
    ) -> Result<Level, SizingError> {
        let candidate = self.candidate();
        let (packings, most_sizes) = limits;
        self.with_forward(known, spacing_m, &candidate, |forward, observed| {
            self.expect(forward, [start.sizes[0]].iter().chain(&start.others), sets_of(start, packings));
            let search = SizeSearch {
                forward,
                observed,
                range: candidate.range(),
                others: &candidate.others(),
                packings,
                most_sizes,
            };
            search.run(start)
        })
    }

    /// The search with coarse particles, and the liquid that it counts from.
    fn coarse(&self, known: &Known) -> Result<(Known, Level), SizingError> {
        let spacing_m = self.spacing_m.max(COARSE_M);
        let mut known = Known { viscosity_pa_s: self.rough.consistency_pa_sn.best, ..*known };
        let start = Start { sizes: FIRST.to_vec(), others: self.candidate().first_others(), slopes: None };
        let packings = if self.spacing_m < APART * COARSE_M { 1 } else { PACKINGS };
        let mut level = self.search(&known, spacing_m, &start, (packings, MOST[0]))?;
        for _ in 1..CENTRES {
            let Some(end) = level.end else { break };
            known.viscosity_pa_s *= end;
            level = self.search(&known, spacing_m, &start, (packings, MOST[0]))?;
        }
        Ok((known, level))
    }

    /// The search with the particles of the training, near what coarse ones found.
    fn fine(&self, known: &Known, coarse: &Level) -> Result<Level, SizingError> {
        let (low, high) = self.candidate().range().bounds;
        let sizes = FINE.map(|factor| (factor * coarse.fit.size).clamp(low, high)).to_vec();
        let start = Start { sizes, others: coarse.fit.others.clone(), slopes: Some(coarse.slopes.clone()) };
        self.search(known, self.spacing_m, &start, (PACKINGS, MOST[1]))
    }

    /// The liquid at the end of the last search.
    fn identified(&self, known: &Known, coarse: &Level, fine: Option<&Level>) -> Identified {
        let last = fine.unwrap_or(coarse);
        let [curvature, packings] = last.variance.first().copied().unwrap_or_default();
        let spacing = self.spacing(last.fit.size, fine.map(|_| coarse.fit.size), last.fit.size);
        let half = SizeVariance { curvature, packings, spacing }.half_width();
        let parameter = self.candidate().parameter(0);
        let (best, (least, most), (none, all)) = (last.fit.size, parameter.range, parameter.admissible);
        let si = |coordinate: f64| parameter.to_value(coordinate, &known.stated());
        // Beyond the sizes that a search may try nothing is known: there the interval ends where any liquid does.
        let low = if best - half > least { si(best - half) } else { none };
        let high = if best + half < most { si(best + half) } else { all };
        let viscosity = Value { best: si(best), interval: [low, high] };
        Identified {
            consistency_pa_sn: viscosity,
            undetermined_below_pa_s: viscosity.bound(known.density_kg_m3),
            misfit: last.misfit,
            by_simulation: Some(
                self.simulated(last.sizes.iter().map(|size| size * known.viscosity_pa_s).collect()),
            ),
            ..self.rough.clone()
        }
    }
}
