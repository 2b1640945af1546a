//! Regression of the references' numbers on the logarithm of their viscosity.
//!
//! A reference of another viscosity than the liquid that is judged differs from it for a known reason. Only what a straight
//! line in ln mu leaves is scatter; counted as scatter, the difference would hide every effect of its size:
//! ```text
//! y_g = y(x0) + b (x_g - x0) + e_g,     x = ln mu,      b = Sxy/(Sxx + lambda)
//! degrees of freedom n - 1 - Sxx/(Sxx + lambda),        var y(x0) = s^2 (1/n + (x0 - <x>)^2/(Sxx + lambda))
//! ```
//! (ridge regression: Hoerl and Kennard 1970). The ridge makes a slope cost more than the references' viscosities show of it.

/// Ridge lambda: references that differ by a tenth show a slope by halves.
const RIDGE: f64 = 0.01;

/// Fewest references of which a slope is learnt: fewer leave no scatter to judge it by.
const FEWEST: usize = 4;

/// Straight line in ln mu through a number of each reference, evaluated at one viscosity.
#[derive(Clone, Debug)]
pub(super) struct ViscosityTrend {
    /// ln mu of each reference less their mean.
    apart: Vec<f64>,
    /// The same of the liquid that is judged.
    at: f64,
    /// Sxx + lambda; infinite without a slope.
    square: f64,
}

/// Value of a number at the judged viscosity, and what the line leaves of each reference.
#[derive(Clone, Debug)]
pub(super) struct Split {
    /// Value.
    pub(super) value: f64,
    /// Residual of each reference.
    pub(super) left: Vec<f64>,
}

impl ViscosityTrend {
    /// Returns the line through references of the viscosities `mu` at the viscosity `judged`, Pa s.
    pub(super) fn new(mu: &[f64], judged: f64) -> Self {
        let logs: Vec<f64> = mu.iter().map(|mu| mu.ln()).collect();
        let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
        let apart: Vec<f64> = logs.iter().map(|x| x - mean).collect();
        let square: f64 = apart.iter().map(|x| x * x).sum();
        let square = if mu.len() < FEWEST { f64::INFINITY } else { square + RIDGE };
        Self { apart, at: judged.ln() - mean, square }
    }

    /// Returns the value of `numbers`, one of each reference, at the judged viscosity.
    pub(super) fn split(&self, numbers: &[f64]) -> Split {
        let mean = numbers.iter().sum::<f64>() / numbers.len().max(1) as f64;
        let slope = self.apart.iter().zip(numbers).map(|(x, y)| x * (y - mean)).sum::<f64>() / self.square;
        let left = self.apart.iter().zip(numbers).map(|(x, y)| y - mean - slope * x).collect();
        Split { value: mean + slope * self.at, left }
    }

    /// Returns the degrees of freedom that the line leaves, at least a half.
    pub(super) fn freedom(&self) -> f64 {
        let spent = self.apart.iter().map(|x| x * x).sum::<f64>() / self.square;
        (self.apart.len() as f64 - 1.0 - spent).max(0.5)
    }

    /// Returns the variance of the value over that of one reference.
    pub(super) fn leverage(&self) -> f64 {
        1.0 / self.apart.len().max(1) as f64 + self.at * self.at / self.square
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_in_the_logarithm_leaves_nothing_and_few_references_have_no_slope() {
        let mu = [0.26, 0.26, 0.3, 0.3, 0.35, 0.35];
        let numbers: Vec<f64> = mu.iter().map(|mu: &f64| 2.0 + 3.0 * mu.ln()).collect();
        let trend = ViscosityTrend::new(&mu, 0.28);
        let Split { value, left } = trend.split(&numbers);
        // A tenth of the slope is the ridge's.
        assert!((value - (2.0 + 3.0 * 0.28_f64.ln())).abs() < 0.03, "{value}");
        let plain = ViscosityTrend::new(&mu[..3], 0.28);
        assert!(left.iter().all(|e| e.abs() < 0.06), "{left:?}");
        assert!(trend.freedom() > 3.9 && trend.freedom() < 4.3 && trend.leverage() < 0.25);
        let Split { value, .. } = plain.split(&numbers[..3]);
        assert!((value - numbers[..3].iter().sum::<f64>() / 3.0).abs() < 1e-12 && plain.freedom() == 2.0);
    }
}
