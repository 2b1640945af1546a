//! The laws of the exact net for tame and hostile weights; its slopes against differences.

use super::*;
use crate::ReversibleOperator;
use crate::dataset::Dataset;
use crate::kinds::Kinds;
use crate::scaling::Scaling;
use rand::{RngExt, SeedableRng};

/// Two bodies in a plane with two entropies, or five plain variables of which the last never moves.
fn random(seed: u64, factor: f64, bodies: bool) -> (Exact, Vec<f64>, ChaCha8Rng) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n = if bodies { 10 } else { 5 };
    let kinds = if bodies {
        Kinds {
            points: vec![vec![0, 1], vec![2, 3]],
            momenta: vec![vec![4, 5], vec![6, 7]],
            entropies: vec![8, 9],
        }
    } else {
        Kinds::default()
    };
    let mut path = |k: usize| -> Vec<DVector<f64>> {
        let still = |i: usize| !bodies && i == 4;
        let one = |i: usize, v: f64| if still(i) { k as f64 } else { v };
        (0..10).map(|_| DVector::from_fn(n, |i, _| one(i, 2.0 * rng.random::<f64>() - 1.0))).collect()
    };
    let canonical = DMatrix::from_fn(10, 10, |i, j| match (i, j) {
        (0..4, _) if j == i + 4 => 1.0,
        (4..8, _) if i == j + 4 => -1.0,
        _ => 0.0,
    });
    let warm = DMatrix::from_fn(10, 10, |i, j| if i == j && i > 7 { 1.0 } else { 0.0 });
    let data = Dataset {
        name: String::from("random"),
        dt_s: 0.1,
        paths: (0..4).map(&mut path).collect(),
        training: vec![0, 1, 2],
        test: vec![3],
        skew: bodies.then_some(canonical),
        friction: bodies.then_some(warm),
    };
    let scaling = Scaling::of(&data, &kinds);
    let form = Form::new(&data, &scaling, &kinds, ReversibleOperator::FromFile);
    let mut w = Exact::fresh(&form, &mut rng);
    w.iter_mut().for_each(|v| *v *= factor);
    (Exact::new(&form, &w), w, rng)
}

fn state(n: usize, rng: &mut ChaCha8Rng) -> DVector<f64> {
    DVector::from_fn(n, |_, _| 4.0 * rng.random::<f64>() - 2.0)
}

/// Energy kept, entropy not falling, degeneracy an identity, parameters still: tame weights and hostile ones.
#[test]
fn the_laws_hold_for_every_weight() {
    let (mut taken, mut all) = (0, 0);
    for (seed, factor) in [(1, 1.0), (2, 3.0), (3, -3.0), (4, 30.0)] {
        for bodies in [true, false] {
            let (net, _, mut rng) = random(seed, factor, bodies);
            for _ in 0..20 {
                let mut x = state(net.form.n, &mut rng);
                for turn in net.turn(&x) {
                    let gained = if bodies { 0.0 } else { turn.heat };
                    let (before, after) = (net.energy(&x), net.energy(&turn.x) + gained);
                    let around: f64 =
                        turn.slopes[0].iter().zip(&turn.slopes[2]).map(|(e, z)| (e * z).abs()).sum();
                    let scale = 1.0 + before.abs() + around;
                    assert!((after - before).abs() <= 1e-9 * scale, "{seed} {bodies}: {before} {after}");
                    assert!(turn.heat >= 0.0, "{seed} {bodies}: {}", turn.heat);
                    let ([de, ds, _], [l, m]) = (&turn.slopes, &turn.operators);
                    assert!((m * de).norm() <= 1e-11 * m.norm() * de.norm());
                    assert!((l * ds).norm() == 0.0 && (l + l.transpose()).norm() <= 1e-12 * l.norm());
                    assert!(m.clone().symmetric_eigenvalues().min() >= -1e-9 * (1.0 + m.norm()));
                    assert!(bodies || turn.x[4] == x[4], "a parameter stays");
                    all += 1;
                    taken += u32::from(!turn.held);
                    x = turn.x;
                }
            }
        }
    }
    println!("{taken} of {all} steps and parts taken");
    assert!(2 * taken > all, "{taken} of {all}");
}

/// dE . (y - x) = E(y) - E(x), and what bodies do has no direction: turned states have turned slopes.
#[test]
fn slopes_are_exact_along_every_passage() {
    for bodies in [true, false] {
        let (net, _, mut rng) = random(5, 2.0, bodies);
        let (x, y) = (state(net.form.n, &mut rng), state(net.form.n, &mut rng));
        let rise = net.flow(&x, &y).g.dot(&(&y - &x));
        let due = net.energy(&y) - net.energy(&x);
        assert!((rise - due).abs() < 1e-12 * (1.0 + due.abs()), "{rise} against {due}");
        let near = &x + (&y - &x) * 1e-5;
        let slope = (net.energy(&near) - net.energy(&x)) / 1e-5;
        assert!((net.flow(&x, &x).g.dot(&(&y - &x)) - slope).abs() < 1e-3 * (1.0 + slope.abs()));
    }
    let (net, _, mut rng) = random(6, 2.0, true);
    let (x, y) = (state(10, &mut rng), state(10, &mut rng));
    let turned = |x: &DVector<f64>| {
        let (s, c) = 0.7_f64.sin_cos();
        DVector::from_fn(10, |i, _| match (i, i % 2) {
            (8.., _) => x[i],
            (_, 0) => c * x[i] - s * x[i + 1],
            _ => s * x[i - 1] + c * x[i],
        })
    };
    let (once, twice) = (turned(&net.move_by(&x, &y)), net.move_by(&turned(&x), &turned(&y)));
    assert!((&once - &twice).norm() < 1e-12 * (1.0 + once.norm()));
}

/// The derivatives by every weight are those of the flow.
#[test]
fn pulls_are_slopes_of_the_flow() {
    for bodies in [true, false] {
        let (net, w, mut rng) = random(7, 1.0, bodies);
        let (x, y) = (state(net.form.n, &mut rng), state(net.form.n, &mut rng));
        let said = net.tangent(&x, &y, w.len()).weights;
        for k in 0..w.len() {
            let moved = |by: f64| {
                let mut w = w.clone();
                w[k] += by;
                Exact::new(&net.form, &w).move_by(&x, &y)
            };
            let due = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            let miss = (said.row(k).transpose() - &due).norm();
            assert!(miss < 1e-6 * (1.0 + due.norm()), "bodies {bodies}, weight {k}: misses {miss}");
        }
    }
}
