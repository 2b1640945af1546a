//! The step of a quadratic energy H = |K x|^2 / 2, whose solution is known: with F = L - D and S = K^T K the closed step is the
//! Cayley transform (1 - dt F S / 2)^-1 (1 + dt F S / 2).

extern crate std;

use super::*;
use crate::latent::generic::{LATENTS, ModeMap};
use crate::latent::nn::{PANEL, packed_index};
use crate::reduced::effects::{Active, find};
use crate::reduced::{Baseline, Cylinder, ReducedModel, Rheology};
use std::boxed::Box;

type Square = SMatrix<f64, LATENTS, LATENTS>;

const DT: f64 = 1.0 / 60.0;

/// A matrix that lives as long as the tests.
fn matrix(of: &Square) -> Matrix<'static> {
    let mut packed = Box::new([0.0; LATENTS * PANEL]);
    for i in 0..LATENTS {
        for j in 0..LATENTS {
            packed[packed_index(i, j, LATENTS)] = of[(i, j)] as f32;
        }
    }
    Matrix::new(Box::leak(packed), LATENTS, LATENTS).expect("13 by 13")
}

fn unit(k: usize) -> Latent {
    Latent::from_fn(|i, _| f64::from(u8::from(i == k)))
}

/// Numbers of no structure, -0.5 to 0.5, which single precision holds.
fn number(k: usize) -> f32 {
    (k * 7919 % 1024) as f32 / 1024.0 - 0.5
}

/// A model of the energy |K x|^2 / 2 that turns by L and rubs by D, both scaled, without a preconditioner.
fn quadratic(k: &Square, turn: f32, rub: f32, port: Latent) -> Generic<'static> {
    let skew: [f32; 78] = core::array::from_fn(|i| turn * number(i));
    let factor: [f32; 91] = core::array::from_fn(|i| rub * number(i + 100));
    let linear = matrix(k);
    Generic {
        potential: Potential {
            linear,
            inward: matrix(&Square::zeros()),
            bias: &[0.0; LATENTS],
            weight: &[0.0; LATENTS],
            bend: None,
        },
        operators: Operators::from_triangles(&skew, &factor),
        port,
        preconditioner: matrix(&Square::zeros()),
        dt_s: DT,
        slots: None,
        law: None,
    }
}

/// K without structure; H is about 100 at a latent of one.
fn stiffness() -> Square {
    Square::from_fn(|i, j| f64::from(number(i * LATENTS + j + 400)) * 4.0 + if i == j { 4.0 } else { 0.0 })
}

#[track_caller]
fn close(value: f64, due: f64, slack: f64) {
    assert!((value - due).abs() <= slack * due.abs(), "{value} for {due}");
}

/// The whole step, its heat dt dH . D dH with dH = S (a + b) / 2, and its work, which is what the energy gained and the heat.
#[test]
fn a_step_of_a_quadratic_energy_is_the_cayley_transform_between_two_half_kicks() {
    let port = Latent::from_fn(|i, _| f64::from(number(i + 700)) * 20.0);
    let model = quadratic(&stiffness(), 8.0, 0.5, port);
    let s = stiffness().transpose() * stiffness();
    let half = model.operators.difference() * s * (0.5 * DT);
    let start = LatentState {
        latent: Latent::from_fn(|i, _| f64::from(number(i))),
        heat: 3.0,
        ..LatentState::default()
    };
    let u = 1.7;
    let kick = port * (0.5 * DT * u);
    let a = start.latent + kick;
    let b = (Square::identity() - half).try_inverse().expect("regular") * (Square::identity() + half) * a;
    let due = b + kick;
    let h = |x: &Latent| 0.5 * x.dot(&(s * x));
    let mean = s * (a + b) * 0.5;
    let heat = DT * mean.dot(&(model.operators.friction * mean));
    assert!(heat > 1e-3 * h(&a), "there is friction: {heat} of {}", h(&a));

    let mut state = start;
    let audit = model.step(&mut state, u);
    assert!((state.latent - due).norm() < 1e-10 * due.norm(), "{} for {due}", state.latent);
    close(audit.heat, heat, 1e-9);
    close(state.heat, 3.0 + heat, 1e-12);
    close(audit.work, h(&due) - h(&start.latent) + heat, 1e-9);
    assert!(audit.energy_residual.abs() < 1e-12 * h(&a), "{audit:?}");
    close(model.energy(&state), h(&due) + 3.0 + heat, 1e-12);
    // Twelve iterations by a preconditioner that does nothing, one by Newton, one to see that it is solved.
    assert_eq!((audit.outcome, audit.iterations), (StepOutcome::Solved, 14));

    // By the inverse of the equation's derivative itself one iteration solves it.
    let inverse = (Square::identity() - half).try_inverse().expect("regular");
    let quick = Generic { preconditioner: matrix(&inverse), ..model };
    let mut state = start;
    assert!(quick.step(&mut state, u).iterations <= 5, "single precision takes a few digits at a time");
    assert!((state.latent - due).norm() < 1e-10 * due.norm());
}

/// A rise by rounding is taken off along the gradient: what comes out lies as far below the limit as `b` lay above it, to first
/// order. A rise beyond rounding is none of its business.
#[test]
fn a_nudge_lands_as_far_below_as_it_began_above() {
    let model = quadratic(&stiffness(), 8.0, 0.0, Latent::zeros());
    let b = Latent::from_fn(|i, _| f64::from(number(i)));
    let energy = model.potential.value(&b);
    assert!(energy > 20.0, "{energy}");
    for rise in [1e-12 * energy, 0.5 * f64::NUDGE * energy] {
        let (end, after) = model.nudge(b, energy, energy - rise).expect("rounding");
        assert_eq!(after, model.potential.value(&end));
        assert!(
            (after - (energy - 2.0 * rise)).abs() < 0.05 * rise + 1e-14 * energy,
            "{rise}: {}",
            after - energy
        );
        // The shortest way down is along the gradient.
        let (way, gradient) = (end - b, model.potential.gradient(&b));
        let square = gradient.dot(&gradient);
        assert!(square > 2.0 && (way + gradient * (2.0 * rise / square)).norm() < 1e-3 * way.norm() + 1e-15);
    }
    assert_eq!(model.nudge(b, energy, energy), Some((b, energy)), "nothing to take off");
    assert!(model.nudge(b, energy, energy * (1.0 - 1e-3)).is_none());
    // At rest there is no way down.
    let rest = Latent::zeros();
    assert!(model.nudge(rest, 0.0, -1e-320).is_none());
}

/// H = 2 x^2: from x = 1 a step by -10 would lead to -9. Halved once it is at -4, twice at -1.5, both higher than it began; halved
/// three times it is at -0.25.
#[test]
fn a_step_that_would_rise_is_halved_until_it_does_not() {
    let model = quadratic(&(Square::identity() * 2.0), 8.0, 0.0, Latent::zeros());
    let held = [0.5, 0.0];
    let at = |x: f64| model.backtrack(&unit(0), &held, unit(0) * x, 2.0, 7);
    let closed = at(-9.0);
    assert_eq!((closed.end, closed.energy_start, closed.energy_end), (unit(0) * -0.25, 2.0, 0.125));
    assert_eq!((closed.held, closed.iterations, closed.outcome), (held, 7, StepOutcome::Backtracked));
    // A step upwards is dropped whatever is left of it, and so is one that is no number.
    for end in [f64::NAN, f64::INFINITY] {
        let dropped = at(end);
        assert_eq!((dropped.end, dropped.energy_end, dropped.held), (unit(0), 2.0, held));
    }
}

/// A state without a number anywhere is left as it is, though the latents of the step are finite.
#[test]
fn a_step_whose_books_are_no_numbers_is_held() {
    let model = quadratic(&Square::identity(), 8.0, 0.1, unit(0));
    for (u, heat, iterations) in [(1e200, 0.0, 1), (1.0, f64::INFINITY, 1), (f64::NAN, 0.0, MAX_ITERATIONS)] {
        let before = LatentState { heat, ..LatentState::default() };
        let mut state = before;
        let audit = model.step(&mut state, u);
        assert_eq!((audit.outcome, state), (StepOutcome::Held, before), "{u} {heat}");
        // What is no number is never solved.
        assert!((iterations..=MAX_ITERATIONS).contains(&audit.iterations), "{audit:?}");
    }
}

/// Deflection at which the contact line slides.
const REACH_M: f64 = 4e-3;

/// A first mode of 22 rad/s without friction, whose contact line is caught and slides.
fn with_contact_line(dt_s: f64) -> Generic<'static> {
    let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
    let reduced = |effects: &[Active]| {
        ReducedModel::new(glass, Rheology::newtonian(0.2), &Baseline::default(), effects, 1.0 / 60.0)
    };
    let line = find("contact_line").expect("in the library");
    let mut values = line.neutral();
    (values[0], values[1]) = (0.2, REACH_M);
    let (height, rate) = (unit(0) * 0.01, unit(1) * 0.22);
    let map = ModeMap::new([height, rate, unit(0) * 100.0, unit(1) / 0.22]).expect("of each other");
    let mut model = quadratic(&Square::identity(), 0.0, 0.0, Latent::zeros());
    let mut skew = [0.0; 78];
    skew[0] = -22.0;
    model.operators = Operators::from_triangles(&skew, &[]);
    let slots = Slots::between(
        &reduced(&[]),
        &reduced(&[Active { entry: line, values }]),
        map,
        1e-3,
        &Square::identity(),
    );
    assert!(slots.slides());
    model.potential.bend = Some(*slots.bend());
    Generic { slots: Some(slots), dt_s, ..model }
}

/// With friction by the path of the line taken in the middle of the step, the step is of second order: half the step, a quarter of the
/// error. Taken at its start it would be of first order.
#[test]
fn a_sliding_contact_line_is_stepped_to_second_order() {
    let after = |steps: u32| {
        let model = with_contact_line(0.04 / f64::from(steps));
        let mut state = LatentState { latent: unit(0) * 0.2 + unit(1), ..LatentState::default() };
        (0..steps).for_each(|_| {
            model.step(&mut state, 0.0);
        });
        state
    };
    let due = after(4096);
    assert!(due.held[1].abs() > 1e-4, "the line is caught: {:?}", due.held);
    let error = |steps: u32| {
        let state = after(steps);
        ((state.latent - due.latent).norm(), (state.held[1] - due.held[1]).abs())
    };
    let (coarse, fine) = (error(32), error(64));
    assert!(coarse.0 / fine.0 > 3.5 && coarse.1 / fine.1 > 3.5, "{coarse:?} {fine:?}");
}

/// Dahl's law: a line that goes one way by s is caught by z = l (1 - exp(-s / l)), however fast it goes.
#[test]
fn a_contact_line_that_goes_one_way_is_caught_by_its_path() {
    let model = with_contact_line(1e-4);
    let mut state = LatentState { latent: unit(0) * 0.2 + unit(1), ..LatentState::default() };
    let height_m = |state: &LatentState| 0.01 * state.latent[0];
    let start_m = height_m(&state);
    for _ in 0..4 {
        (0..100).for_each(|_| {
            model.step(&mut state, 0.0);
        });
        let way = (height_m(&state) - start_m) / REACH_M;
        close(state.held[1], REACH_M * (1.0 - crate::math::exp(-way)), 0.01);
    }
}

/// Energy of the memories: a spring's k z^2 / 2.
#[test]
fn the_energy_counts_what_the_memories_hold() {
    let model = with_contact_line(DT);
    let energy = |z: f64| model.energy(&LatentState { held: [0.0, z], heat: 0.5, ..LatentState::default() });
    assert_eq!(energy(0.0), 0.5);
    assert!(energy(1e-3) > 0.5);
    close(energy(2e-3) - 0.5, 4.0 * (energy(1e-3) - 0.5), 1e-12);
    // Caught by dry friction, the line turns energy of the mode into its own and into heat, and the sum stays.
    let mut state = LatentState { latent: unit(1), ..LatentState::default() };
    let before = model.energy(&state);
    for _ in 0..60 {
        let audit = model.step(&mut state, 0.0);
        assert!(audit.heat >= 0.0 && audit.energy_residual.abs() < 1e-12 * before, "{audit:?}");
    }
    close(model.energy(&state), before, 1e-12);
    assert!(state.heat > 0.01 * before);
}

/// A liquid with a yield stress that starts fast and comes to rest: each step is solved, its heat is dt phi dH . D dH with phi at the
/// mean gradient, the energy falls by just that, and the Jacobian is that of the step.
#[test]
fn friction_under_a_law_keeps_the_books_and_is_solved() {
    let law = FrictionLaw::new([20.0, 0.05, 0.6, 0.4]);
    let model = Generic { law, ..quadratic(&stiffness(), 8.0, 0.3, unit(3) * 20.0) };
    let law = law.expect("a law");
    let mut state =
        LatentState { latent: Latent::from_fn(|i, _| f64::from(number(i))), ..Default::default() };
    let (mut most, mut factors) = (0, (f64::INFINITY, 0.0_f64));
    for n in 0..120 {
        let start = state;
        let audit = model.step(&mut state, 0.0);
        assert_eq!(audit.outcome, StepOutcome::Solved, "step {n}: {audit:?}");
        most = most.max(audit.iterations);
        let (a, b) = (start.latent, state.latent);
        let potential = &model.potential;
        let gradient = potential.discrete_gradient(&a, &potential.ridges(&a), &b, &potential.ridges(&b));
        let p = gradient.dot(&(model.operators.friction * gradient));
        factors = (factors.0.min(law.factor(p)), factors.1.max(law.factor(p)));
        let heat = DT * law.factor(p) * p;
        assert!((audit.heat - heat).abs() < 1e-9 * model.energy(&start), "{} for {heat}", audit.heat);
        if n % 30 == 0 {
            let jacobian = model.jacobian(&start, 0.4);
            let along = Latent::from_fn(|i, _| f64::from(number(i + 50))) * 1e-6;
            let moved = |by: Latent| {
                let mut end = start;
                end.latent += by;
                model.step(&mut end, 0.4);
                end.latent
            };
            let difference = (moved(along) - moved(-along)) * 0.5;
            assert!((difference - jacobian.latent * along).norm() < 1e-4 * along.norm(), "step {n}");
        }
    }
    assert!(factors.0 < 1.0 && factors.1 > 3.0, "the law was used: {factors:?}");
    assert!(most <= 24, "{most} iterations");
    let mut single = LatentState { latent: unit(2) * 0.4, ..Default::default() };
    assert_eq!(model.step_in::<f32>(&mut single, 0.0).outcome, StepOutcome::Solved);
}
