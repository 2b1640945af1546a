//! The quadratic program: of all motions of one duration, the one with the lowest crest.
//!
//! ```text
//! min  c + e/M |q - r|^2     over the accelerations a_k at the M - 1 inner knots, and the crest c in units of the limit L
//! q_i = (a_(i+1) - a_i) / (d J)      jerks, in units of the largest; d = T/M, a_0 is given, a_M = 0
//! x(T) = x1,  v(T) = 0,    |q_i| <= 1,    |a_k| <= A,    v_k, v_k + a_k d/2 <= V
//! h_k + m_k <= c L        and after arrival  h_k + m_k <= residual;        in a renewed plan c >= 1
//! ```
//! Acceleration is linear between two knots and so within its ends. Speed is quadratic there, and within its Bezier points
//! v_k, v_k + a_k d/2, v_(k+1), so the limits hold at every time. Solved by Clarabel, an interior-point method (Goulart and
//! Chen 2024, arXiv 2405.12762).
//!
//! A row of the surface or of the speed has an entry for every knot before it, and most of them are far from their bound. The
//! program takes those first that a motion nearby comes close to, or those of every third frame. It is solved again with the rows
//! that its solution breaks, until it breaks none: then it is the solution with all rows.

mod limits;
mod rows;
mod stated;
#[cfg(test)]
mod tests;

use self::limits::{Limit, Limits};
use self::rows::{Rows, compressed};
use self::stated::Scales;
use crate::PlanError;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

pub(crate) use self::stated::{Correction, Program};

/// Rows that fix the end.
const END_ROWS: usize = 2;

/// Solution of a program.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) jerks_m_s3: Vec<f64>,
    /// Highest h + m by the linear response, m.
    pub(crate) crest_m: f64,
}

impl Program<'_> {
    /// Solves it; `None` where no motion of this duration keeps the limits of the robot.
    pub(crate) fn solve(&self) -> Result<Option<Answer>, PlanError> {
        let limits = Limits::of(self);
        let solution = self.solve_chosen(&limits, &mut limits.first(self))?;
        Ok(solution.map(|solution| self.answer(&solution)))
    }

    /// Solves it with the `chosen` ones of `limits`, and again with those that the solution breaks, which become chosen.
    fn solve_chosen(&self, limits: &Limits, chosen: &mut [bool]) -> Result<Option<Vec<f64>>, PlanError> {
        loop {
            let near = limits.all.iter().zip(&*chosen).filter_map(|(limit, chosen)| chosen.then_some(limit));
            let Some(solution) = self.solve_with(near)? else { return Ok(None) };
            if !limits.add_broken(&solution, chosen) {
                return Ok(Some(solution));
            }
        }
    }

    /// Solves it with these `limits` alone; returns the accelerations at the inner knots in units of A, then the crest.
    fn solve_with<'l>(&self, limits: impl Iterator<Item = &'l Limit>) -> Result<Option<Vec<f64>>, PlanError> {
        let crest = self.knots - 1;
        let mut rows = Rows::new(crest + 1);
        self.end(&mut rows);
        self.robot(&mut rows);
        for limit in limits {
            let entries = limit.by_knot.iter().copied().enumerate();
            rows.push(entries.chain(limit.under_crest.then_some((crest, -1.0))), -limit.known);
        }
        if let Some(enough) = self.preferred.enough() {
            rows.push([(crest, -1.0)].into_iter(), -enough);
        }
        let inequalities = rows.count() - END_ROWS;
        let (matrix, bound) = rows.matrix();
        let (quadratic, linear) = self.objective();
        let cones = [ZeroConeT(END_ROWS), NonnegativeConeT(inequalities)];
        let unsolved = |why: String| PlanError::Solver(why);
        let settings = DefaultSettingsBuilder::default()
            .verbose(false)
            .presolve_enable(false)
            .build()
            .map_err(|why| unsolved(why.to_string()))?;
        let mut solver = DefaultSolver::new(&quadratic, &linear, &matrix, &bound, &cones, settings)
            .map_err(|why| unsolved(why.to_string()))?;
        solver.solve();
        match solver.solution.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {
                Ok(Some(std::mem::take(&mut solver.solution.x)))
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
            other => Err(unsolved(format!("{other:?} after {} iterations", solver.solution.iterations))),
        }
    }

    /// Jerks and crest of a solution.
    fn answer(&self, solution: &[f64]) -> Answer {
        let (scales, crest) = (self.scales(), self.knots - 1);
        let at = |k: usize| match k {
            0 => scales.first,
            k if k <= crest => solution[k - 1],
            _ => 0.0,
        };
        let step = scales.acceleration_m_s2 / scales.knot_s;
        let jerks_m_s3 = (0..self.knots).map(|i| step * (at(i + 1) - at(i))).collect();
        Answer { jerks_m_s3, crest_m: solution[crest] * self.request.limit_m }
    }

    /// P and p of the objective (1/2) x P x + p x: the crest, and e/M |q - r|^2.
    fn objective(&self) -> (CscMatrix<f64>, Vec<f64>) {
        let (scales, crest) = (self.scales(), self.knots - 1);
        let weight = 2.0 * self.preferred.weight() / self.knots as f64;
        // q = G a + g: each acceleration is in the jerk before it and in the one behind it.
        let along = weight * scales.jerk * scales.jerk;
        // The upper triangle; the crest has no square.
        let column = |k: usize| match k {
            0 => vec![(0, 2.0 * along)],
            k => vec![(k - 1, -along), (k, 2.0 * along)],
        };
        let by_column: Vec<_> = (0..crest).map(column).chain([Vec::new()]).collect();
        let wanted = |part: usize| {
            let given = if part == 0 { -scales.jerk * scales.first } else { 0.0 };
            self.preferred.jerk(part, self.knots, self.request.limits.jerk_m_s3) - given
        };
        let mut linear: Vec<f64> =
            (0..crest).map(|k| -weight * scales.jerk * (wanted(k) - wanted(k + 1))).collect();
        linear.push(1.0);
        (compressed(crest + 1, by_column), linear)
    }

    /// The glass at rest at its goal at T. At its end the acceleration is none of the unknowns: it is zero.
    fn end(&self, rows: &mut Rows) {
        let Scales { knot_s, acceleration_m_s2, .. } = self.scales();
        let (duration_s, start) = (self.duration_s, self.departure.glass);
        // An acceleration of unity at a knot falls to zero over both neighbours; at the first there is one.
        let half = 0.5 * knot_s * start.acceleration_m_s2;
        let speed_m_s = start.speed_m_s + half;
        let position_m = start.position_m + duration_s * start.speed_m_s + half * (duration_s - knot_s / 3.0);
        // Each row in units of what the duration gives, so that the solver sees numbers of one size.
        let speed = acceleration_m_s2 * duration_s;
        let inner = || 1..self.knots;
        let left = |k: usize| duration_s - k as f64 * knot_s;
        rows.push(
            inner().map(|k| (k - 1, knot_s * left(k) / (duration_s * duration_s))),
            (self.request.to_m - position_m) / (speed * duration_s),
        );
        rows.push(inner().map(|k| (k - 1, knot_s / duration_s)), -speed_m_s / speed);
    }

    /// Limits of the robot at the knots: jerk and acceleration.
    fn robot(&self, rows: &mut Rows) {
        let Scales { jerk, first, .. } = self.scales();
        let inner = self.knots - 1;
        for i in 0..self.knots {
            for sign in [1.0, -1.0] {
                let before = (i > 0).then(|| (i - 1, -sign * jerk));
                let behind = (i < inner).then_some((i, sign * jerk));
                let given = if i == 0 { -sign * jerk * first } else { 0.0 };
                rows.push(before.into_iter().chain(behind), 1.0 - given);
            }
        }
        for k in 0..inner {
            for sign in [1.0, -1.0] {
                rows.push([(k, sign)].into_iter(), 1.0);
            }
        }
    }
}
