//! Decision whether a law is drawn where the verdict is `unknown`, and everything that is said of it.
//!
//! ```text
//! gain = fall of the cost - freedom ln n,   freedom: numbers of the law that the data set and not the prior
//! drawn where  gain >= the largest bound of one more clean glass,   half of the recordings left out are predicted better
//! ```
//! The strongest recording is not left out: no other one reaches its heights, and a curve says nothing beyond its end.

use super::band::{Bands, Calibrated, bands};
use super::fit::{LawFit, fit_again, fit_law};
use super::nearest::{Nearest, nearest};
use super::shape::Extent;
use crate::baseline::predict::{Difference, SHARED};
use crate::decision::evidence::HeldOutScore;
use crate::decision::settings::Settings;
use crate::findings::Findings;
use crate::findings::gap::{LawGap, law_gap};
use crate::findings::suggest::{Rival, Suggestion, suggest_between};
use crate::fitting::fit::{Fitted, fit};
use crate::fitting::problem::Problem;
use crate::recordings::record::{Quantity, Record};
use rayon::prelude::*;

/// Reason for which no law is drawn.
#[derive(Clone, Debug, PartialEq)]
pub enum NoLaw {
    /// The glass does not go along one line, or is inclined or lifted.
    NotAlongOneLine,
    /// The recordings have no slope of the surface.
    NoSlope,
    /// The recordings cannot be fitted with a law.
    NoFit {
        /// Step that fails.
        step: &'static str,
    },
    /// A force on the first mode explains too little.
    ExplainsTooLittle {
        /// Decrease of BIC from the model without a force, and the one that is needed.
        gain: f64,
        /// Gain that is needed.
        needed: f64,
        /// Score on recordings left out.
        held_out: HeldOutScore,
    },
}

impl std::fmt::Display for NoLaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotAlongOneLine => write!(
                f,
                "the glass is inclined, lifted or moved across, and a law is drawn for motions along one line; record such"
            ),
            Self::NoSlope => write!(f, "the recordings have no slope of the surface; record profiles"),
            Self::NoFit { step } => {
                write!(f, "no force on the first mode could be fitted to the recordings ({step} fails)")
            }
            Self::ExplainsTooLittle { gain, needed, held_out } => write!(
                f,
                "a force on the first mode explains too little (BIC {gain:.0} lower, {needed:.0} needed; {} of {} recordings left \
                 out are predicted better): look at the camera, the clocks and the level at rest",
                held_out.better, held_out.recordings
            ),
        }
    }
}

/// Power of the rate that fits the drag best: an offer, not a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Drag at the fastest rate, N.
    pub at_fastest_n: f64,
    /// Exponent.
    pub exponent: f64,
    /// Largest distance from the drag, in half-widths of its band.
    pub distance: f64,
}

/// A drawn law with its evidence.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Fit.
    pub fit: LawFit,
    /// Curves with their bands.
    pub bands: Bands,
    /// Decrease of BIC from the model without a force.
    pub gain: f64,
    /// Misfit per number with the law.
    pub misfit: f64,
    /// Score on recordings left out.
    pub held_out: HeldOutScore,
    /// Part of the conservative force that is lopsided: root mean square of its even part over that of the whole.
    pub even_share: f64,
    /// Power law of the drag, where there is a drag.
    pub power: Option<PowerLaw>,
    /// Nearest formula of the library.
    pub nearest: Option<Nearest>,
    /// Errors on the held-out recording, where there is one.
    pub gap: Option<LawGap>,
    /// Recording that distinguishes the law from the nearest formula best.
    pub suggestion: Option<Suggestion>,
}

/// Draws the law of what is missing in `findings`, whatever their verdict is, with the factors `calibrated` on its bands.
///
/// # Errors
/// [`NoLaw`].
pub fn drawn(findings: &Findings, settings: &Settings, calibrated: Calibrated) -> Result<Drawn, NoLaw> {
    let records = &findings.split.fitted;
    if records.iter().any(|r| !r.drive.is_planar() || r.drive.holds() != [false; 2]) {
        return Err(NoLaw::NotAlongOneLine);
    }
    let problem = Problem::new(records, findings.known, &findings.calibration, settings.noise)
        .map_err(|_| NoLaw::NoFit { step: "the covariance" })?;
    let plain = &findings.assessment.search.first;
    let extent = Extent::of(records, &findings.known, &plain.theta).ok_or(NoLaw::NoSlope)?;
    let fitted = fit_law(&problem, extent, &plain.theta).ok_or(NoLaw::NoFit { step: "a prediction" })?;
    let count = problem.count();
    let gain = plain.cost - fitted.cost - fitted.freedom() * (count as f64).ln();
    let needed = needed(findings);
    let held_out = cross_validate(&problem, plain, &fitted);
    if gain < needed || 2 * held_out.better < held_out.recordings {
        return Err(NoLaw::ExplainsTooLittle { gain, needed, held_out });
    }
    let bands = bands(&fitted, count, settings.seed, calibrated).ok_or(NoLaw::NoFit { step: "the band" })?;
    let interval_s = records.first().map_or(1.0 / 60.0, |record| record.interval_s);
    let ranking = &findings.assessment.search.ranking;
    let nearest = nearest(&fitted, &bands, ranking, &findings.known, interval_s);
    let gap = findings.split.held_out.as_ref().and_then(|held_out| {
        law_gap(held_out, &findings.calibration, &problem, (&fitted.theta, &fitted.law), settings.noise).ok()
    });
    let mine = Rival {
        name: "the drawn law",
        theta: &fitted.theta,
        difference: Difference { active: &[], law: Some(&fitted.law) },
    };
    let other = nearest.as_ref().and_then(|near| {
        let of = ranking.iter().find(|c| c.last() == near.name)?.fitted.as_ref()?;
        Some(Rival {
            name: near.name,
            theta: &of.theta,
            difference: Difference { active: &of.active, law: None },
        })
    });
    let suggestion = other.and_then(|other| suggest_between(&problem, &findings.calibration, &mine, &other));
    Ok(Drawn {
        even_share: even_share(&bands.force.value),
        power: power_law(&bands),
        misfit: fitted.chi2(count),
        fit: fitted,
        bands,
        gain,
        held_out,
        nearest,
        gap,
        suggestion,
    })
}

/// Returns the gain that a law needs: what an effect of as many numbers would need.
fn needed(findings: &Findings) -> f64 {
    // The bounds were learnt for effects of one or two numbers; the largest of them is taken for the law.
    findings.limits.bound.values().copied().fold(findings.limits.gain, f64::max)
}

/// Returns the largest slope of the surface in `record`, m.
fn largest_slope_m(record: &Record) -> f64 {
    let slopes = record.channels.iter().filter(|c| c.quantity == Quantity::Slope);
    slopes.flat_map(|c| &c.value).flatten().fold(0.0, |m: f64, z| m.max(z.abs()))
}

/// Scores the law against nothing on recordings that the fits do not see: each but the strongest is left out in turn.
fn cross_validate(problem: &Problem, plain: &Fitted, law: &LawFit) -> HeldOutScore {
    let slopes: Vec<f64> = problem.records().map(largest_slope_m).collect();
    let strongest = (0..slopes.len()).max_by(|i, j| slopes[*i].total_cmp(&slopes[*j]));
    let tried: Vec<usize> = (0..slopes.len()).filter(|which| Some(*which) != strongest).collect();
    let improvement = |which: usize| {
        let others = problem.without(which);
        let start = |theta: &[f64]| {
            let mut start = theta.to_vec();
            start.remove(SHARED + which);
            start
        };
        let without = fit(&others, &start(&plain.theta), &[], &[]);
        let with = fit_again(&others, law, &start(&law.theta))?;
        let nothing = problem.held_out_misfit(which, &without.theta, Difference::default());
        let difference = Difference { active: &[], law: Some(&with.law) };
        Some(nothing - problem.held_out_misfit(which, &with.theta, difference))
    };
    let improvements: Vec<f64> =
        tried.par_iter().map(|which| improvement(*which).unwrap_or(f64::NEG_INFINITY)).collect();
    HeldOutScore {
        better: improvements.iter().filter(|gained| **gained > 0.0).count(),
        recordings: improvements.len(),
        improvement: improvements.iter().sum(),
    }
}

/// Returns the even part of the force at heights that lie evenly around rest, over the whole.
fn even_share(force_n: &[f64]) -> f64 {
    let pairs = || force_n.iter().zip(force_n.iter().rev());
    let even: f64 = pairs().map(|(f, g)| (0.5 * (f + g)).powi(2)).sum();
    let whole: f64 = force_n.iter().map(|f| f * f).sum();
    (even / whole.max(f64::MIN_POSITIVE)).sqrt()
}

/// Returns the power law that fits the drag best, weighted by its band; none where all of the band is zero.
fn power_law(bands: &Bands) -> Option<PowerLaw> {
    let drag = &bands.drag;
    if drag.largest_distance(&vec![0.0; drag.at.len()]) <= 1.0 {
        return None;
    }
    let fastest = *drag.at.last()?;
    let at = |exponent: f64| {
        let shape: Vec<f64> = drag.at.iter().map(|u| (u / fastest).powf(exponent)).collect();
        let weighted = |a: &[f64], b: &[f64]| -> f64 {
            a.iter().zip(b).zip(&drag.half).map(|((a, b), half)| a * b / (half * half)).sum()
        };
        let size = weighted(&shape, &drag.value) / weighted(&shape, &shape);
        let curve: Vec<f64> = shape.iter().map(|s| size * s).collect();
        (
            drag.distance(&curve),
            PowerLaw { at_fastest_n: size, exponent, distance: drag.largest_distance(&curve) },
        )
    };
    let tried = (0..=120).map(|i| at(0.025 * f64::from(i)));
    tried.min_by(|a, b| a.0.total_cmp(&b.0)).map(|best| best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::band::Band;

    fn band(drag: impl Fn(f64) -> f64) -> Bands {
        let at: Vec<f64> = (1..=20).map(|i| 0.01 * f64::from(i)).collect();
        let value: Vec<f64> = at.iter().map(|u| drag(*u)).collect();
        let drag = Band { half: vec![1e-3; 20], at, value };
        Bands { force: drag.clone(), drag }
    }

    #[test]
    fn a_power_is_offered_with_its_exponent_and_nothing_where_there_is_no_drag() {
        let power = power_law(&band(|u| 0.3 * u.powf(1.5))).expect("a drag");
        assert_eq!(power.exponent, 1.5);
        assert!(power.distance < 1e-6 && (power.at_fastest_n - 0.3 * 0.2_f64.powf(1.5)).abs() < 1e-9);
        assert_eq!(power_law(&band(|_| 5e-4)), None);
    }

    #[test]
    fn the_even_share_tells_a_lopsided_spring_from_one_that_is_not() {
        let force = |law: fn(f64) -> f64| -> Vec<f64> { (-8..=8).map(|i| law(0.1 * f64::from(i))).collect() };
        assert!(even_share(&force(|x| x * x * x)) < 1e-12);
        assert!((even_share(&force(|x| x * x)) - 1.0).abs() < 1e-12);
    }
}
