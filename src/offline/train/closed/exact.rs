//! The exact net of a closed system of any dimension, in double precision: what runs and what is judged.
//!
//! ```text
//! E(x, s) = H(x) + s,  S = s          H(x) = |K x|^2 / 2 + h . x + w . p(W2 t(W1 x + b1) + b2)
//! x1 = x + (L - D) dH(x, x1)          L = L0 + L(m) skew,  D = C(m) C(m)^T >= 0,  m = (x + x1) / 2
//! s1 = s + H(x) - H(x1)               t = tanh, p(a) = ln(1 + e^a); a step is the unit of time
//! ```
//! x is the whole published state, scaled, whatever energies or entropies it holds; s is appended to it. Nothing is
//! lost by that: a system z' = L dE + M dS at a temperature T0 of its surroundings has x' = (L - M / T0) dH with
//! H = E - T0 S, its exergy, as L dS = 0 and M dE = 0; s is then T0 S. That H falls is the second law and that H + s
//! stays is the first, for every weight:
//!
//! ```text
//! [ L  0 ]           [  D     -D g   ]
//! [ 0  0 ] dS = 0,   [ -g^T D  g^T D g ] dE = 0,     g = dH, dE = (g, 1), dS = (0, 1)
//! ```
//! dH is the mean of grad H along the step by Gauss's rule of two nodes, put right along the step by the rest that
//! makes dH . (x1 - x) = H(x1) - H(x) exact (Gonzalez, J. Nonlinear Sci. 6 (1996) 449). The implicit equation is
//! solved to rounding. An end that lies above H(x) by rounding is moved down along -D g, where nothing moves that has
//! no friction, and failing that the step is shortened.

use super::form::Form;
use crate::offline::prelude::*;
use crate::offline::train::weights::Matrix;
use nalgebra::{DMatrix, DVector};

/// K, h, W1, b1, W2, b2, w; then the constant parts of L and C; then the perceptron of their changes.
pub(super) const ENERGY: usize = 7;

/// Gauss's two nodes on [0, 1].
pub(super) const NODES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// Corrections y <- x + (L - D) dH(x, y) before Newton's method takes over, and turns of that.
const CORRECTIONS: usize = 60;
const NEWTON: usize = 20;

/// Largest relative change at which the implicit equation counts as solved.
const SOLVED: f64 = 1e-15;

/// Halvings of a step that would raise H, before it is dropped.
const HALVINGS: usize = 60;

/// A trained exact net.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    form: Form,
    w: Vec<DMatrix<f64>>,
    spread_skew: DMatrix<f64>,
    spread_factor: DMatrix<f64>,
}

/// What one step did.
pub(super) struct Turn {
    /// x1.
    pub(super) x: DVector<f64>,
    /// s1 - s; never negative.
    pub(super) heat: f64,
    /// dH of the step.
    pub(super) gradient: DVector<f64>,
    /// L and D of the step.
    pub(super) skew: DMatrix<f64>,
    pub(super) friction: DMatrix<f64>,
}

fn softplus(a: f64) -> f64 {
    a.max(0.0) + (-a.abs()).exp().ln_1p()
}

fn logistic(a: f64) -> f64 {
    1.0 / (1.0 + (-a).exp())
}

impl Exact {
    pub(super) fn new(form: &Form, weights: &[Matrix]) -> Self {
        Self {
            w: weights.iter().map(Matrix::to_f64).collect(),
            spread_skew: form.spread_skew().to_f64(),
            spread_factor: form.spread_factor().to_f64(),
            form: form.clone(),
        }
    }

    /// W x + b of layer weights `at` and `at + 1`.
    fn layer(&self, at: usize, x: &DVector<f64>) -> DVector<f64> {
        &self.w[at] * x + self.w[at + 1].row(0).transpose()
    }

    /// H(x).
    pub(super) fn energy(&self, x: &DVector<f64>) -> f64 {
        let inner = self.layer(2, x).map(f64::tanh);
        let bowed = self.layer(4, &inner).map(softplus);
        0.5 * (&self.w[0] * x).norm_squared()
            + self.w[1].row(0).transpose().dot(x)
            + self.w[6].row(0).transpose().dot(&bowed)
    }

    /// grad H = K^T K x + h + W1^T [ t' W2^T ( w p' ) ].
    fn gradient(&self, x: &DVector<f64>) -> DVector<f64> {
        let inner = self.layer(2, x).map(f64::tanh);
        let slope = self.layer(4, &inner).map(logistic).component_mul(&self.w[6].row(0).transpose());
        let back = self.w[4].tr_mul(&slope).zip_map(&inner, |s, t| s * (1.0 - t * t));
        self.w[0].tr_mul(&(&self.w[0] * x)) + self.w[1].row(0).transpose() + self.w[2].tr_mul(&back)
    }

    /// dH(x, y).
    pub(super) fn discrete_gradient(&self, x: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let way = y - x;
        let mean =
            NODES.iter().map(|&t| self.gradient(&(x + &way * t))).fold(x * 0.0, |sum, g| sum + g * 0.5);
        let square = way.norm_squared();
        if square <= f64::MIN_POSITIVE {
            return mean;
        }
        let rest = self.energy(y) - self.energy(x) - mean.dot(&way);
        mean + way * (rest / square)
    }

    /// L and D at `m`.
    fn operators(&self, m: &DVector<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.form.n;
        let (lower, _) = self.form.triangles();
        let first = self.layer(ENERGY + 2, m).map(f64::tanh);
        let second = self.layer(ENERGY + 4, &first).map(f64::tanh);
        let changes = &self.w[ENERGY + 6] * second;
        let square = |from: usize, constant: &DMatrix<f64>, spread: &DMatrix<f64>| {
            let triangle = constant.row(0) + changes.rows(from, constant.ncols()).transpose();
            DMatrix::from_row_iterator(n, n, (triangle * spread).iter().copied())
        };
        let skew = &self.form.skew + square(0, &self.w[ENERGY], &self.spread_skew);
        let factor = square(lower, &self.w[ENERGY + 1], &self.spread_factor);
        (skew, &factor * factor.transpose())
    }

    /// (L - D) dH(x, y).
    fn flow(&self, x: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let (skew, friction) = self.operators(&((x + y) * 0.5));
        (skew - friction) * self.discrete_gradient(x, y)
    }

    /// The end of the step from `x`: corrections while they converge, then Newton's method.
    fn solve(&self, x: &DVector<f64>) -> DVector<f64> {
        let (mut y, mut least) = (x.clone(), f64::INFINITY);
        for _ in 0..CORRECTIONS {
            let next = x + self.flow(x, &y);
            let change = (&next - &y).norm() / (1.0 + next.norm());
            y = next;
            if change <= SOLVED {
                return y;
            }
            // At the rounding of the net itself it moves no closer.
            if change >= least && change < 1e-13 {
                return y;
            }
            least = least.min(change);
        }
        let n = self.form.n;
        let miss = |y: &DVector<f64>| y - x - self.flow(x, y);
        if !y.iter().all(|v| v.is_finite()) {
            y = x.clone();
        }
        for _ in 0..NEWTON {
            let here = miss(&y);
            let mut slope = DMatrix::zeros(n, n);
            for j in 0..n {
                let mut moved = y.clone();
                moved[j] += 1e-7;
                slope.set_column(j, &((miss(&moved) - &here) / 1e-7));
            }
            let Some(step) = slope.lu().solve(&here) else { break };
            y -= &step;
            if step.norm() <= 1e-14 * (1.0 + y.norm()) {
                break;
            }
        }
        y
    }

    /// One step; H(x1) <= H(x) always.
    pub(super) fn turn(&self, x: &DVector<f64>) -> Turn {
        let start = self.energy(x);
        let mut end = self.solve(x);
        let mut energy = self.energy(&end);
        let (skew, friction) = self.operators(&((x + &end) * 0.5));
        let gradient = self.discrete_gradient(x, &end);
        let down = &friction * &gradient;
        let fall = gradient.dot(&down);
        let mut reach = 2.0;
        while energy > start
            && reach < 1e4
            && fall > f64::MIN_POSITIVE
            && energy - start < 1e-9 * (1.0 + start.abs())
        {
            end -= &down * (reach * (energy - start) / fall);
            reach *= 8.0;
            energy = self.energy(&end);
        }
        let mut way = &end - x;
        for _ in 0..HALVINGS {
            if energy <= start {
                break;
            }
            way *= 0.5;
            end = x + &way;
            energy = self.energy(&end);
        }
        if energy.is_nan() || energy > start {
            (end, energy) = (x.clone(), start);
        }
        Turn { x: end, heat: start - energy, gradient, skew, friction }
    }

    /// `count` states from `x` on, that one first.
    pub(super) fn roll_out(&self, x: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
        std::iter::successors(Some(x.clone()), |x| Some(self.turn(x).x)).take(count).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::train::closed::dataset::{Dataset, Frame};
    use crate::offline::train::closed::unrolled::{self, Net};
    use crate::offline::train::laws::full;
    use crate::offline::train::weights::{constants, numbers};
    use burn::tensor::Device;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A net of random weights, ten times as bent as training starts with, on four variables of which the last is a
    /// parameter.
    fn random(seed: u64, factor: f32) -> (Exact, unrolled::Exact, Vec<Matrix>, ChaCha8Rng) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let path = |k: usize| {
            (0..10)
                .map(|n| DVector::from_vec(vec![n as f64, (n * n) as f64, -(n as f64), k as f64]))
                .collect()
        };
        let data = Dataset {
            name: String::from("random"),
            dt_s: 0.1,
            paths: (0..4).map(path).collect(),
            training: vec![0, 1, 2],
            test: vec![3],
            skew: None,
            friction: None,
        };
        let form = Form::new(&data, &Frame::of(&data));
        let net = unrolled::Exact::new(&form);
        let mut weights = net.fresh(&mut rng);
        weights.iter_mut().flat_map(|w| &mut w.values).for_each(|v| *v *= factor);
        (Exact::new(&form, &weights), net, weights, rng)
    }

    fn state(rng: &mut ChaCha8Rng) -> DVector<f64> {
        DVector::from_fn(4, |_, _| 4.0 * rng.random::<f64>() - 2.0)
    }

    /// Energy kept, entropy not falling, degeneracy an identity, parameters still: tame weights and hostile ones.
    #[test]
    fn the_laws_hold_for_every_weight() {
        for (seed, factor) in [(1, 1.0), (2, 3.0), (3, 10.0), (4, 100.0)] {
            let (net, _, _, mut rng) = random(seed, factor);
            for _ in 0..50 {
                let x = state(&mut rng);
                let turn = net.turn(&x);
                let (before, after) = (net.energy(&x), net.energy(&turn.x));
                assert!(turn.heat >= 0.0, "seed {seed}: heat {}", turn.heat);
                assert!((after + turn.heat - before).abs() <= 1e-12 * (1.0 + before.abs()), "seed {seed}");
                assert_eq!(turn.x[3], x[3], "a parameter stays");
                let [l, m] = full(&turn.skew, &turn.friction, &turn.gradient);
                let de = turn.gradient.clone().insert_row(4, 1.0);
                let ds = DVector::from_fn(5, |i, _| if i == 4 { 1.0 } else { 0.0 });
                assert!((&m * &de).norm() <= 1e-12 * m.norm() * de.norm());
                assert_eq!((&l * &ds).norm(), 0.0);
                assert!((&l + l.transpose()).norm() <= 1e-12 * l.norm());
            }
        }
    }

    #[test]
    fn gradient_is_that_of_the_energy_and_its_mean_is_exact() {
        let (net, _, _, mut rng) = random(5, 3.0);
        let (x, y) = (state(&mut rng), state(&mut rng));
        let g = net.gradient(&x);
        for i in 0..4 {
            let step = DVector::from_fn(4, |k, _| if k == i { 1e-5 } else { 0.0 });
            let slope = (net.energy(&(&x + &step)) - net.energy(&(&x - &step))) / 2e-5;
            assert!((slope - g[i]).abs() < 1e-6 * (1.0 + g[i].abs()), "{i}: {slope} against {}", g[i]);
        }
        let rise = net.discrete_gradient(&x, &y).dot(&(&y - &x));
        assert!((rise - (net.energy(&y) - net.energy(&x))).abs() < 1e-12 * (1.0 + rise.abs()));
    }

    /// The tensors of training make the step that runs.
    #[test]
    fn unrolled_turn_agrees_with_the_exact_one() {
        let (net, tensors, weights, mut rng) = random(6, 1.0);
        let device = Device::flex().autodiff();
        let w = constants(&weights, &device);
        for _ in 0..10 {
            let x = state(&mut rng);
            let row = Matrix::new(1, 4, x.iter().map(|&v| v as f32).collect()).tensor(&device);
            let said = numbers(tensors.turn(&w, row.clone()).0);
            let due = net.turn(&x).x;
            for (said, due) in said.iter().zip(&due) {
                assert!((f64::from(*said) - due).abs() < 1e-4, "{said} against {due}");
            }
            let end = Matrix::new(1, 4, due.iter().map(|&v| v as f32).collect()).tensor(&device);
            assert!(numbers(tensors.miss(&w, row, end).0).iter().all(|miss| miss.abs() < 1e-4));
        }
    }
}
