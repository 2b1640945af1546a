//! Bounds of one more clean glass after a few: pooled overdispersion and misfit, each with a prior.
//!
//! Each reference is judged by the others. Effect e lowers its cost (minus twice the logarithm of the likelihood) by T_e
//! although nothing is hidden. Were the model exact, T_e would be chi-squared with its p free parameters. It is not, and
//! its error resembles some effects more than others:
//! ```text
//! T_e ~ phi_e chi2_p,       phi_e ~ scaled inverse chi2(nu, phi)                     (nu, phi) shared by all effects
//! phi_e | n references      (nu phi + sum T_e)/(nu + n p), at least 1
//! T_e of the next / (p phi_e) ~ F(p, nu + n p),      bound_e = p phi_e F_(1 - c/K)(p, nu + n p)
//! ln phi                    (m ln phi_0 + n mean over e of ln max(mean of T_e/p over references, 1))/(m + n)
//! ```
//! (overdispersion and its F test: McCullagh and Nelder 1989, 4.5; empirical Bayes: Efron and Morris 1975; conjugate prior:
//! Gelman et al. 2013, 2.6). So an effect that three references happen to show little of is not bounded by luck, and
//! with none at all a bound exists. The logarithm of a misfit is normal with both its moments unknown, with the conjugate
//! prior (Gelman et al. 2013, 3.3):
//! ```text
//! m = (k m_0 + sum x)/(k + n),    s^2 = (nu s_0^2 + sum (x - mean)^2 + k n/(k + n) (mean - m_0)^2)/(nu + n)
//! bound = m + t_c(nu + n) s sqrt(1 + 1/(k + n))
//! ```

use meniscus_numerics::statistics::{f_exceeded, student_t_exceeded};

/// Degrees of freedom nu that the pooled overdispersion of an effect counts.
const FREEDOM: f64 = 4.0;

/// References m that the prior overdispersion counts, and that overdispersion phi_0: an exact model's.
const PRIOR_REFERENCES: f64 = 2.0;
const PRIOR_OVERDISPERSION: f64 = 1.0;

/// Prior of the logarithm of a misfit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct MisfitPrior {
    /// Mean m_0.
    pub(super) mean: f64,
    /// Standard deviation s_0.
    pub(super) deviation: f64,
}

/// Weight k of the prior mean of a misfit, in references, and degrees of freedom nu of its deviation.
const PRIOR_WEIGHT: f64 = 1.0;
const MISFIT_FREEDOM: f64 = 4.0;

/// Returns the overdispersion phi that all effects share, from what each reference showed: T_e over its parameters.
#[must_use]
pub(super) fn pooled(shown: &[Vec<f64>]) -> f64 {
    let n = shown.len() as f64;
    let effects = shown.first().map_or(0, Vec::len);
    let of_effect = |e: usize| (shown.iter().map(|falls| falls[e]).sum::<f64>() / n).max(1.0).ln();
    let mean = (0..effects).map(of_effect).sum::<f64>() / effects.max(1) as f64;
    ((PRIOR_REFERENCES * PRIOR_OVERDISPERSION.ln() + n * mean) / (PRIOR_REFERENCES + n)).exp()
}

/// Returns the bound that T of an effect with `parameters` exceeds in one more clean glass with probability `chance`, after
/// references that showed `falls`, where all effects share the overdispersion `pooled`.
#[must_use]
pub(super) fn bound(falls: &[f64], parameters: usize, pooled: f64, chance: f64) -> f64 {
    let p = parameters.max(1) as f64;
    let freedom = FREEDOM + falls.len() as f64 * p;
    let phi = ((FREEDOM * pooled + falls.iter().sum::<f64>()) / freedom).max(1.0);
    p * phi * f_exceeded(chance, parameters.max(1), freedom)
}

/// Returns the misfit that one more clean glass exceeds with probability `chance` after references that showed `misfits`.
#[must_use]
pub(super) fn misfit_bound(misfits: &[f64], prior: MisfitPrior, chance: f64) -> f64 {
    let logs: Vec<f64> = misfits.iter().map(|misfit| misfit.max(1e-6).ln()).collect();
    let (n, k) = (logs.len() as f64, PRIOR_WEIGHT);
    let mean = if logs.is_empty() { prior.mean } else { logs.iter().sum::<f64>() / n };
    let scatter: f64 = logs.iter().map(|x| (x - mean).powi(2)).sum();
    let freedom = MISFIT_FREEDOM + n;
    let apart = k * n / (k + n) * (mean - prior.mean).powi(2);
    let variance = (MISFIT_FREEDOM * prior.deviation.powi(2) + scatter + apart) / freedom;
    let centre = (k * prior.mean + n * mean) / (k + n);
    (centre + student_t_exceeded(chance, freedom) * (variance * (1.0 + 1.0 / (k + n))).sqrt()).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_numerics::random::normal;
    use rand::SeedableRng;

    #[test]
    fn the_bound_falls_with_every_reference_from_none_on() {
        for fall in [0.0, 2.0, 5.0] {
            let at = |n: usize| bound(&vec![fall; n], 1, pooled(&vec![vec![fall.max(2.0); 3]; n]), 0.0005);
            let all: Vec<f64> = [0, 1, 2, 3, 7, 12, 40].map(at).into();
            assert!(all[0].is_finite() && all[0] > 20.0, "{all:?}");
            if fall <= 2.0 {
                assert!(all.windows(2).all(|w| w[1] <= w[0] + 1e-9), "{all:?}");
            }
            // 275 times the mean fall of three references is no bound that an effect can clear.
            assert!(all[3] < 45.0 * fall.max(2.0), "{all:?}");
        }
        let misfit = |n: usize| misfit_bound(&vec![1.0; n], MisfitPrior { mean: 0.0, deviation: 0.1 }, 0.01);
        let all: Vec<f64> = [0, 1, 2, 3, 7, 12].map(misfit).into();
        assert!(all.windows(2).all(|w| w[1] < w[0]) && all[0] < 2.0, "{all:?}");
    }

    #[test]
    fn what_all_effects_show_bounds_one_that_few_references_happen_not_to_show() {
        let shown = vec![vec![30.0, 20.0, 25.0, 0.0]; 3];
        let lucky = bound(&[0.0; 3], 1, pooled(&shown), 0.0005);
        let alone = bound(&[0.0; 3], 1, 1.0, 0.0005);
        assert!(lucky > 2.0 * alone, "{lucky} {alone}");
        // Many references speak for themselves.
        let many = bound(&[0.5; 400], 1, 10.0, 0.0005);
        assert!((many / f_exceeded(0.0005, 1, 404.0) - 1.0).abs() < 1e-9, "{many}");
    }

    #[test]
    fn one_more_exceeds_its_bound_hardly_more_often_than_it_says() {
        // Effects differ in their overdispersion; five references and one more glass each.
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        const TRIALS: usize = 400;
        const EFFECTS: usize = 20;
        let chance = 0.05;
        let mut over = 0;
        for _ in 0..TRIALS {
            let phi: Vec<f64> = (0..EFFECTS).map(|_| 4.0 * (0.5 * normal(&mut random)).exp()).collect();
            let mut glass =
                || -> Vec<f64> { phi.iter().map(|phi| phi * normal(&mut random).powi(2)).collect() };
            let shown: Vec<Vec<f64>> = (0..5).map(|_| glass()).collect();
            let next = glass();
            let pooled = pooled(&shown);
            over += (0..EFFECTS)
                .filter(|e| {
                    let falls: Vec<f64> = shown.iter().map(|one| one[*e]).collect();
                    next[*e] > bound(&falls, 1, pooled, chance)
                })
                .count();
        }
        let share = over as f64 / (TRIALS * EFFECTS) as f64;
        assert!((0.02..0.08).contains(&share), "{share}");
    }
}
