//! Knowledge of a system before anything is learnt, and the features of a state that its energy depends on.
//!
//! In scaled coordinates x = T (z - mean) and a step for the unit of time, L becomes dt T L T^T.
//!
//! ```text
//! f = ( (ln sqrt(e + |F_k q|^2) - m_k) / d_k  of every length k,  every plain variable )
//! ```
//! A state of bodies has points q, their momenta p, and plain variables. Which way is up is nothing to a closed system,
//! so its energy sees points by their distances from the origin and from each other alone, each by its logarithm, which
//! is Hencky's strain (Z. techn. Phys. 9 (1928) 215): F_k is one point, or the difference of two. A state of plain
//! variables is seen as it is. What varies between trajectories but not along them stays a plain variable that nothing
//! moves.

use super::dataset::Dataset;
use super::kinds::Kinds;
use super::scaling::Scaling;
use meniscus_optim::weights::Matrix;
use nalgebra::{DMatrix, DVector};

/// e: lengths below its root, in the spread of the points, are seen as that.
const LEAST: f64 = 1e-7;

/// Source of the reversible operator L where the file has one; without one in the file it is learnt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReversibleOperator {
    /// The file's L as it is.
    #[default]
    FromFile,
    /// A learnt part added to the file's L.
    Learnt,
}

/// The known part.
#[derive(Clone, Debug)]
pub(super) struct Form {
    /// Variables.
    pub(super) n: usize,
    pub(super) kinds: Kinds,
    /// L where it is known, else zero.
    pub(super) skew: DMatrix<f64>,
    /// Whether the file says L; what is learnt is added to it.
    pub(super) knows_skew: bool,
    /// dt T M T^T where the file says M.
    pub(super) friction: Option<DMatrix<f64>>,
    /// Entries (i, j), i > j, of what is learnt of L.
    pub(super) skewed: Vec<(usize, usize)>,
    /// Variables that have friction.
    pub(super) rubbing: Vec<usize>,
    /// Variables that are seen as they are.
    pub(super) plain: Vec<usize>,
    /// F: lengths over points.
    pub(super) spans: DMatrix<f64>,
    /// m_k and d_k.
    pub(super) logs: [DVector<f64>; 2],
}

impl Form {
    /// Form of the system that `data` is from.
    pub(super) fn new(
        data: &Dataset,
        scaling: &Scaling,
        kinds: &Kinds,
        reversible: ReversibleOperator,
    ) -> Self {
        let n = data.variables();
        let scaled = |m: &DMatrix<f64>| {
            DMatrix::from_fn(n, n, |i, j| data.dt_s * m[(i, j)] / (scaling.scale[i] * scaling.scale[j]))
        };
        let bodies = |i: &usize| kinds.points.iter().chain(&kinds.momenta).flatten().any(|k| k == i);
        let rubs =
            |i: &usize| scaling.moving[*i] && data.friction.as_ref().is_none_or(|m| m.row(*i).amax() > 0.0);
        let turns = |i: usize| scaling.moving[i] && !kinds.entropies.contains(&i);
        let learns = reversible == ReversibleOperator::Learnt || data.skew.is_none();
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, j)));
        let (count, mut rows) = (kinds.points.len(), Vec::new());
        for i in 0..count {
            rows.push(DVector::from_fn(count, |k, _| f64::from(u8::from(k == i))));
            rows.extend((0..i).map(|j| {
                DVector::from_fn(count, |k, _| f64::from(u8::from(k == i)) - f64::from(u8::from(k == j)))
            }));
        }
        let mut form = Self {
            n,
            kinds: kinds.clone(),
            skew: data.skew.as_ref().map_or_else(|| DMatrix::zeros(n, n), scaled),
            knows_skew: data.skew.is_some(),
            friction: data.friction.as_ref().map(scaled),
            skewed: pairs.filter(|&(i, j)| learns && turns(i) && turns(j)).collect(),
            rubbing: (0..n).filter(rubs).collect(),
            plain: (0..n).filter(|i| !bodies(i)).collect(),
            spans: DMatrix::from_fn(rows.len(), count, |k, i| rows[k][i]),
            logs: [DVector::zeros(rows.len()), DVector::from_element(rows.len(), 1.0)],
        };
        if rows.is_empty() {
            return form;
        }
        let states = data.training.iter().flat_map(|&k| &data.paths[k]);
        let seen: Vec<_> = states.map(|z| form.features(&scaling.inward(z))).collect();
        for k in 0..rows.len() {
            let mean = seen.iter().map(|f| f[k]).sum::<f64>() / seen.len() as f64;
            let variance = seen.iter().map(|f| (f[k] - mean).powi(2)).sum::<f64>() / seen.len() as f64;
            form.logs[0][k] = mean;
            form.logs[1][k] = if variance > 0.0 { variance.sqrt() } else { 1.0 };
        }
        form
    }

    /// Numbers in f.
    pub(super) fn seen(&self) -> usize {
        self.spans.nrows() + self.plain.len()
    }

    /// F q, [length, coordinate].
    pub(super) fn span(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let width = self.kinds.points.first().map_or(0, Vec::len);
        &self.spans * DMatrix::from_fn(self.kinds.points.len(), width, |i, c| x[self.kinds.points[i][c]])
    }

    /// p, [point, coordinate].
    pub(super) fn momenta(&self, x: &DVector<f64>) -> DMatrix<f64> {
        let width = self.kinds.momenta.first().map_or(0, Vec::len);
        DMatrix::from_fn(self.kinds.momenta.len(), width, |i, c| x[self.kinds.momenta[i][c]])
    }

    /// f of x.
    pub(super) fn features(&self, x: &DVector<f64>) -> DVector<f64> {
        let spans = self.span(x);
        let lengths = spans
            .row_iter()
            .enumerate()
            .map(|(k, row)| (0.5 * (LEAST + row.norm_squared()).ln() - self.logs[0][k]) / self.logs[1][k]);
        DVector::from_iterator(self.seen(), lengths.chain(self.plain.iter().map(|&i| x[i])))
    }

    /// Change of a length's number in f from `from` to `to`, of the change of its square; exact for every two
    /// states:
    ///
    /// ```text
    /// (ln b - ln a) / (2 d (b - a)) = artanh(z) / (z (a + b) d),   z = (b - a) / (b + a)
    /// ```
    pub(super) fn secant(&self, k: usize, ends: [f64; 2]) -> f64 {
        let [from, to] = ends;
        let (a, b) = (from + LEAST, to + LEAST);
        let z = (b - a) / (b + a);
        let s = z * z;
        let rise = if s < 1e-3 {
            1.0 + s * (1.0 / 3.0 + s * (1.0 / 5.0 + s * (1.0 / 7.0 + s * (1.0 / 9.0 + s / 11.0))))
        } else {
            z.atanh() / z
        };
        rise / ((a + b) * self.logs[1][k])
    }

    /// Entries below the diagonal, and with it.
    pub(super) fn triangles(&self) -> (usize, usize) {
        (self.n * (self.n - 1) / 2, self.n * (self.n + 1) / 2)
    }

    /// Spreads a strict lower triangle over a skew matrix, row-major; entries that are not learnt are dropped.
    pub(super) fn spread_skew(&self) -> Matrix {
        let (n, mut at) = (self.n, 0);
        let mut spread = Matrix::zeros(self.triangles().0, n * n);
        for i in 0..n {
            for j in 0..i {
                if self.skewed.contains(&(i, j)) {
                    spread.values[at * n * n + i * n + j] = 1.0;
                    spread.values[at * n * n + j * n + i] = -1.0;
                }
                at += 1;
            }
        }
        spread
    }

    /// Spreads a lower triangle over C, row-major; rows of what has no friction are dropped.
    pub(super) fn spread_factor(&self) -> Matrix {
        let (n, mut at) = (self.n, 0);
        let mut spread = Matrix::zeros(self.triangles().1, n * n);
        for i in 0..n {
            for j in 0..=i {
                if self.rubbing.contains(&i) {
                    spread.values[at * n * n + i * n + j] = 1.0;
                }
                at += 1;
            }
        }
        spread
    }
}
