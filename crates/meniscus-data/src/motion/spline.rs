//! Cubic splines through samples, at rest at both ends: twice differentiable, so that their
//! acceleration is continuous and exact.

use super::Piece;

/// The clamped cubic spline (zero velocity at both ends) through `(time, position)` samples with
/// rising times, followed by rest at the last position. Needs two samples or more.
pub(super) fn through(samples: &[(f64, f64)]) -> Vec<Piece> {
    let n = samples.len();
    let width = |i: usize| samples[i + 1].0 - samples[i].0;
    let slope = |i: usize| (samples[i + 1].1 - samples[i].1) / width(i);
    // Second derivatives M: h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (s_i - s_{i-1}),
    // at the ends 2 h M_0 + h M_1 = 6 s_0 and h M_{n-2} + 2 h M_{n-1} = -6 s_{n-2}; Thomas' algorithm.
    let mut upper = vec![0.0; n];
    let mut m = vec![0.0; n];
    for i in 0..n {
        let below = if i > 0 { width(i - 1) } else { 0.0 };
        let above = if i + 1 < n { width(i) } else { 0.0 };
        let right = 6.0 * (if i + 1 < n { slope(i) } else { 0.0 } - if i > 0 { slope(i - 1) } else { 0.0 });
        let (carried, known) = if i > 0 { (upper[i - 1], m[i - 1]) } else { (0.0, 0.0) };
        let pivot = 2.0 * (below + above) - below * carried;
        upper[i] = above / pivot;
        m[i] = (right - below * known) / pivot;
    }
    for i in (0..n - 1).rev() {
        m[i] -= upper[i] * m[i + 1];
    }
    let mut pieces: Vec<Piece> = (0..n - 1)
        .map(|i| {
            let h = width(i);
            let velocity = slope(i) - h * (2.0 * m[i] + m[i + 1]) / 6.0;
            let coefficient = [samples[i].1, velocity, 0.5 * m[i], (m[i + 1] - m[i]) / (6.0 * h), 0.0, 0.0];
            Piece { start_s: samples[i].0, coefficient }
        })
        .collect();
    let (time, at) = samples[n - 1];
    pieces.push(Piece { start_s: time, coefficient: [at, 0.0, 0.0, 0.0, 0.0, 0.0] });
    pieces
}
