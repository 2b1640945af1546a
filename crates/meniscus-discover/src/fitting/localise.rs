//! Map of the discrepancy of the model without an effect: by channel, window of time, and phase.
//!
//! Whitened residuals of a right model have the mean square one, so in a cell of n numbers
//! `(sum r^2 - n)/sqrt(2 n)` is about normal; p values are those of the largest of all cells (Sidak). In
//! phase with the expected wave a misfit is one of stiffness or scale, in quadrature one of damping or
//! time.

use super::fit::Fitted;
use super::problem::Problem;
use crate::baseline::predict::{SHARED, predict};

/// Cell of the map.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Channel.
    pub channel: &'static str,
    /// Window: rest, forced, large decay, small decay.
    pub window: &'static str,
    /// Numbers in the cell.
    pub count: usize,
    /// Mean square of the whitened residual.
    pub chi2: f64,
    /// Probability that any cell reaches this misfit by chance.
    pub p: f64,
    /// Root mean square of the residual, m.
    pub rms_m: f64,
    /// Share in phase with the expected wave, and in quadrature.
    pub phase: [f64; 2],
}

const WINDOWS: [&str; 4] = ["rest", "forced", "large decay", "small decay"];

/// Returns the map of `plain` on `problem`.
#[must_use]
pub fn localise(problem: &Problem, plain: &Fitted) -> Vec<Cell> {
    let records: Vec<_> = problem.records().collect();
    let mut channels: Vec<&'static str> =
        records.iter().flat_map(|r| r.channels.iter().map(|c| c.quantity.words())).collect();
    channels.sort_unstable();
    channels.dedup();
    let window = |which: usize, f: usize| -> usize {
        let record = records[which];
        if f < record.rest_frames {
            return 0;
        }
        let moved = |t: f64| record.drive.at(t).0.iter().any(|a| a.abs() > 0.02);
        let last = (0..record.frames()).rev().find(|n| moved(*n as f64 * record.interval_s)).unwrap_or(0);
        if f <= last {
            1
        } else if f < last + (record.frames() - last) / 2 {
            2
        } else {
            3
        }
    };
    // count, sum of whitened squares, sum of squares, and products with the wave and its slope.
    let mut sums = vec![[0.0; 8]; channels.len() * WINDOWS.len()];
    let places = problem.places();
    let mut first = 0;
    for (which, count) in problem.counts().iter().enumerate() {
        let expected =
            predict(records[which], &problem.known, &plain.theta, plain.theta[SHARED + which], &[]);
        let left = problem.residual_m(which, &plain.theta, &[]);
        for (i, e) in left.iter().enumerate() {
            let (_, c, f) = places[first + i];
            let name = records[which].channels[c].quantity.words();
            let cell =
                channels.iter().position(|n| *n == name).unwrap_or(0) * WINDOWS.len() + window(which, f);
            let series = &expected[c];
            let (wave, slope) =
                (series[f], 5.0 * (series[(f + 1).min(series.len() - 1)] - series[f.saturating_sub(1)]));
            let white = plain.residual[first + i];
            let add = [1.0, white * white, e * e, e * wave, wave * wave, e * slope, slope * slope, 0.0];
            sums[cell].iter_mut().zip(add).for_each(|(s, a)| *s += a);
        }
        first += count;
    }
    let cells = sums.iter().filter(|s| s[0] > 0.0).count() as f64;
    let mut out = Vec::new();
    for (i, [n, white, square, ew, ww, es, ss, _]) in sums.into_iter().enumerate() {
        if n == 0.0 {
            continue;
        }
        let z = (white - n) / (2.0 * n).sqrt();
        let single = 0.5 * libm::erfc(z / std::f64::consts::SQRT_2);
        let share = |product: f64, own: f64| product / (own * square).sqrt().max(1e-30);
        out.push(Cell {
            channel: channels[i / WINDOWS.len()],
            window: WINDOWS[i % WINDOWS.len()],
            count: n as usize,
            chi2: white / n,
            p: 1.0 - (1.0 - single).powf(cells),
            rms_m: (square / n).sqrt(),
            phase: [share(ew, ww), share(es, ss)],
        });
    }
    out
}

/// Fewest numbers of a cell that a limit is compared with.
const FEWEST: usize = 20;

/// Returns the cell of `map` with the largest misfit.
#[must_use]
pub fn largest(map: &[Cell]) -> Option<&Cell> {
    map.iter().filter(|cell| cell.count >= FEWEST).max_by(|a, b| a.chi2.total_cmp(&b.chi2))
}
