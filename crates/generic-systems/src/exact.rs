//! The exact net of a closed system of any dimension, in double precision: what is learnt, run and judged.
//!
//! Where it is not known which variable is entropy, one is appended (`design`: E(x, s) = H(x) + s, S = s):
//!
//! ```text
//! x1 = x + (L - C C^T) dH(x, x1)          s1 = s + H(x) - H(x1)
//! ```
//! Nothing is lost by that: a system z' = L dE + M dS in surroundings of temperature T0 has x' = (L - M / T0) dH with
//! H = E - T0 S, its exergy, as L dS = 0 and M dE = 0; s is then T0 S. That H falls is the second law and that H + s
//! stays is the first, for every weight.
//!
//! Where the entropies are variables of the state, S = c . x is their sum, and friction is made of brackets
//! (Oettinger, Beyond Equilibrium Thermodynamics, 2005, section 1.2; Zhang, Shin and Karniadakis, Phil. Trans. R. Soc. A
//! 380 (2022) 20210207, with nets):
//!
//! ```text
//! x1 = x + L dE(x, x1) + sum_k w_k (w_k . c),    w_k = A_k dE(x, x1),    L, A_k skew, L c = 0
//! ```
//! dE . w_k = 0 as A_k is skew, so that E(x1) = E(x); S(x1) - S(x) = sum_k (w_k . c)^2 >= 0. No law depends on a
//! loss, and nothing is divided by. Two springs that exchange heat have one bracket, between their entropies: with
//! temperatures t = dE / ds it is heat conduction, s1' = k t2 (t2 - t1), s2' = k t1 (t1 - t2).
//!
//! Why this form: the published pendulum was integrated by a discrete gradient of its own (its angular momentum stays
//! to 2e-6 over 200 steps, q moves by exactly the middle momentum, entropy never falls), so that this step can be equal
//! to the one that made the data, where an explicit one of the same 0.3 s must imitate it.
//!
//! L, A_k or C are the file's L and what [`super::operators`] says halfway, a step for the unit of time. The implicit
//! equation is solved to rounding; a step that has no solution near, as of a spring that passes through no length, is
//! made in shorter ones, of which each keeps the laws; one that cannot be made so either, which weights that nobody
//! trained may bring, is not taken, and counted.

use super::energy::{Energy, Passage};
use super::form::Form;
use super::operators::{Operators, Said};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;

/// Turns of Newton's method, and halvings of one that would make it worse.
const NEWTON: usize = 40;
const HALVINGS: usize = 12;

/// Shorter steps through which the solution is followed from none to the whole, where it is not found at once.
const STAGES: u32 = 16;

/// Part of a step below which it is not taken any more.
const SHORTEST: f64 = 1e-3;

/// Largest miss of the implicit equation, relative, at which a step counts as solved.
const SOLVED: f64 = 1e-10;

/// Largest rise of H, relative, that is rounding.
const ROUNDING: f64 = 1e-11;

/// Half of the distance over which slopes are taken.
const REACH: f64 = 1e-6;

/// An exact net.
#[derive(Clone, Debug)]
pub(super) struct Exact {
    pub(super) form: Form,
    energy: Energy,
    operators: Operators,
    friction: Vec<(usize, usize, usize)>,
    /// c; of a state whose entropy is appended, zero.
    entropy: DVector<f64>,
}

/// (L dE, friction) of one passage, and what it was made of.
struct Flow {
    way: Passage,
    said: Said,
    g: DVector<f64>,
    skew: DMatrix<f64>,
    /// C alone, or every A_k.
    factors: Vec<DMatrix<f64>>,
    value: DVector<f64>,
}

/// Result of one step.
pub(super) struct Turn {
    /// x1.
    pub(super) x: DVector<f64>,
    /// Rise of the entropy; never negative.
    pub(super) heat: f64,
    /// dE, dS and the whole step, with the appended entropy last where there is one.
    pub(super) slopes: [DVector<f64>; 3],
    /// L and M over the same.
    pub(super) operators: [DMatrix<f64>; 2],
    /// Whether the step, or what was left of it, was not taken.
    pub(super) held: bool,
}

/// Derivatives of the flow by x, by y and by every weight; the last `[weight, variable]`.
pub(super) struct Tangent {
    pub(super) from: DMatrix<f64>,
    pub(super) to: DMatrix<f64>,
    pub(super) weights: DMatrix<f64>,
}

/// Places (matrix, row, column) of what is learnt of friction.
fn places(form: &Form) -> Vec<(usize, usize, usize)> {
    let rubbing = &form.rubbing;
    let below = |matrix: usize, with: usize| {
        (0..rubbing.len()).flat_map(move |i| (0..i + with).map(move |j| (matrix, rubbing[i], rubbing[j])))
    };
    if form.kinds.entropies.is_empty() {
        return below(0, 1).collect();
    }
    (0..rubbing.len().saturating_sub(1)).flat_map(|k| below(k, 0)).collect()
}

impl Exact {
    /// Names and shapes of the weights, in their order.
    pub(super) fn shapes(form: &Form) -> Vec<(&'static str, usize, usize)> {
        let outputs = form.skewed.len() + places(form).len();
        Energy::shapes(form).into_iter().chain(Operators::shapes(form, outputs)).collect()
    }

    /// Weights to start from.
    pub(super) fn fresh(form: &Form, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let known = form.kinds.entropies.is_empty();
        let first = |&(_, i, j): &(usize, usize, usize)| match (known, i == j) {
            (true, true) => 0.3,
            (true, false) => 0.0,
            (false, _) => 1.0,
        };
        let mut said = vec![0.0; form.skewed.len()];
        said.extend(places(form).iter().map(first));
        let mut all = Energy::fresh(form, rng);
        all.extend(Operators::fresh(form, &said, rng));
        all
    }

    pub(super) fn new(form: &Form, w: &[f64]) -> Self {
        let friction = places(form);
        let head = Energy::shapes(form).iter().map(|(_, rows, columns)| rows * columns).sum();
        let (energy, operators) = w.split_at(head);
        Self {
            energy: Energy::new(form, energy),
            operators: Operators::new(form, form.skewed.len() + friction.len(), operators),
            entropy: DVector::from_fn(form.n, |i, _| f64::from(u8::from(form.kinds.entropies.contains(&i)))),
            friction,
            form: form.clone(),
        }
    }

    fn appended(&self) -> bool {
        self.form.kinds.entropies.is_empty()
    }

    /// H(x), or E(x).
    pub(super) fn energy(&self, x: &DVector<f64>) -> f64 {
        self.energy.value(&self.form, x)
    }

    /// The flow of the passage from `x` to `y`.
    fn flow(&self, x: &DVector<f64>, y: &DVector<f64>) -> Flow {
        let n = self.form.n;
        let way = self.energy.pass(&self.form, x, y);
        let g = self.energy.slope(&self.form, &way);
        let said = self.operators.say(&way.middle);
        let mut skew = self.form.skew.clone();
        for (&(i, j), l) in self.form.skewed.iter().zip(&said.numbers) {
            skew[(i, j)] += l;
            skew[(j, i)] -= l;
        }
        let count = self.friction.last().map_or(0, |last| last.0 + 1);
        let mut factors = vec![DMatrix::zeros(n, n); count];
        for (&(k, i, j), c) in self.friction.iter().zip(said.numbers.iter().skip(self.form.skewed.len())) {
            factors[k][(i, j)] = *c;
            if !self.appended() {
                factors[k][(j, i)] = -c;
            }
        }
        let mut value = &skew * &g;
        for factor in &factors {
            if self.appended() {
                value -= factor * factor.tr_mul(&g);
            } else {
                let w = factor * &g;
                let rate = w.dot(&self.entropy);
                value += w * rate;
            }
        }
        Flow { way, said, g, skew, factors, value }
    }

    /// Derivatives of `along` . flow by every weight.
    fn pull(&self, flow: &Flow, along: &DVector<f64>, out: &mut [f64]) {
        let g = &flow.g;
        let mut back = flow.skew.tr_mul(along);
        let mut numbers = DVector::zeros(flow.said.numbers.len());
        let skewed = self.form.skewed.len();
        for (o, &(i, j)) in numbers.iter_mut().zip(&self.form.skewed) {
            *o = along[i] * g[j] - along[j] * g[i];
        }
        let turned: Vec<_> = (flow.factors.iter())
            .map(|factor| {
                if self.appended() {
                    let pair = (factor.tr_mul(g), factor.tr_mul(along));
                    back -= factor * &pair.1;
                    return pair;
                }
                let w = factor * g;
                let v = along * w.dot(&self.entropy) + &self.entropy * along.dot(&w);
                back += factor.tr_mul(&v);
                (w, v)
            })
            .collect();
        for (o, &(k, i, j)) in numbers.iter_mut().skip(skewed).zip(&self.friction) {
            let (a, b) = &turned[k];
            *o = if self.appended() { -along[i] * a[j] - g[i] * b[j] } else { b[i] * g[j] - b[j] * g[i] };
        }
        let head = Energy::shapes(&self.form).iter().map(|(_, rows, columns)| rows * columns).sum();
        let (energy, operators) = out.split_at_mut(head);
        self.energy.pull(&self.form, &flow.way, &back, energy);
        self.operators.pull(&flow.way.middle, &flow.said, &numbers, operators);
    }

    /// Slopes of `f` at `at`, by middle differences.
    fn slopes(at: &DVector<f64>, f: impl Fn(&DVector<f64>) -> DVector<f64>) -> DMatrix<f64> {
        let mut slopes = DMatrix::zeros(at.len(), at.len());
        for j in 0..at.len() {
            let [up, down] = [REACH, -REACH].map(|by| {
                let mut moved = at.clone();
                moved[j] += by;
                f(&moved)
            });
            slopes.set_column(j, &((up - down) / (2.0 * REACH)));
        }
        slopes
    }

    /// I - the slope of the flow along `y`.
    pub(super) fn stiffness(&self, x: &DVector<f64>, y: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::identity(x.len(), x.len()) - Self::slopes(y, |y| self.flow(x, y).value)
    }

    /// The flow and its slopes.
    pub(super) fn tangent(&self, x: &DVector<f64>, y: &DVector<f64>, weights: usize) -> Tangent {
        let flow = self.flow(x, y);
        let mut pulled = DMatrix::zeros(weights, x.len());
        for (i, mut column) in pulled.column_iter_mut().enumerate() {
            let along = DVector::from_fn(x.len(), |k, _| f64::from(u8::from(k == i)));
            self.pull(&flow, &along, column.as_mut_slice());
        }
        Tangent {
            from: Self::slopes(x, |x| self.flow(x, y).value),
            to: Self::slopes(y, |y| self.flow(x, y).value),
            weights: pulled,
        }
    }

    /// The flow alone.
    pub(super) fn move_by(&self, x: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        self.flow(x, y).value
    }

    /// The end of the part `part` of a step from `x`, from `guess` on by Newton's method; `None` where it is not found.
    fn newton(&self, x: &DVector<f64>, guess: &DVector<f64>, part: f64) -> Option<DVector<f64>> {
        let miss = |y: &DVector<f64>| y - x - self.flow(x, y).value * part;
        let eye = DMatrix::identity(x.len(), x.len());
        let mut y = guess.clone();
        let mut here = miss(&y);
        for _ in 0..NEWTON {
            let size = here.norm();
            if size <= 1e-15 * (1.0 + y.norm()) {
                break;
            }
            let slope = (self.stiffness(x, &y) - &eye) * part + &eye;
            let Some(step) = slope.lu().solve(&here) else { break };
            let mut share = 1.0;
            let better = (0..HALVINGS).find_map(|_| {
                let next = &y - &step * share;
                let left = miss(&next);
                share *= 0.5;
                (left.norm() < size).then_some((next, left))
            });
            // Nothing is closer: this is the solution to rounding, or there is none to be found here.
            let Some((next, left)) = better else { break };
            (y, here) = (next, left);
        }
        (here.norm() <= SOLVED * (1.0 + y.norm())).then_some(y)
    }

    /// The end of the part `part` of a step from `x`: at once, or along the ends of shorter ones, which begin at x.
    fn solve_part(&self, x: &DVector<f64>, part: f64) -> Option<DVector<f64>> {
        let along = || {
            (1..=STAGES)
                .try_fold(x.clone(), |y, k| self.newton(x, &y, part * f64::from(k) / f64::from(STAGES)))
        };
        self.newton(x, x, part).or_else(along)
    }

    /// The end of the step from `x`; `None` where it is not found.
    pub(super) fn solve(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
        self.solve_part(x, 1.0)
    }

    /// One step, in as few parts as can be solved. Entropy rises or stays along each, always.
    pub(super) fn turn(&self, x: &DVector<f64>) -> Vec<Turn> {
        let mut turns: Vec<Turn> = Vec::new();
        // Parts still to go, the next one last.
        let mut parts = vec![1.0];
        while let Some(part) = parts.pop() {
            let from = turns.last().map_or(x, |turn| &turn.x);
            match self.solve_part(from, part) {
                Some(end) if self.falls(from, &end) => turns.push(self.close(from, end, false)),
                _ if part > SHORTEST => parts.extend([0.5 * part; 2]),
                _ => {
                    let still = from.clone();
                    turns.push(self.close(&still, still.clone(), true));
                    break;
                }
            }
        }
        turns
    }

    /// Whether H does not rise from `x` to `end` but by rounding; E of a state with entropies of its own does not move.
    fn falls(&self, x: &DVector<f64>, end: &DVector<f64>) -> bool {
        let start = self.energy(x);
        (self.energy(end) - start) * f64::from(u8::from(self.appended())) <= ROUNDING * (1.0 + start.abs())
    }

    /// The books of the step from `x` to `end`.
    fn close(&self, x: &DVector<f64>, mut end: DVector<f64>, held: bool) -> Turn {
        let flow = self.flow(x, &end);
        let one = |last: f64, v: &DVector<f64>| v.clone().insert_row(v.len(), last);
        if self.appended() {
            // What H rises by in the last digit is not booked as a loss of entropy.
            let heat = (self.energy(x) - self.energy(&end)).max(0.0);
            let d = flow.factors.iter().fold(&flow.skew * 0.0, |sum, c| sum + c * c.transpose());
            let slopes = [one(1.0, &flow.g), one(1.0, &(&flow.g * 0.0)), one(heat, &(&end - x))];
            let operators = meniscus_optim::laws::full(&flow.skew, &d, &flow.g);
            return Turn { x: end, heat, slopes, operators, held };
        }
        let total = |x: &DVector<f64>| self.form.kinds.entropies.iter().map(|&i| x[i]).sum::<f64>();
        let (before, warmest) = (total(x), self.form.kinds.entropies[0]);
        // The sum of entropies that exchange much and gain nothing may come out a last digit short.
        while total(&end) < before {
            end[warmest] += f64::EPSILON * (1.0 + end[warmest].abs() + before.abs());
        }
        let friction = flow.factors.iter().fold(&flow.skew * 0.0, |sum, a| {
            let w = a * &flow.g;
            sum + &w * w.transpose()
        });
        Turn {
            heat: total(&end) - before,
            slopes: [flow.g, self.entropy.clone(), &end - x],
            operators: [flow.skew, friction],
            x: end,
            held,
        }
    }

    /// `count` states from `x` on, that one first.
    pub(super) fn roll_out(&self, x: &DVector<f64>, count: usize) -> Vec<DVector<f64>> {
        std::iter::successors(Some(x.clone()), |x| self.turn(x).pop().map(|turn| turn.x))
            .take(count)
            .collect()
    }
}

#[cfg(test)]
mod tests;
