//! A law of two or three numbers by simulation: the flow curve that fits best.
//!
//! Each round searches the stress at the typical rate ([`FlowCurve`]), with the derivatives by index and share of the yield stress
//! simulated at the best one. A prior around the last round bounds how far index and share move in one; the rounds end where they
//! stay, and the prior with them. With the particles of the training the curve is fitted once more, under no such prior: the
//! interval is of the recordings alone.

use super::by_simulation::{APART, COARSE_M, Fit, PACKINGS, sets_of};
use super::flow_curve::{CurveForward, FlowCurve, RATE};
use super::identified::{FlowStress, Identified};
use super::law_interval::{CurveRegion, LinearRegion};
use super::viscosity::Value;
use meniscus_discover::recordings::stated::Known;
use meniscus_discover::sizing::error::SizingError;
use meniscus_discover::sizing::interval::{Linearised, SizeVariance};
use meniscus_discover::sizing::search::{Level, SizeRange, SizeSearch, Start};
use nalgebra::DMatrix;

/// Rounds with coarse particles at most.
const ROUNDS: usize = 6;

/// A round that moves no number further than this is the last.
const STAYS: f64 = 0.03;

/// Standard deviation of index and share around the last round.
const DAMPING: f64 = 0.15;

/// Standard deviation of index and share that says nothing within their ranges.
const FREE: f64 = 1.0;

/// Logarithms of the stress that a round and the last search try first, from where they start.
const FIRST: [f64; 3] = [-0.2, 0.0, 0.2];
const LAST: [f64; 2] = [0.0, 0.08];

/// Largest change of the logarithm of the stress in a round.
const REACH: f64 = 0.6;

/// Most stresses that a round and the last search try.
const MOST: [usize; 2] = [5, 4];

/// One search of the flow curve.
struct CurveSearch {
    spacing_m: f64,
    start: Start,
    /// Deviation of the prior of index and share.
    deviation: f64,
    packings: usize,
    most: usize,
}

impl Fit<'_> {
    /// The liquid whose flow curve fits best, from where the reduced model stands.
    pub(super) fn law(&self, known: &Known) -> Result<Identified, SizingError> {
        let known = Known { viscosity_pa_s: 1.0, ..*known };
        let rough = self.rough;
        let best = |value: Option<Value>, absent: f64| value.map_or(absent, |value| value.best);
        let mut at = FlowCurve::of(
            rough.consistency_pa_sn.best,
            best(rough.index, 1.0),
            best(rough.yield_stress_pa, 0.0),
        );
        let coarse_m = self.spacing_m.max(COARSE_M);
        let mut coarse = self.round(&known, at, coarse_m)?;
        for _ in 1..ROUNDS {
            let moved = self.curve(&coarse).distance(&at);
            at = self.curve(&coarse);
            if moved < STAYS {
                break;
            }
            coarse = self.round(&known, at, coarse_m)?;
        }
        let at = self.curve(&coarse);
        let fine = self.spacing_m < APART * COARSE_M;
        let last = self.curve_search(
            &known,
            &CurveSearch {
                spacing_m: self.spacing_m,
                start: Start {
                    sizes: LAST.map(|step| at.log_stress + step).to_vec(),
                    others: at.others(rough.law),
                    slopes: None,
                },
                deviation: FREE,
                packings: PACKINGS,
                most: MOST[1],
            },
        )?;
        Ok(self.identified_law(&last, fine.then_some(&at)))
    }

    /// A round of the search with coarse particles.
    fn round(&self, known: &Known, at: FlowCurve, spacing_m: f64) -> Result<Level, SizingError> {
        let start = Start {
            sizes: FIRST.map(|step| at.log_stress + step).to_vec(),
            others: at.others(self.rough.law),
            slopes: None,
        };
        self.curve_search(
            known,
            &CurveSearch { spacing_m, start, deviation: DAMPING, packings: 1, most: MOST[0] },
        )
    }

    fn curve_search(&self, known: &Known, search: &CurveSearch) -> Result<Level, SizingError> {
        let law = self.rough.law;
        let candidate = self.candidate();
        let start = &search.start;
        let middle =
            FlowCurve::at(law, start.sizes.iter().sum::<f64>() / start.sizes.len() as f64, &start.others);
        self.with_forward(known, search.spacing_m, &candidate, |inner, observed| {
            let forward = CurveForward { inner, law, unit_pa_sn: known.viscosity_pa_s };
            let first: Vec<f64> = start.sizes[..1].iter().chain(&start.others).copied().collect();
            self.expect(inner, forward.liquid(&first).iter(), sets_of(start, search.packings));
            let sizes = SizeSearch {
                forward: &forward,
                observed,
                // A change of the logarithm is relative by itself.
                range: SizeRange {
                    bounds: (middle.log_stress - REACH, middle.log_stress + REACH),
                    neutral: middle.log_stress - 1.0,
                },
                others: &middle.parameters(law, search.deviation),
                packings: search.packings,
                most_sizes: search.most,
            };
            sizes.run(start)
        })
    }

    /// The flow curve at the end of a search.
    fn curve(&self, level: &Level) -> FlowCurve {
        FlowCurve::at(self.rough.law, level.fit.size, &level.fit.others)
    }

    /// The liquid at the end of the last search; `coarse` is the curve that coarser particles gave.
    fn identified_law(&self, last: &Level, coarse: Option<&FlowCurve>) -> Identified {
        let law = self.rough.law;
        let best = self.curve(last);
        let half = |which: usize, of: fn(&FlowCurve) -> f64, whole: f64| {
            let [curvature, packings] = last.variance.get(which).copied().unwrap_or_default();
            let spacing = self.spacing(of(&best), coarse.map(of), whole);
            SizeVariance { curvature, packings, spacing }.half_width()
        };
        let index = law.has_index().then(|| half(1, |curve| curve.index, 0.0));
        let share = law.has_yield_stress().then(|| {
            let which = 1 + usize::from(law.has_index());
            half(which, |curve| curve.share, 0.0)
        });
        let region = CurveRegion::of(&LinearRegion {
            best,
            law,
            half: [Some(half(0, |curve| curve.log_stress, 1.0)), index, share]
                .into_iter()
                .flatten()
                .collect(),
            correlation: correlation(last),
        });
        let value = |of: fn(&FlowCurve) -> f64| Value { best: of(&best), interval: region.ends(of) };
        let tried = last.sizes.iter().map(|size| FlowCurve { log_stress: *size, ..best }.consistency_pa_sn());
        Identified {
            consistency_pa_sn: value(FlowCurve::consistency_pa_sn),
            index: index.map(|_| value(|curve| curve.index)),
            yield_stress_pa: share.map(|_| value(FlowCurve::yield_stress_pa)),
            stress: Some(FlowStress { rate_per_s: RATE, stress_pa: value(FlowCurve::stress_pa) }),
            undetermined_below_pa_s: None,
            misfit: last.misfit,
            by_simulation: Some(self.simulated(tried.collect())),
            ..self.rough.clone()
        }
    }
}

/// Correlation of the numbers at the best fit of `level`; none where it cannot be formed.
fn correlation(level: &Level) -> DMatrix<f64> {
    let count = level.variance.len();
    let Some(linear) = Linearised::of(&level.mapped.emulator, &level.fit) else {
        return DMatrix::identity(count, count);
    };
    let deviation = linear.inverse.diagonal().map(f64::sqrt);
    DMatrix::from_fn(linear.inverse.nrows(), linear.inverse.ncols(), |i, j| {
        linear.inverse[(i, j)] / (deviation[i] * deviation[j])
    })
}
