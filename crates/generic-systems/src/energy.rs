//! The energy of a closed system as a net of one bent layer, whose mean slope along a step has a closed form.
//!
//! ```text
//! E(x) = f . Q f / 2 + h . f + w . b(A f + c) + p . G p / 2          b(u) = sqrt(1 + u^2), f of [`super::form`]
//! dE(x, y) = Df((x + y) / 2)^T d,      d = Q (f + f') / 2 + h + A^T (w s),   s = (u + v) / (b(u) + b(v))
//! ```
//! with f, u at x and f', v at y. As s (v - u) = b(v) - b(u), and lengths squared change by twice their middle times
//! what they are made of changes by, dE . (y - x) = E(y) - E(x) without a remainder: the discrete gradient of Gonzalez
//! for a system that looks the same from every side (J. Nonlinear Sci. 6 (1996) 449, section 4), with the exact mean
//! in place of his correction. E need not be convex: a pendulum's is not.

use super::form::Form;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Bends of the energy.
const BENDS: usize = 48;

/// The energy.
#[derive(Clone, Debug)]
pub(super) struct Energy {
    stiff: DMatrix<f64>,
    tilt: DVector<f64>,
    seen: DMatrix<f64>,
    from: DVector<f64>,
    weight: DVector<f64>,
    mass: DMatrix<f64>,
}

/// A passage from x to y as the energy sees it.
pub(super) struct Passage {
    /// (f + f') / 2.
    pub(super) middle: DVector<f64>,
    ends: [DVector<f64>; 2],
    /// s and its slopes along u and v.
    bends: [DVector<f64>; 3],
    /// F q in the middle, and twice the secant of every length.
    spans: DMatrix<f64>,
    secants: DVector<f64>,
    momenta: DMatrix<f64>,
}

fn bow(u: f64) -> f64 {
    (1.0 + u * u).sqrt()
}

/// A symmetric matrix from its lower triangle, row by row.
fn symmetric(n: usize, triangle: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| triangle[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)])
}

fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

impl Energy {
    /// Names and shapes of the weights, in their order.
    pub(super) fn shapes(form: &Form) -> [(&'static str, usize, usize); 6] {
        let (f, p) = (form.seen(), form.kinds.momenta.len());
        [
            ("E.Q", 1, triangle(f)),
            ("E.h", 1, f),
            ("E.A", BENDS, f),
            ("E.c", 1, BENDS),
            ("E.w", 1, BENDS),
            ("E.G", 1, triangle(p)),
        ]
    }

    /// Weights to start from: springs and masses near one, bends small, entropies warm.
    pub(super) fn fresh(form: &Form, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let (f, p) = (form.seen(), form.kinds.momenta.len());
        let mut even = |bound: f64| bound * (2.0 * rng.random::<f64>() - 1.0);
        let eye =
            |n: usize, v: f64| (0..n).flat_map(move |i| (0..=i).map(move |j| if i == j { v } else { 0.0 }));
        let lengths = form.spans.nrows();
        let warm = |k: usize| k >= lengths && form.kinds.entropies.contains(&form.plain[k - lengths]);
        let mut all: Vec<f64> = eye(f, 0.1).collect();
        all.extend((0..f).map(|k| if warm(k) { 10.0 } else { 0.0 }));
        all.extend((0..BENDS * f).map(|_| even(1.2)));
        all.extend((0..BENDS).map(|_| even(2.5)));
        all.extend((0..BENDS).map(|_| even(0.03)));
        all.extend(eye(p, 1.0));
        all
    }

    /// From the weights at the head of `w`.
    pub(super) fn new(form: &Form, w: &[f64]) -> Self {
        let mut rest = w;
        let [stiff, tilt, seen, from, weight, mass] = Self::shapes(form).map(|(_, rows, columns)| {
            let (own, others) = rest.split_at(rows * columns);
            rest = others;
            own
        });
        Self {
            stiff: symmetric(form.seen(), stiff),
            tilt: DVector::from_column_slice(tilt),
            seen: DMatrix::from_row_slice(BENDS, form.seen(), seen),
            from: DVector::from_column_slice(from),
            weight: DVector::from_column_slice(weight),
            mass: symmetric(form.kinds.momenta.len(), mass),
        }
    }

    /// E(x).
    pub(super) fn value(&self, form: &Form, x: &DVector<f64>) -> f64 {
        let (f, p) = (form.features(x), form.momenta(x));
        let bent = (&self.seen * &f + &self.from).map(bow);
        0.5 * f.dot(&(&self.stiff * &f))
            + self.tilt.dot(&f)
            + self.weight.dot(&bent)
            + 0.5 * p.dot(&(&self.mass * &p))
    }

    /// The passage from `x` to `y`.
    pub(super) fn pass(&self, form: &Form, x: &DVector<f64>, y: &DVector<f64>) -> Passage {
        let ends = [form.features(x), form.features(y)];
        let [u, v] = [0, 1].map(|k: usize| &self.seen * &ends[k] + &self.from);
        let sum = u.zip_map(&v, |u, v| bow(u) + bow(v));
        let s = (&u + &v).component_div(&sum);
        let slope =
            |u: &DVector<f64>| DVector::from_fn(u.len(), |j, _| (1.0 - s[j] * u[j] / bow(u[j])) / sum[j]);
        let bends = [s.clone(), slope(&u), slope(&v)];
        let [a, b] = [form.span(x), form.span(y)];
        let squares = |k: usize| [a.row(k).norm_squared(), b.row(k).norm_squared()];
        Passage {
            middle: (&ends[0] + &ends[1]) * 0.5,
            secants: DVector::from_fn(a.nrows(), |k, _| 2.0 * form.secant(k, squares(k))),
            spans: (a + b) * 0.5,
            momenta: (form.momenta(x) + form.momenta(y)) * 0.5,
            ends,
            bends,
        }
    }

    /// dE of the passage.
    pub(super) fn slope(&self, form: &Form, way: &Passage) -> DVector<f64> {
        let d = &self.stiff * &way.middle
            + &self.tilt
            + self.seen.tr_mul(&self.weight.component_mul(&way.bends[0]));
        let mut slope = DVector::zeros(form.n);
        let lengths = form.spans.nrows();
        let pulls =
            DMatrix::from_fn(lengths, way.spans.ncols(), |k, c| d[k] * way.secants[k] * way.spans[(k, c)]);
        set(&mut slope, &form.kinds.points, &form.spans.tr_mul(&pulls));
        set(&mut slope, &form.kinds.momenta, &(&self.mass * &way.momenta));
        form.plain.iter().enumerate().for_each(|(k, &i)| slope[i] = d[lengths + k]);
        slope
    }

    /// Adds to `out` what g . dE rises by with every weight.
    pub(super) fn pull(&self, form: &Form, way: &Passage, g: &DVector<f64>, out: &mut [f64]) {
        let (f, lengths) = (form.seen(), form.spans.nrows());
        let spans = form.span(g);
        let over = |k: usize| {
            if k < lengths {
                way.secants[k] * way.spans.row(k).dot(&spans.row(k))
            } else {
                g[form.plain[k - lengths]]
            }
        };
        let d = DVector::from_fn(f, |k, _| over(k));
        let (stiff, out) = out.split_at_mut(triangle(f));
        pairs(stiff, f, |i, j| d[i] * way.middle[j]);
        let (tilt, out) = out.split_at_mut(f);
        tilt.iter_mut().zip(&d).for_each(|(o, d)| *o += d);
        let (seen, out) = out.split_at_mut(BENDS * f);
        let (from, out) = out.split_at_mut(BENDS);
        let (weight, mass) = out.split_at_mut(BENDS);
        let along = &self.seen * &d;
        let [s, at_u, at_v] = &way.bends;
        for j in 0..BENDS {
            let (w, a) = (self.weight[j], along[j]);
            weight[j] += a * s[j];
            from[j] += w * a * (at_u[j] + at_v[j]);
            for k in 0..f {
                let moved = at_u[j] * way.ends[0][k] + at_v[j] * way.ends[1][k];
                seen[j * f + k] += w * (s[j] * d[k] + a * moved);
            }
        }
        let (p, count) = (form.momenta(g), form.kinds.momenta.len());
        pairs(mass, count, |i, j| p.row(i).dot(&way.momenta.row(j)));
    }
}

/// Adds what a symmetric matrix's triangle takes of `m(i, j)`.
fn pairs(triangle: &mut [f64], n: usize, m: impl Fn(usize, usize) -> f64) {
    let all = (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)));
    for (o, (i, j)) in triangle.iter_mut().zip(all) {
        *o += if i == j { m(i, i) } else { m(i, j) + m(j, i) };
    }
}

/// Lays rows of `m` at the places of `vectors`.
fn set(slope: &mut DVector<f64>, vectors: &[Vec<usize>], m: &DMatrix<f64>) {
    for (i, places) in vectors.iter().enumerate() {
        places.iter().enumerate().for_each(|(c, &at)| slope[at] = m[(i, c)]);
    }
}
