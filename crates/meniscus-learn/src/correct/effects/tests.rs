//! Roll-outs with effects against the step of a run.

use super::*;
use crate::correct::checkpoint_parts::CheckpointParts;
use crate::correct::trainable_model::DYNAMICS;
use crate::operators::unrolled::dynamics_of;
use meniscus::latent::generic::{Operators as RunOperators, Slots};
use meniscus::reduced::effects::{Active, Stated, find};
use meniscus::reduced::{Baseline, Cylinder, ReducedModel, Rheology};
use meniscus::surface::POINTS;
use meniscus_optim::weights::leaves;
use meniscus_platform::files::AlignedBytes;

/// Turns of a roll-out: half a period of the first mode.
const TURNS: usize = 8;

/// Puts the effects of these names and values into `generic`, whose weights are in `parts`; returns the map of its first mode.
fn put(generic: &mut Generic<'_>, parts: &CheckpointParts, effects: &[(&str, f64)]) -> ModeMap {
    let hessian = generic.potential.hessian();
    // The height at the wall, its rate, and the states of least energy with the one and with the other.
    const STEP: f64 = 1e-3;
    let slope = |i: usize| {
        let mut state = LatentState::default();
        state.latent[i] = STEP;
        f64::from(parts.surface.heights(&[state])[POINTS - 1]) / STEP
    };
    let height = Latent::from_fn(|i, _| slope(i));
    let rate = (dynamics_of(&parts.weights[DYNAMICS]).flow() * hessian).tr_mul(&height);
    let rows = nalgebra::SMatrix::<f64, 2, LATENTS>::from_rows(&[height.transpose(), rate.transpose()]);
    let ease = hessian.try_inverse().expect("H has one minimum") * rows.transpose();
    let along = ease * (rows * ease).try_inverse().expect("two directions");
    let column = |k: usize| Latent::from_iterator(along.column(k).iter().copied());
    let map = ModeMap::new([height, rate, column(0), column(1)]).expect("a map");
    let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
    let liquid = Rheology::newtonian(0.95);
    let stated = Stated { consistency_pa_sn: 0.95, radius_m: 0.035, fill_m: 0.07 };
    let active: Vec<Active> = effects
        .iter()
        .map(|(name, value)| {
            let effect = find(name).expect("in the library");
            effect.active(&[Some(*value), None], &stated).expect("a value in its range")
        })
        .collect();
    let model =
        |active: &[Active]| ReducedModel::new(glass, liquid, &Baseline::default(), active, generic.dt_s);
    let slots = Slots::between(&model(&[]), &model(&active), map, 1e-3, &generic.potential.hessian());
    generic.potential.bend = Some(*slots.bend());
    generic.slots = Some(slots);
    map
}

/// The latents after the turns of the run from `start`, without a port.
fn end(generic: &Generic<'_>, start: &Latent) -> Latent {
    let mut state = LatentState { latent: *start, ..LatentState::default() };
    (0..TURNS).for_each(|_| {
        generic.step(&mut state, 0.0);
    });
    state.latent
}

#[test]
fn a_roll_out_has_the_value_and_the_slope_of_the_run() {
    // Thicker and thinner than the 0.95 Pa s of the model.
    value_and_slope(2.0);
    value_and_slope(0.4);
}

/// A roll-out under this viscosity, Pa s, and a lift.
fn value_and_slope(viscosity_pa_s: f64) {
    let blob = AlignedBytes::copy(meniscus_shipped::MODEL);
    let parts = CheckpointParts::new(&blob).expect("the shipped model");
    let mut generic = with_effects(&blob).expect("the shipped model").generic;
    let map = put(&mut generic, &parts, &[("viscosity", viscosity_pa_s), ("vertical_acceleration", 3.0)]);
    // 8 mm high at the wall and falling.
    let start = map.along_height * 0.008 - map.along_rate * 0.1;
    let rest = LatentState { latent: start, ..LatentState::default() };
    let stand_in = StandIn::along(&generic, std::iter::once(&rest)).expect("effects");
    assert!(
        (stand_in.phi > 1.2) == (viscosity_pa_s > 0.95),
        "what is thicker dissipates more: {}",
        stand_in.phi
    );

    let device = Device::flex().autodiff();
    let weights = &parts.weights[DYNAMICS];
    let (tensors, dynamics) = (leaves(weights, &device), dynamics_of(weights));
    let row = |v: Vec<f32>| Matrix::new(1, v.len(), v).tensor(&device);
    let roll_out = |stand_in: &StandIn| {
        let step = StepWithEffects::new(&generic, stand_in, &tensors, &dynamics, &device);
        let mut held = [Held::default()];
        let mut x = row(start.iter().map(|&x| x as f32).collect());
        for _ in 0..TURNS {
            x = step.turn(x, row(vec![0.0]), &mut held);
        }
        x
    };
    let (said, due) = (roll_out(&stand_in), end(&generic, &start));
    let apart = Latent::from_iterator(numbers(said.clone().inner()).into_iter().map(f64::from)) - due;
    assert!(apart.norm() < 1e-4 * due.norm(), "{} of {}", apart.norm(), due.norm());

    // The slope of |x|^2 / 2 in a common factor on C, by differences of the run and through the graph.
    let c = &weights[1];
    let lower = |factor: f64| -> Vec<f32> {
        let rows = dynamics.friction * factor;
        (0..LATENTS).flat_map(|i| (0..=i).map(move |j| rows[(i, j)] as f32)).collect()
    };
    let below = |i: usize| (0..i).map(move |j| dynamics.skew[(i, j)] as f32);
    let skew: Vec<f32> = (0..LATENTS).flat_map(below).collect();
    let of_run = |factor: f64| {
        let operators = RunOperators::from_triangles(&skew, &lower(factor));
        0.5 * end(&Generic { operators, ..generic.clone() }, &start).norm_squared()
    };
    let wanted = (of_run(1.01) - of_run(0.99)) / 0.02;
    let through_the_graph = |stand_in: &StandIn| {
        let loss = roll_out(stand_in).square().sum() * 0.5;
        let slopes = numbers(tensors[1].grad(&loss.backward()).expect("C is a leaf"));
        slopes.iter().zip(&c.values).map(|(slope, c)| f64::from(slope * c)).sum::<f64>()
    };
    let found = through_the_graph(&stand_in);
    // Without S and phi in the gradient the value is the same and its slope is not.
    let plain = through_the_graph(&StandIn { bend: Square::identity(), phi: 1.0, ..stand_in.clone() });
    println!("slope {wanted}; found {found}; of the weights alone {plain}");
    assert!((found / wanted - 1.0).abs() < 0.02, "{found} for {wanted}");
    if stand_in.phi > 1.0 {
        assert!((plain / wanted - 1.0).abs() > 0.15, "{plain} for {wanted}");
    }
}

#[test]
fn memories_are_those_of_a_run() {
    let blob = AlignedBytes::copy(meniscus_shipped::MODEL);
    let parts = CheckpointParts::new(&blob).expect("the shipped model");
    let mut generic = with_effects(&blob).expect("the shipped model").generic;
    put(&mut generic, &parts, &[("contact_line", 0.1)]);
    let mut state = LatentState { latent: Latent::repeat(0.3), ..LatentState::default() };
    let u = [0.0_f32, 0.4, -0.2, 0.1];
    let mut run = vec![state];
    for &u in &u[1..] {
        generic.step(&mut state, f64::from(u));
        run.push(state);
    }
    let latents: Vec<Latent> = run.iter().map(|state| state.latent).collect();
    for (found, due) in remembering(&generic, &latents, &u).iter().zip(&run) {
        assert_eq!((found.latent, found.held), (due.latent, due.held));
    }
    assert!(run[3].held.iter().any(|z| *z != 0.0), "the line was moved: {:?}", run[3].held);
}
