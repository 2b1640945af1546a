//! Emulator of the simulator between the sizes that were simulated, and the size that fits best.
//!
//! Along the size the simulated numbers are joined by parabolas through three neighbours, blended between them; the other
//! parameters (a viscosity, a second parameter) enter by their derivatives:
//! ```text
//! h(u, s) = sum_i c_i(u) h_i + sum_j D_j (s_j - s0_j)
//! cost(u) = min over s of |y - h(u, s)|^2 + sum_j ((s_j - m_j)/sd_j)^2
//! ```
//! The same packing and motion at every size (common random numbers) make h smooth in u, so that a few sizes are enough.

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Sizes of the profile that are looked at between the ends.
const GRID: usize = 240;

/// Prior of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
}

/// Simulated numbers at one size.
#[derive(Clone, Debug)]
pub struct Node {
    /// Size.
    pub size: f64,
    /// Numbers of all recordings, nuisances projected out, at the origin of the other parameters.
    pub numbers: DVector<f64>,
}

/// Emulator with the measured numbers.
#[derive(Clone, Debug)]
pub struct Emulator {
    /// Measured numbers.
    pub data: DVector<f64>,
    /// Numbers of each recording.
    pub recordings: Vec<Range<usize>>,
    /// Simulated sizes, ascending.
    pub nodes: Vec<Node>,
    /// Derivatives by the other parameters.
    pub slopes: Vec<DVector<f64>>,
    /// Values of the other parameters at the nodes.
    pub origin: Vec<f64>,
    /// Their priors.
    pub priors: Vec<Prior>,
}

/// Point of the profile.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Size.
    pub size: f64,
    /// Other parameters.
    pub others: Vec<f64>,
    /// Cost.
    pub cost: f64,
}

impl Emulator {
    /// Returns the emulated numbers at `size` and the origin of the others.
    #[must_use]
    pub fn at(&self, size: f64) -> DVector<f64> {
        let sizes: Vec<f64> = self.nodes.iter().map(|node| node.size).collect();
        let mut out = DVector::zeros(self.data.len());
        for (weight, node) in blend(&sizes, size).iter().zip(&self.nodes) {
            out.axpy(*weight, &node.numbers, 1.0);
        }
        out
    }

    /// Returns the best other parameters and the cost at `size`; the numbers of `leave_out` are not looked at.
    #[must_use]
    pub fn fit_at(&self, size: f64, leave_out: Option<usize>) -> Fit {
        let mut left = &self.data - self.at(size);
        let mut slopes = self.slopes.clone();
        if let Some(range) = leave_out.map(|which| self.recordings[which].clone()) {
            left.rows_range_mut(range.clone()).fill(0.0);
            slopes.iter_mut().for_each(|slope| slope.rows_range_mut(range.clone()).fill(0.0));
        }
        let count = slopes.len();
        let mut square = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for i in 0..count {
            let information = self.priors[i].deviation.powi(-2);
            for j in 0..count {
                square[(i, j)] = slopes[i].dot(&slopes[j]);
            }
            square[(i, i)] += information;
            right[i] = slopes[i].dot(&left) + information * (self.priors[i].mean - self.origin[i]);
        }
        // The prior makes the matrix positive definite.
        let moved = square.cholesky().map_or(DVector::zeros(count), |factor| factor.solve(&right));
        for (slope, change) in slopes.iter().zip(moved.iter()) {
            left.axpy(-change, slope, 1.0);
        }
        let others: Vec<f64> = self.origin.iter().zip(moved.iter()).map(|(o, m)| o + m).collect();
        let prior: f64 =
            others.iter().zip(&self.priors).map(|(s, p)| ((s - p.mean) / p.deviation).powi(2)).sum();
        Fit { size, others, cost: left.norm_squared() + prior }
    }

    /// Returns the best fit with a size in `range`.
    #[must_use]
    pub fn minimum(&self, range: (f64, f64), leave_out: Option<usize>) -> Fit {
        let (low, high) = range;
        let at = |n: f64| self.fit_at(low + (high - low) * n / GRID as f64, leave_out);
        let mut best = (0..=GRID)
            .map(|n| (n as f64, at(n as f64)))
            .min_by(|a, b| a.1.cost.total_cmp(&b.1.cost))
            .unwrap_or_else(|| (0.0, at(0.0)));
        let mut reach = 0.5;
        while reach > 1e-3 {
            for n in [best.0 - reach, best.0 + reach] {
                let tried = at(n.clamp(0.0, GRID as f64));
                if tried.cost < best.1.cost {
                    best = (n.clamp(0.0, GRID as f64), tried);
                }
            }
            reach *= 0.5;
        }
        best.1
    }

    /// Returns the residual of `fit` and its derivatives by size and other parameters.
    #[must_use]
    pub fn linearised(&self, fit: &Fit) -> (DVector<f64>, DMatrix<f64>) {
        let mut left = &self.data - self.at(fit.size);
        for (slope, (s, origin)) in self.slopes.iter().zip(fit.others.iter().zip(&self.origin)) {
            left.axpy(origin - s, slope, 1.0);
        }
        let span = self.nodes.last().map_or(1.0, |node| node.size) - self.nodes[0].size;
        let h = 1e-3 * span.abs().max(f64::MIN_POSITIVE);
        let along = (self.at(fit.size + h) - self.at(fit.size - h)) / (2.0 * h);
        let mut jacobian = DMatrix::zeros(left.len(), 1 + self.slopes.len());
        jacobian.set_column(0, &along);
        for (j, slope) in self.slopes.iter().enumerate() {
            jacobian.set_column(1 + j, slope);
        }
        (left, jacobian)
    }
}

/// Returns the weight of each of the ascending `nodes` at `x`: parabolas through three neighbours, blended linearly between
/// them; a line through two, a constant of one.
#[must_use]
pub fn blend(nodes: &[f64], x: f64) -> Vec<f64> {
    let count = nodes.len();
    let mut out = vec![0.0; count];
    if count < 3 {
        match count {
            0 => {}
            1 => out[0] = 1.0,
            _ => {
                let share = (x - nodes[0]) / (nodes[1] - nodes[0]);
                (out[0], out[1]) = (1.0 - share, share);
            }
        }
        return out;
    }
    let interval = nodes[1..count - 1].iter().take_while(|node| x > **node).count();
    let mut add = |first: usize, share: f64| {
        for i in first..first + 3 {
            let others = (first..first + 3).filter(|j| *j != i);
            out[i] += share * others.map(|j| (x - nodes[j]) / (nodes[i] - nodes[j])).product::<f64>();
        }
    };
    if interval == 0 {
        add(0, 1.0);
    } else if interval >= count - 2 {
        add(count - 3, 1.0);
    } else {
        let share = (x - nodes[interval]) / (nodes[interval + 1] - nodes[interval]);
        add(interval - 1, 1.0 - share);
        add(interval, share);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parabolas_are_met_exactly_and_a_root_to_a_hundredth() {
        let nodes = [0.0, 1.0, 1.5, 2.0, 4.0];
        let of = |f: &dyn Fn(f64) -> f64, x: f64| -> f64 {
            blend(&nodes, x).iter().zip(nodes).map(|(w, node)| w * f(node)).sum()
        };
        for n in -4..50 {
            let x = 0.1 * f64::from(n);
            assert!((of(&|x| 1.0 + x - 0.3 * x * x, x) - (1.0 + x - 0.3 * x * x)).abs() < 1e-9, "{x}");
        }
        for n in 10..20 {
            let x = 0.1 * f64::from(n);
            assert!((of(&f64::sqrt, x) - x.sqrt()).abs() < 0.01, "{x}");
        }
    }

    #[test]
    fn the_other_parameters_follow_their_prior_where_the_data_say_nothing() {
        let line = |size: f64| Node { size, numbers: DVector::from_vec(vec![size, 0.0]) };
        let emulator = Emulator {
            data: DVector::from_vec(vec![1.7, 0.0]),
            recordings: vec![0..1, 1..2],
            nodes: vec![line(1.0), line(2.0)],
            slopes: vec![DVector::zeros(2)],
            origin: vec![0.5],
            priors: vec![Prior { mean: 0.2, deviation: 0.1 }],
        };
        let fit = emulator.minimum((0.0, 3.0), None);
        assert!((fit.size - 1.7).abs() < 1e-3 && (fit.others[0] - 0.2).abs() < 1e-9, "{fit:?}");
    }
}
