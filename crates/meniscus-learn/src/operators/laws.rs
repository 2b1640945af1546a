//! Measures of the two laws along the roll-outs of the exact step.

use crate::data::trajectory::Path;
use crate::operators::open_loop::{Open, open_loop};
use crate::operators::reference_step::{Dynamics, Square};
use meniscus::latent::generic::LATENTS;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_optim::laws::{Laws, full};
use nalgebra::{DMatrix, DVector};

/// The laws of the exact step, and its largest |(H + s)' - (H + s) - work| of a step, in units of H.
pub(crate) struct ExactLaws {
    /// Measures that every step has.
    pub(crate) laws: Laws,
    /// In units of H.
    pub(crate) drift: f64,
}

/// The laws of `dynamics` along the roll-outs of `paths`, with dE = (g, 1) and dS = (0, 1) for g = dH of the closed step.
#[must_use]
pub(crate) fn of_exact(dynamics: &Dynamics, paths: &[Path]) -> ExactLaws {
    const ALL: usize = LATENTS + 1;
    let of = |m: &Square| DMatrix::from_column_slice(LATENTS, LATENTS, m.as_slice());
    let (skew, d) = (of(&dynamics.skew), of(&(dynamics.friction * dynamics.friction.transpose())));
    let mut exact = ExactLaws { laws: Laws::default(), drift: 0.0 };
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
            exact.laws.step(de.as_slice(), ds.as_slice(), &moved);
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
    use crate::networks::noise::normal;
    use crate::operators::reference_step::tests::random;

    /// The exact step keeps both laws to rounding, and the same meter shows one that does not.
    #[test]
    fn the_meter_reads_zero_for_the_exact_step_alone() {
        let (dynamics, mut rng) = random(21);
        let x = meniscus::latent::generic::Latent::from_fn(|_, _| normal(&mut rng));
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
        wrong.step(&[1.0, 0.0], &[0.0, 1.0], &[1.0, -1.0]);
        wrong.reversible(1.0, 2.0);
        wrong.irreversible(3.0, 4.0);
        assert_eq!((wrong.falls(), wrong.steps()), (1, 1));
        let [drift, l_ds, m_de] = wrong.figures();
        assert!((drift - 0.5_f64.sqrt()).abs() < 1e-12 && (l_ds - 0.5).abs() < 1e-12);
        assert!((m_de - 0.75).abs() < 1e-12);
    }
}
