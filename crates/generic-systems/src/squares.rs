//! Training of the exact net by least squares after Levenberg and Marquardt (SIAM J. Appl. Math. 11 (1963) 431).
//!
//! The weights are few and the data have hardly any noise, so that what stays of the error is what descent along
//! gradients leaves: on the published pendulum Adam stopped at four times the error of this. Every turn takes some
//! pieces of trajectories, and what each weight would change along them:
//!
//! ```text
//! one step:    m = (1 - F_y)^-1 (x1 - x0 - F(x0, x1)),    dm = -(1 - F_y)^-1 F_w            x0, x1 of the data
//! roll-out:    y1 = y0 + F(y0, y1),    dy1 = (1 - F_y)^-1 ((1 + F_x) dy0 + F_w),    m = x1 - y1
//! ```
//! The first is what the solved step would miss, to first order: a stiff exchange takes back most of what its own
//! equation misses. Misses are counted in strides (one step) or spreads (roll-outs), and large ones by their modulus
//! and not their square, `2 d^2 (sqrt(1 + (m/d)^2) - 1)`: where a system passes a singular point, as a spring at no
//! length, a few steps are hundreds of times harder than the others.

use super::exact::Exact;
use super::form::Form;
use super::learn::{Lessons, Schedule};
use meniscus_numerics::least_squares::{Damping, NormalEquations};
use meniscus_optim::descent::Descent;
use meniscus_optim::progress::Session;
use meniscus_optim::weights::Matrix;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// d, of strides and of spreads.
const SMALL: [f64; 2] = [0.02, 0.2];

/// Numbers that a turn's misses make, about.
const NUMBERS: [usize; 2] = [6_000, 5_000];

/// Turns between two looks.
const LOOK: usize = 5;

/// Rule of the damping; `first` is that of the roll-outs, whose curvature the single steps have shown. `scaled_floor` lets
/// the damping hold a weight that the pieces do not depend on.
const DAMPING: Damping = Damping {
    first: 1e-2,
    shrink: 3.0,
    grow: 4.0,
    least: 1e-9,
    most: 1e9,
    scaled_floor: 1e-9,
    floor: 0.0,
    trials: 8,
};

/// Largest weight of the curvature of earlier turns (forgetting factor): so many turns count as one.
const MEMORY: f64 = 0.9;

/// Weight of the weights themselves, against the mean square miss.
const DECAY: f64 = 1e-10;

/// A piece of a trajectory.
type Piece<'a> = &'a [DVector<f64>];

/// Residuals of a piece, in its units, and their derivatives by every weight: `[weight, number]`.
struct Misses {
    misses: Vec<f64>,
    slopes: Option<DMatrix<f64>>,
}

/// One training.
struct Training<'a> {
    form: &'a Form,
    lessons: &'a Lessons,
    /// Variables that count.
    moving: Vec<usize>,
}

impl Training<'_> {
    /// Returns the residuals of `piece`; `None` where a step of it cannot be solved.
    fn misses(&self, net: &Exact, piece: Piece<'_>, weights: Option<usize>) -> Option<Misses> {
        if piece.len() == 2 {
            self.of_step(net, piece, weights)
        } else {
            self.of_rollout(net, piece, weights)
        }
    }

    fn of_step(&self, net: &Exact, piece: Piece<'_>, weights: Option<usize>) -> Option<Misses> {
        let (x, y, unit) = (&piece[0], &piece[1], &self.lessons.stride);
        let stiff = net.stiffness(x, y).lu();
        let miss = stiff.solve(&(y - x - net.move_by(x, y)))?;
        let slopes = match weights {
            Some(count) => {
                let moved = stiff.solve(&net.tangent(x, y, count).weights.transpose())?;
                let column = |&i: &usize| moved.row(i).transpose() * (-1.0 / unit[i]);
                Some(DMatrix::from_columns(&self.moving.iter().map(column).collect::<Vec<_>>()))
            }
            None => None,
        };
        Some(Misses { misses: self.moving.iter().map(|&i| miss[i] / unit[i]).collect(), slopes })
    }

    fn of_rollout(&self, net: &Exact, piece: Piece<'_>, weights: Option<usize>) -> Option<Misses> {
        let (n, unit) = (self.form.n, &self.lessons.spread);
        // Neighbouring steps miss the same: some forty of a long piece tell as much as all.
        let every = (piece.len() / 40).max(1);
        let mut x = piece[0].clone();
        let mut moved = weights.map(|count| DMatrix::zeros(n, count));
        let (mut misses, mut columns) = (Vec::new(), Vec::new());
        for (k, due) in piece.iter().enumerate().skip(1) {
            let y = net.solve(&x)?;
            if let (Some(moved), Some(count)) = (&mut moved, weights) {
                let slopes = net.tangent(&x, &y, count);
                let stiff = (DMatrix::identity(n, n) - slopes.to).lu();
                *moved = stiff.solve(&(&*moved + slopes.from * &*moved + slopes.weights.transpose()))?;
            }
            x = y;
            if k % every == 0 || k + 1 == piece.len() {
                misses.extend(self.moving.iter().map(|&i| (due[i] - x[i]) / unit[i]));
                if let Some(moved) = &moved {
                    columns.extend(self.moving.iter().map(|&i| moved.row(i).transpose() * (-1.0 / unit[i])));
                }
            }
        }
        Some(Misses { misses, slopes: moved.map(|_| DMatrix::from_columns(&columns)) })
    }

    /// Mean over the numbers of what `w` misses on `pieces`; infinite where it cannot be said.
    fn cost(&self, w: &DVector<f64>, pieces: &[Piece<'_>], small: f64) -> f64 {
        let net = Exact::new(self.form, w.as_slice());
        let (mut sum, mut count) = (0.0, 0_usize);
        for piece in pieces {
            let Some(Misses { misses, .. }) = self.misses(&net, piece, None) else { return f64::INFINITY };
            sum += misses
                .iter()
                .map(|m| 2.0 * small * small * ((1.0 + (m / small).powi(2)).sqrt() - 1.0))
                .sum::<f64>();
            count += misses.len();
        }
        let cost = sum / count.max(1) as f64 + DECAY * w.norm_squared();
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// Returns J^T W J and J^T W m of the mean cost, and the cost; pieces that cannot be solved are left out and returned.
    fn normal<'p>(&self, w: &DVector<f64>, pieces: Vec<Piece<'p>>, small: f64) -> Option<Normal<'p>> {
        let net = Exact::new(self.form, w.as_slice());
        let count = w.len();
        let (mut matrix, mut side, mut numbers) =
            (DMatrix::zeros(count, count), DVector::zeros(count), 0_usize);
        let (mut kept, mut held): (Vec<Piece<'p>>, Vec<DMatrix<f64>>) = (Vec::new(), Vec::new());
        for piece in pieces {
            let Some(Misses { misses, slopes: Some(mut slopes) }) = self.misses(&net, piece, Some(count))
            else {
                continue;
            };
            if !slopes.iter().chain(&misses).all(|v| v.is_finite()) {
                continue;
            }
            for (mut column, m) in slopes.column_iter_mut().zip(&misses) {
                let weight = 1.0 / (1.0 + (m / small).powi(2)).sqrt();
                side.axpy(weight * m, &column, 1.0);
                column *= weight.sqrt();
            }
            numbers += misses.len();
            kept.push(piece);
            held.push(slopes);
            if held.iter().map(DMatrix::ncols).sum::<usize>() > 600 {
                add_square(&mut matrix, &mut held);
            }
        }
        add_square(&mut matrix, &mut held);
        if kept.is_empty() {
            return None;
        }
        let scale = 1.0 / numbers as f64;
        matrix *= scale;
        side *= scale;
        side.axpy(DECAY, w, 1.0);
        for i in 0..count {
            matrix[(i, i)] += DECAY;
        }
        Some(Normal { matrix, side, pieces: kept })
    }
}

/// The normal equations of some pieces.
struct Normal<'p> {
    matrix: DMatrix<f64>,
    side: DVector<f64>,
    pieces: Vec<Piece<'p>>,
}

/// Adds S S^T of all columns that are held, which are let go.
fn add_square(matrix: &mut DMatrix<f64>, held: &mut Vec<DMatrix<f64>>) {
    if held.is_empty() {
        return;
    }
    let columns: Vec<_> = held.iter().flat_map(|m| m.column_iter()).collect();
    let all = DMatrix::from_columns(&columns);
    matrix.gemm(1.0, &all, &all.transpose(), 1.0);
    held.clear();
}

/// Pieces of `ahead` steps, enough for about `numbers` numbers.
fn draw<'p>(lessons: &'p Lessons, ahead: usize, numbers: usize, rng: &mut ChaCha8Rng) -> Vec<Piece<'p>> {
    let each = (if ahead == 1 { 1 } else { ahead / (ahead / 40).max(1) }) * lessons.stride.len();
    let piece = |_| {
        let path = &lessons.training[rng.random_range(0..lessons.training.len())];
        let first = rng.random_range(0..path.len() - ahead);
        &path[first..=first + ahead]
    };
    if lessons.training.iter().all(|path| path.len() == ahead + 1) {
        return lessons.training.iter().map(Vec::as_slice).collect();
    }
    (0..numbers.div_ceil(each).max(4)).map(piece).collect()
}

/// Trains from `seed`. Returns the best weights, one row of them, and their error on the trajectories that choose.
pub(super) fn learn(
    form: &Form,
    lessons: &Lessons,
    seed: u64,
    schedule: Schedule,
    session: &Session<'_>,
) -> (Vec<Matrix>, f64) {
    let moving = (0..form.n).filter(|&i| lessons.moves[i]).collect();
    let training = Training { form, lessons, moving };
    let fresh = Exact::fresh(form, &mut Descent::draws(seed, usize::MAX));
    let row = |w: &[f64]| Matrix::new(1, w.len(), w.iter().map(|&v| v as f32).collect());
    let longest = lessons.training.iter().map(Vec::len).min().unwrap_or(2) - 1;
    let mut best = (vec![row(&fresh), Matrix::new(1, 1, vec![1.0])], f64::INFINITY);
    for (at, (name, turns)) in
        [("exact steps", schedule.steps), ("exact roll-outs", schedule.rollouts)].iter().enumerate()
    {
        let stage = format!("{name} {:04x}", seed & 0xffff);
        if at == 1 {
            best.0[1].values[0] = DAMPING.first as f32;
        }
        let mut descent = Descent::new(&stage, best.0, best.1, session);
        let bar = session.bar(&stage, *turns);
        let mut search = Search {
            weights: DVector::zeros(fresh.len()),
            damping: DAMPING.first,
            memory: DMatrix::zeros(fresh.len(), fresh.len()),
        };
        for turn in descent.done()..*turns {
            let mut rng = Descent::draws(seed ^ at as u64, turn);
            let ahead = if at == 0 { 1 } else { schedule.horizon(turn).clamp(2, longest) };
            let pieces = draw(lessons, ahead, NUMBERS[at], &mut rng);
            // A checkpoint keeps both as f32: a training that goes on begins with the same numbers.
            search.weights = descent.weights()[0].to_f64().row(0).transpose();
            search.damping = f64::from(descent.weights()[1].values[0]);
            let error = step(&training, &mut search, pieces, SMALL[at]);
            search.memory *= (turn as f64 / (turn + 3) as f64).min(MEMORY);
            let weights = descent.parts().0;
            weights[0] = row(search.weights.as_slice());
            weights[1].values[0] = search.damping as f32;
            if turn % LOOK == LOOK - 1 || turn + 1 == *turns || session.stopped() {
                let net = Exact::new(form, search.weights.as_slice());
                let errors = (error.sqrt(), lessons.validate(|x, count| net.roll_out(x, count)));
                if descent.look(turn + 1, errors, &bar, session) {
                    break;
                }
            }
        }
        bar.finish();
        best = descent.end(&stage, session);
        if session.stopped() {
            break;
        }
    }
    best.0.truncate(1);
    best
}

/// State of the search between turns.
struct Search {
    weights: DVector<f64>,
    /// The damping that the next turn begins with.
    damping: f64,
    /// `J^T W J` of this turn and of earlier ones, as far as they are not forgotten.
    memory: DMatrix<f64>,
}

/// One turn: a step that lowers the cost on the same pieces. The pieces are too few to determine every weight, so that a
/// step is held back where earlier pieces were sure, as a Kalman filter with forgetting holds it: the matrix of the normal
/// equations is [`Search::memory`], their gradient that of the present pieces. Returns the cost.
fn step(training: &Training<'_>, search: &mut Search, pieces: Vec<Piece<'_>>, small: f64) -> f64 {
    let Some(Normal { matrix, side, pieces }) = training.normal(&search.weights, pieces, small) else {
        return f64::INFINITY;
    };
    let before = training.cost(&search.weights, &pieces, small);
    search.memory += matrix;
    let Search { weights, damping, memory } = search;
    let equations = NormalEquations { matrix: memory, gradient: &side, cost: before };
    let attempt = |step: &DVector<f64>| {
        let next = &*weights - step;
        let cost = training.cost(&next, &pieces, small);
        (next, cost)
    };
    match DAMPING.step(damping, equations, attempt) {
        Some((next, after)) => {
            *weights = next;
            after
        }
        None => before,
    }
}
