//! Measures of the two laws over steps, in numbers that mean the same for every step of GENERIC form.
//!
//! ```text
//! drift = |dE . dz| / (|dE| |dz|)     dz: what a closed step does to the whole state; 0 where energy is kept
//! falls = steps with dS . dz < 0
//! |L dS| / |L dE|,  |M dE| / |M dS|   root mean squares over the steps
//! ```
//! None has a unit, so that an energy whose scale nobody fixed can be held beside one in joules.

use meniscus_report::checks::Check;
use nalgebra::{DMatrix, DVector};

/// Sums over steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct Laws {
    steps: u32,
    falls: u32,
    drift: f64,
    l_ds: f64,
    l_de: f64,
    m_de: f64,
    m_ds: f64,
}

/// The scalar product of two vectors.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Laws {
    /// Takes a closed step by `dz` where energy and entropy change by `de` and `ds` a unit.
    pub fn step(&mut self, de: &[f64], ds: &[f64], dz: &[f64]) {
        let size = (dot(de, de) * dot(dz, dz)).sqrt().max(f64::MIN_POSITIVE);
        self.drift += (dot(de, dz) / size).powi(2);
        self.falls += u32::from(dot(ds, dz) < 0.0);
        self.steps += 1;
    }

    /// Takes |L dS| and |L dE| of a step.
    pub fn reversible(&mut self, l_ds: f64, l_de: f64) {
        self.l_ds += l_ds * l_ds;
        self.l_de += l_de * l_de;
    }

    /// Takes |M dE| and |M dS| of a step.
    pub fn irreversible(&mut self, m_de: f64, m_ds: f64) {
        self.m_de += m_de * m_de;
        self.m_ds += m_ds * m_ds;
    }

    /// Steps taken.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Steps whose entropy fell.
    pub fn falls(&self) -> u32 {
        self.falls
    }

    /// Root mean square of the drift, |L dS| / |L dE| and |M dE| / |M dS|.
    pub fn figures(&self) -> [f64; 3] {
        let ratio = |a: f64, b: f64| (a / b.max(f64::MIN_POSITIVE)).sqrt();
        let steps = f64::from(self.steps.max(1));
        [ratio(self.drift, steps), ratio(self.l_ds, self.l_de), ratio(self.m_de, self.m_ds)]
    }

    /// [`Self::figures`] under the name of `whose` step.
    pub fn checks(&self, whose: &str) -> Vec<Check> {
        let names = ["energy_drift", "L_dS", "M_dE"];
        let row = |(name, figure)| Check::informational(format!("{whose}_{name}"), 100.0 * figure, "%");
        names.into_iter().zip(self.figures()).map(row).collect()
    }
}

/// L and M over the whole state (x, s), written out: [L 0; 0 0] and [D, -D g; -g^T D, g^T D g].
#[must_use]
pub fn full(skew: &DMatrix<f64>, friction: &DMatrix<f64>, g: &DVector<f64>) -> [DMatrix<f64>; 2] {
    let n = g.len();
    let dg = friction * g;
    let mut m = DMatrix::zeros(n + 1, n + 1);
    m.view_mut((0, 0), (n, n)).copy_from(friction);
    m.view_mut((0, n), (n, 1)).copy_from(&-&dg);
    m.view_mut((n, 0), (1, n)).copy_from(&-dg.transpose());
    m[(n, n)] = g.dot(&dg);
    let mut l = DMatrix::zeros(n + 1, n + 1);
    l.view_mut((0, 0), (n, n)).copy_from(skew);
    [l, m]
}
