//! The quadratic program: of all motions of one duration, the one with the lowest crest.
//!
//! ```text
//! min  c + e/M |q - r|^2      q_i = j_i / J      over the jerks j_i between M + 1 knots, and the crest c in units of the limit L
//! x(T) = x1,  v(T) = 0,  a(T) = 0,    |q_i| <= 1,    |a_i| <= A,    v_i, v_i + a_i d/2 <= V
//! h_k + m_k <= c L        and after arrival  h_k + m_k <= residual;        in a renewed plan c >= 1
//! ```
//! Acceleration is linear between two knots and so within its ends. Speed is quadratic there, and within its Bezier points
//! v_i, v_i + a_i d/2, v_(i+1), so the limits hold at every time. Solved by Clarabel, an interior-point method (Goulart and
//! Chen 2024, arXiv 2405.12762).

use crate::PlanError;
use crate::course::basis;
use crate::models::FrameInput;
use crate::preferred::Preferred;
use crate::request::Request;
use crate::response::{Departure, ENDS, Response, inputs_of, unit_inputs};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};
use meniscus::units::FRAME_INTERVAL_S;

/// Rows that fix the end.
const END_ROWS: usize = 3;

/// Difference of the forecast from the linear response, and half-widths, frame by frame; the last one holds on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Correction {
    /// d of both ends, m.
    pub(crate) offset_m: Vec<[f64; ENDS]>,
    /// m: half-widths at the stated confidence, m.
    pub(crate) half_m: Vec<f64>,
}

impl Correction {
    /// d + m of an end in frame `k`, m.
    fn at(&self, k: usize, end: usize) -> f64 {
        let last = |n: usize| k.min(n.saturating_sub(1));
        let offset = self.offset_m.get(last(self.offset_m.len())).map_or(0.0, |ends| ends[end]);
        offset + self.half_m.get(last(self.half_m.len())).copied().unwrap_or(0.0)
    }
}

/// One program: everything but what it is solved for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program<'a> {
    pub(crate) request: &'a Request,
    pub(crate) departure: &'a Departure,
    pub(crate) response: &'a Response,
    pub(crate) correction: &'a Correction,
    pub(crate) input: FrameInput,
    /// T, s.
    pub(crate) duration_s: f64,
    /// M.
    pub(crate) knots: usize,
    /// Frames over which the surface is limited.
    pub(crate) frames: usize,
    /// Preferred jerks.
    pub(crate) preferred: Preferred<'a>,
}

/// Solution of a program.
#[derive(Clone, Debug)]
pub(crate) struct Answer {
    pub(crate) jerks_m_s3: Vec<f64>,
    /// Highest h + m by the linear response, m.
    pub(crate) crest_m: f64,
}

/// Columns of a matrix in the making, and its right-hand side.
struct Rows {
    columns: Vec<Vec<(usize, f64)>>,
    bound: Vec<f64>,
}

impl Rows {
    /// Adds the row `sum of entries <= bound`.
    fn push(&mut self, entries: impl Iterator<Item = (usize, f64)>, bound: f64) {
        for (column, value) in entries.filter(|(_, value)| *value != 0.0) {
            self.columns[column].push((self.bound.len(), value));
        }
        self.bound.push(bound);
    }

    fn matrix(self) -> (CscMatrix<f64>, Vec<f64>) {
        let (rows, columns) = (self.bound.len(), self.columns.len());
        let mut starts = vec![0];
        let (mut places, mut values) = (Vec::new(), Vec::new());
        for column in self.columns {
            for (row, value) in column {
                places.push(row);
                values.push(value);
            }
            starts.push(places.len());
        }
        (CscMatrix::new(rows, columns, starts, places, values), self.bound)
    }
}

impl Program<'_> {
    /// Time between two knots, s.
    fn knot_s(&self) -> f64 {
        self.duration_s / self.knots as f64
    }

    /// Solves it; `None` where no motion of this duration keeps the limits of the robot.
    pub(crate) fn solve(&self) -> Result<Option<Answer>, PlanError> {
        let crest = self.knots;
        let mut rows = Rows { columns: vec![Vec::new(); crest + 1], bound: Vec::new() };
        self.end(&mut rows);
        self.robot(&mut rows);
        self.surface(&mut rows);
        if let Some(enough) = self.preferred.enough() {
            rows.push([(crest, -1.0)].into_iter(), -enough);
        }
        let inequalities = rows.bound.len() - END_ROWS;
        let (matrix, bound) = rows.matrix();
        let weight = 2.0 * self.preferred.weight() / self.knots as f64;
        let quadratic = CscMatrix::new(
            crest + 1,
            crest + 1,
            (0..=crest).chain([crest]).collect(),
            (0..crest).collect(),
            vec![weight; crest],
        );
        let mut linear = vec![0.0; crest + 1];
        linear[crest] = 1.0;
        for (part, price) in linear.iter_mut().take(crest).enumerate() {
            *price = -weight * self.preferred.jerk(part, self.knots, self.request.limits.jerk_m_s3);
        }
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
                let x = &solver.solution.x;
                let jerk = self.request.limits.jerk_m_s3;
                let jerks_m_s3 = x[..crest].iter().map(|q| q * jerk).collect();
                Ok(Some(Answer { jerks_m_s3, crest_m: x[crest] * self.request.limit_m }))
            }
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ok(None),
            other => Err(unsolved(format!("{other:?} after {} iterations", solver.solution.iterations))),
        }
    }

    /// The glass at rest at its goal at T.
    fn end(&self, rows: &mut Rows) {
        let Request { limits, to_m, .. } = *self.request;
        let (knot_s, duration_s, jerk) = (self.knot_s(), self.duration_s, limits.jerk_m_s3);
        let free = self.departure.glass.drifted(duration_s);
        let part = |i: usize| basis(i, knot_s, duration_s);
        // Each row in units of what the duration gives, so that the solver sees numbers of one size.
        let scale = duration_s * duration_s;
        let columns = || 0..self.knots;
        rows.push(columns().map(|i| (i, part(i).position * jerk / scale)), (to_m - free.position_m) / scale);
        rows.push(columns().map(|i| (i, part(i).speed * jerk / duration_s)), -free.speed_m_s / duration_s);
        rows.push(columns().map(|i| (i, part(i).acceleration * jerk)), -free.acceleration_m_s2);
    }

    /// Limits of the robot: jerk, acceleration and speed.
    fn robot(&self, rows: &mut Rows) {
        let Request { limits, to_m, .. } = *self.request;
        let (knot_s, jerk, start) = (self.knot_s(), limits.jerk_m_s3, self.departure.glass);
        for i in 0..self.knots {
            rows.push([(i, 1.0)].into_iter(), 1.0);
            rows.push([(i, -1.0)].into_iter(), 1.0);
        }
        for k in 1..self.knots {
            for sign in [1.0, -1.0] {
                let entries = (0..k).map(|i| (i, sign * knot_s * jerk));
                rows.push(entries, limits.acceleration_m_s2 - sign * start.acceleration_m_s2);
            }
        }
        let forward = (to_m - start.position_m).signum();
        let fastest = start.speed_m_s.abs() + 0.5 * limits.acceleration_m_s2 * self.duration_s;
        if fastest <= limits.speed_m_s {
            return;
        }
        for k in 0..self.knots {
            let time_s = k as f64 * knot_s;
            let free = start.drifted(time_s);
            let part = |i: usize| basis(i, knot_s, time_s);
            if k > 0 {
                let entries = (0..k).map(|i| (i, forward * jerk * part(i).speed));
                rows.push(entries, limits.speed_m_s - forward * free.speed_m_s);
            }
            let ahead = 0.5 * knot_s;
            let entries =
                (0..k).map(|i| (i, forward * jerk * (part(i).speed + ahead * part(i).acceleration)));
            let reached = free.speed_m_s + ahead * free.acceleration_m_s2;
            rows.push(entries, limits.speed_m_s - forward * reached);
        }
    }

    /// The surface below the crest, and below the residual after arrival.
    fn surface(&self, rows: &mut Rows) {
        let Request { limits, limit_m, residual_m, .. } = *self.request;
        let (crest, start) = (self.knots, self.departure.glass);
        let free = inputs_of(self.input, self.departure.before_m, self.frames, |t| start.drifted(t));
        let free = self.response.heights(&free);
        let by_knot: Vec<Vec<[f64; ENDS]>> = (0..self.knots)
            .map(|i| self.response.heights(&unit_inputs(self.input, i, self.knot_s(), self.frames)))
            .collect();
        let unit = limits.jerk_m_s3 / limit_m;
        for k in 0..self.frames {
            let arrived = (k + 1) as f64 * FRAME_INTERVAL_S > self.duration_s;
            for end in 0..ENDS {
                let heights = || by_knot.iter().enumerate().map(|(i, heights)| (i, unit * heights[k][end]));
                let known = free[k][end] + self.correction.at(k, end);
                rows.push(heights().chain([(crest, -1.0)]), -known / limit_m);
                if let Some(residual_m) = residual_m.filter(|_| arrived) {
                    rows.push(heights(), (residual_m - known) / limit_m);
                }
            }
        }
    }
}
