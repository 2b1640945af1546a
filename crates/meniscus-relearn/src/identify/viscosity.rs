//! Viscosity by profile likelihood: the reduced model's other numbers are fitted anew at every viscosity.
//!
//! ```text
//! C(mu) = min over theta of |whitened residual|^2 + prior        interval: C(mu) <= C(best) + 2.71 max(1, misfit)
//! ```
//! (90 % of chi-squared with one degree of freedom.) Frequency and damping of linear theory are held close by the prior, because
//! the eigenvalues of the linearised equations confirm them to 0.4 and 1.5 %; what they leave is the viscosity's to explain.

use super::NUMERICAL_VISCOSITY_M2_S;
use meniscus_discover::baseline::calibrate::Calibration;
use meniscus_discover::baseline::predict::NAMES;
use meniscus_discover::fitting::error::ProblemError;
use meniscus_discover::fitting::fit::fit;
use meniscus_discover::fitting::problem::Problem;
use meniscus_discover::recordings::record::Record;
use meniscus_discover::recordings::stated::Known;
use serde::{Deserialize, Serialize};

/// Kinematic viscosities that are searched, m2/s: from a tenth of water's to a hundred times glycerine's.
const RANGE_M2_S: [f64; 2] = [1e-7, 1e-1];

/// Points of the first look over that range.
const POINTS: usize = 19;

/// Steps of the refinement: each halves the bracket, the last to 1 % of the viscosity.
const REFINEMENTS: usize = 6;

/// Steps of the search for an end of the interval.
const HALVINGS: usize = 6;

/// Rise of the cost at the ends of a 90 % interval.
const RISE: f64 = 2.706;

/// Standard deviations of the reduced model's own frequency and damping of the first mode, relative. In the simulator the
/// frequency of glycerine is 1.4 % off; a contact line or a film of a real glass adds damping that nothing here distinguishes from
/// viscosity.
const OWN_ERROR: [(&str, f64); 2] = [("frequency 1", 0.01), ("damping 1", 0.03)];

/// Kinematic viscosity below which a slosh is damped by its steepness as much as by the liquid, m2/s.
const LOW_VISCOSITY_M2_S: f64 = 2e-5;

/// Factors on the ends of the interval for what the reduced model lacks, from recordings of the simulator whose viscosity is known.
/// Of glycerine (0.950 Pa s) it finds 0.712, of water (0.001 Pa s) with crests of 9 mm it finds 0.010: the wave is steep.
const MODEL_ERROR: [f64; 2] = [1.0 / 1.5, 1.5];
const MODEL_ERROR_LOW: [f64; 2] = [1.0 / 12.0, 1.5];

/// Standard deviation of the lag between camera and motion, s.
const LAG_S: f64 = 0.004;

/// Half of an interval, relative to the value, beyond which the value is called undetermined.
const KNOWN: f64 = 0.25;

/// Number with its 90 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// Best value.
    pub best: f64,
    /// Lower and upper end.
    pub interval: [f64; 2],
}

impl Value {
    /// The viscosity below which a liquid of this density lies, where the interval reaches down to the simulator's own.
    pub(super) fn bound(&self, density_kg_m3: f64) -> Option<f64> {
        let floor = NUMERICAL_VISCOSITY_M2_S * density_kg_m3;
        (self.interval[0] < floor).then_some(self.interval[1].max(floor))
    }

    /// Whether the interval is narrow enough to call the value known: half of it is at most [`KNOWN`] of the value.
    pub(super) fn is_determined(&self) -> bool {
        self.interval[1] - self.interval[0] <= 2.0 * KNOWN * self.best.abs()
    }

    /// The viscosity with its interval widened by what the reduced model lacks of a real slosh.
    pub(super) fn with_model_error(self, density_kg_m3: f64) -> Self {
        let low = self.best < LOW_VISCOSITY_M2_S * density_kg_m3;
        let [down, up] = if low { MODEL_ERROR_LOW } else { MODEL_ERROR };
        let [least, most] = self.interval;
        Self { interval: [least * down, most * up], ..self }
    }
}

/// Fit of a constant viscosity.
#[derive(Clone, Debug)]
pub struct ViscosityFit {
    /// Viscosity, Pa s.
    pub viscosity_pa_s: Value,
    /// Whitened misfit for each number, 1 where the model holds.
    pub misfit: f64,
    /// Problem at the best viscosity.
    pub(super) problem: Problem,
    /// Numbers of the reduced model there, then the lags.
    pub(super) theta: Vec<f64>,
    /// Cost there.
    pub(super) cost: f64,
}

/// Cost as a function of the logarithm of the viscosity.
struct Profile {
    problem: Problem,
    /// Start of the next fit: numbers of the last one.
    theta: Vec<f64>,
}

impl Profile {
    /// Cost at `ln_mu`.
    fn cost(&mut self, ln_mu: f64) -> f64 {
        self.problem.known.viscosity_pa_s = ln_mu.exp();
        let fitted = fit(&self.problem, &self.theta, &[], &[]);
        self.theta = fitted.theta;
        fitted.cost
    }

    /// Where the cost passes `limit` between `inside`, where it is below, and `outside`.
    fn crossing(&mut self, mut inside: f64, mut outside: f64, limit: f64) -> f64 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if self.cost(middle) <= limit { inside = middle } else { outside = middle }
        }
        inside
    }
}

/// Calibration without references, whose frequency and damping are those of linear theory.
pub(super) fn calibration(records: &[Record]) -> Calibration {
    let mut calibration = Calibration::blind(records, LAG_S);
    for (name, deviation) in OWN_ERROR {
        if let Some(index) = NAMES.iter().position(|known| *known == name) {
            calibration.deviation[index] = deviation;
        }
    }
    calibration
}

/// Fits a constant viscosity to `records`; the viscosity of `known` is not used.
///
/// # Errors
/// [`ProblemError`], when too little was measured or a covariance cannot be factored.
pub fn fit_viscosity(records: &[Record], known: &Known) -> Result<ViscosityFit, ProblemError> {
    let problem = Problem::new(records, *known, &calibration(records), 1.0)?;
    let count = problem.count();
    let start = problem.mean.clone();
    let mut profile = Profile { problem, theta: start.clone() };
    let [low, high] = RANGE_M2_S.map(|nu| (nu * known.density_kg_m3).ln());
    let step = (high - low) / (POINTS - 1) as f64;
    let looks: Vec<(f64, f64)> = (0..POINTS)
        .map(|k| {
            // Each look has the same start, so that none inherits the valley of its neighbour.
            profile.theta.clone_from(&start);
            let ln_mu = low + step * k as f64;
            (ln_mu, profile.cost(ln_mu))
        })
        .collect();
    let least = looks.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((low, f64::INFINITY));
    let (best, cost) = refined(&mut profile, least, step, [low, high]);
    profile.cost(best);
    let theta = profile.theta.clone();
    let misfit = cost / count.max(1) as f64;
    let limit = cost + RISE * misfit.max(1.0);
    // The nearest look beyond the limit on either side; the end of the range where there is none.
    let beyond = |side: f64| {
        looks
            .iter()
            .filter(|(at, of)| (at - best) * side > 0.0 && *of > limit)
            .map(|look| look.0)
            .min_by(|a, b| (a - best).abs().total_cmp(&(b - best).abs()))
    };
    let mut end = |side: f64, range: f64| match beyond(side) {
        Some(outside) => {
            profile.theta.clone_from(&theta);
            profile.crossing(best, outside, limit)
        }
        None => range,
    };
    let interval = [end(-1.0, low), end(1.0, high)].map(f64::exp);
    profile.problem.known.viscosity_pa_s = best.exp();
    let viscosity_pa_s = Value { best: best.exp(), interval }.with_model_error(known.density_kg_m3);
    Ok(ViscosityFit { viscosity_pa_s, misfit, problem: profile.problem, theta, cost })
}

/// Minimum near `least`, whose neighbours stand `step` away, within `range`: the bracket halves around the lowest.
fn refined(profile: &mut Profile, least: (f64, f64), mut step: f64, range: [f64; 2]) -> (f64, f64) {
    let mut best = least;
    for _ in 0..REFINEMENTS {
        step /= 2.0;
        for at in [best.0 - step, best.0 + step] {
            let at = at.clamp(range[0], range[1]);
            let cost = profile.cost(at);
            if cost < best.1 {
                best = (at, cost);
            }
        }
    }
    best
}
