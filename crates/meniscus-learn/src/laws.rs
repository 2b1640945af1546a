//! What steps do to the two laws, in numbers that mean the same for every step of GENERIC form.
//!
//! ```text
//! drift = |dE . dz| / (|dE| |dz|)     dz: what a closed step does to the whole state; 0 where energy is kept
//! falls = steps with dS . dz < 0
//! |L dS| / |L dE|,  |M dE| / |M dS|   root mean squares over the steps
//! ```
//! None has a unit, so that an energy whose scale nobody fixed can be held beside one in joules.

use super::generic::{Dynamics, LATENTS, Square};
use super::linear::Path;
use super::rollout::{Open, open_loop};
use crate::host::checks::Check;
use crate::offline::prelude::*;
use crate::units::FRAME_INTERVAL_S;
use nalgebra::{DMatrix, DVector};

/// Sums over steps.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Laws {
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
    pub(super) fn step(&mut self, (de, ds): (&[f64], &[f64]), dz: &[f64]) {
        let size = (dot(de, de) * dot(dz, dz)).sqrt().max(f64::MIN_POSITIVE);
        self.drift += (dot(de, dz) / size).powi(2);
        self.falls += u32::from(dot(ds, dz) < 0.0);
        self.steps += 1;
    }

    /// Takes |L dS| and |L dE| of a step.
    pub(super) fn reversible(&mut self, l_ds: f64, l_de: f64) {
        self.l_ds += l_ds * l_ds;
        self.l_de += l_de * l_de;
    }

    /// Takes |M dE| and |M dS| of a step.
    pub(super) fn irreversible(&mut self, m_de: f64, m_ds: f64) {
        self.m_de += m_de * m_de;
        self.m_ds += m_ds * m_ds;
    }

    /// Steps taken.
    pub(super) fn steps(&self) -> u32 {
        self.steps
    }

    /// Steps whose entropy fell.
    pub(super) fn falls(&self) -> u32 {
        self.falls
    }

    /// Root mean square of the drift, |L dS| / |L dE| and |M dE| / |M dS|.
    pub(super) fn figures(&self) -> [f64; 3] {
        let ratio = |a: f64, b: f64| (a / b.max(f64::MIN_POSITIVE)).sqrt();
        let steps = f64::from(self.steps.max(1));
        [ratio(self.drift, steps), ratio(self.l_ds, self.l_de), ratio(self.m_de, self.m_ds)]
    }

    /// [`Self::figures`] under the name of `whose` step.
    pub(super) fn checks(&self, whose: &str) -> Vec<Check> {
        let names = ["energy_drift", "L_dS", "M_dE"];
        let told = |(name, figure)| Check::told(format!("{whose}_{name}"), 100.0 * figure, "%");
        names.into_iter().zip(self.figures()).map(told).collect()
    }
}

/// The laws of the exact step, and its largest |(H + s)' - (H + s) - work| of a step, in units of H.
pub(super) struct Exact {
    /// What is common to all steps.
    pub(super) laws: Laws,
    /// In units of H.
    pub(super) drift: f64,
}

/// L and M over the whole state (x, s), written out: [L 0; 0 0] and [D, -D g; -g^T D, g^T D g].
#[must_use]
pub(super) fn full(skew: &DMatrix<f64>, friction: &DMatrix<f64>, g: &DVector<f64>) -> [DMatrix<f64>; 2] {
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

/// The laws of `dynamics` along the roll-outs of `paths`, with dE = (g, 1) and dS = (0, 1) for g = dH of the closed step.
#[must_use]
pub(super) fn of_exact(dynamics: &Dynamics, paths: &[Path]) -> Exact {
    const ALL: usize = LATENTS + 1;
    let of = |m: &Square| DMatrix::from_column_slice(LATENTS, LATENTS, m.as_slice());
    let (skew, d) = (of(&dynamics.skew), of(&(dynamics.friction * dynamics.friction.transpose())));
    let mut exact = Exact { laws: Laws::default(), drift: 0.0 };
    for Open { from, ports, .. } in paths.iter().flat_map(open_loop) {
        let (mut x, mut s) = (from, 0.0);
        for &u in ports {
            let turn = dynamics.turn(&x, u);
            let kick = dynamics.port * (0.5 * FRAME_INTERVAL_S * u);
            let (before, after) = (x + kick, turn.x - kick);
            let g = dynamics.discrete_gradient(&before, &after);
            let [l, m] = full(&skew, &d, &DVector::from_column_slice(g.as_slice()));
            let de = DVector::from_iterator(ALL, g.iter().copied().chain([1.0]));
            let mut ds = DVector::zeros(ALL);
            ds[LATENTS] = 1.0;
            let moved = (after - before).iter().copied().chain([turn.heat]).collect::<Vec<_>>();
            exact.laws.step((de.as_slice(), ds.as_slice()), &moved);
            exact.laws.reversible((&l * &ds).norm(), (&l * &de).norm());
            exact.laws.irreversible((&m * &de).norm(), (&m * &ds).norm());
            let e = |x, s: f64| dynamics.energy(x) + s;
            let next = s + turn.heat;
            exact.drift = exact.drift.max((e(&turn.x, next) - e(&x, s) - turn.work).abs());
            (x, s) = (turn.x, next);
        }
    }
    exact
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offline::train::generic::tests::random;
    use crate::offline::train::noise::normal;

    /// The exact step keeps both laws to rounding, and the same meter shows one that does not.
    #[test]
    fn the_meter_reads_zero_for_the_exact_step_alone() {
        let (dynamics, mut rng) = random(21);
        let x = crate::offline::train::generic::Latent::from_fn(|_, _| normal(&mut rng));
        let u: Vec<f64> = (0..150).map(|_| normal(&mut rng)).collect();
        let n = u.len();
        let path = Path { x: dynamics.roll_out(x, &u), u, energy: vec![0.0; n], heat: vec![0.0; n] };
        let exact = of_exact(&dynamics, &[path]);
        assert_eq!(exact.laws.falls(), 0);
        assert!(exact.laws.steps() > 100);
        for figure in exact.laws.figures() {
            assert!(figure < 1e-9, "{figure}");
        }
        assert!(exact.drift < 1e-11, "{}", exact.drift);
        let mut wrong = Laws::default();
        wrong.step((&[1.0, 0.0], &[0.0, 1.0]), &[1.0, -1.0]);
        wrong.reversible(1.0, 2.0);
        wrong.irreversible(3.0, 4.0);
        assert_eq!((wrong.falls(), wrong.steps()), (1, 1));
        let [drift, l_ds, m_de] = wrong.figures();
        assert!((drift - 0.5_f64.sqrt()).abs() < 1e-12 && (l_ds - 0.5).abs() < 1e-12);
        assert!((m_de - 0.75).abs() < 1e-12);
    }
}
