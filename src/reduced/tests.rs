//! The waves of second order in a whole model: what pulls them back, and what takes their energy.
#![allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]

extern crate std;

use super::coupling::Coupling;
use super::{Forcing, ReducedModel, ReducedState, SloshMode, Wave, step};
use crate::reduced::effects::tests::{DT, GLASS, active, model};
use crate::reduced::effects::{Active, Slot};
use crate::units::GRAVITY_M_S2;
use std::vec::Vec;
use std::{assert, assert_eq, panic};

/// Angular frequency (1/s) of the free ring wave (0,1), from its zero crossings.
fn ring_frequency(model: &ReducedModel) -> f64 {
    let mut state = ReducedState::default();
    state.bound_waves.height[0][0] = 1e-3;
    free_frequency(model, state, |state| state.bound_waves.height[0][0])
}

/// Angular frequency (1/s) of a free wave from `state` on, from the zero crossings of its `height`.
fn free_frequency(model: &ReducedModel, mut state: ReducedState, height: fn(&ReducedState) -> f64) -> f64 {
    let push = Forcing { lift_m_s2: model.port.lift_m_s2, ..Forcing::default() };
    let (mut last, mut crossings) = (height(&state), Vec::new());
    for n in 1..480 {
        step(model, &mut state, &push);
        let here = height(&state);
        if last * here < 0.0 {
            crossings.push((f64::from(n) - here / (here - last)) * DT);
        }
        last = here;
    }
    std::f64::consts::PI * (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0])
}

#[test]
fn what_pulls_the_surface_back_pulls_the_waves_of_second_order_back_too() {
    let liquid = 1e-7;
    let plain = ring_frequency(&model(liquid, &[]));
    let ring = SloshMode::new(&GLASS, Wave::Ring(0));
    assert!((plain / ring.square(GRAVITY_M_S2).sqrt() - 1.0).abs() < 1e-3, "{plain}");
    // w^2 = (g k + sigma k^3/rho) tanh kh, and (g + a) for g.
    let k = ring.k;
    let tension = 1.0 + 0.2 * k * k / (1261.0 * GRAVITY_M_S2);
    // A held line pulls all rings as one: sum s_n/(w^2 - w_n^2) = 1, s_n = 2 pi R k_c/m_n; between the first two.
    let rings = [0, 1, 2].map(|n| SloshMode::new(&GLASS, Wave::Ring(n)));
    let squares = rings.map(|mode| mode.square(GRAVITY_M_S2));
    let springs = rings.map(|mode| 2.0 * std::f64::consts::PI * GLASS.radius_m * 20.0 / mode.mass_kg);
    let (mut low, mut high) = (squares[0], squares[1]);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let sum: f64 = springs.iter().zip(squares).map(|(s, square)| s / (middle - square)).sum();
        if sum > 1.0 { low = middle } else { high = middle }
    }
    let held = low / squares[0];
    assert!(held < 0.8 * (springs[0] / squares[0]) + 1.0, "{held}");
    for (name, value, wanted) in [
        ("surface_tension", 0.2, tension),
        ("vertical_acceleration", 1.0, 1.0 + 1.0 / GRAVITY_M_S2),
        ("pinned_line", 20.0, held),
    ] {
        let found = (ring_frequency(&model(liquid, &[active(name, [value, 0.0])])) / plain).powi(2);
        assert!((found / wanted - 1.0).abs() < 2e-3, "{name}: {found} for {wanted}");
    }
    // A memory that outlasts the wave is a spring, 4 G k^2/rho, where a wall that slips freely has no layer.
    let slips = active("wall_slip", [10.0, 0.0]);
    let memory = |time: f64| active("viscoelastic", [5.0, time]);
    let found = (ring_frequency(&model(liquid, &[slips, memory(1e3)]))
        / ring_frequency(&model(liquid, &[slips])))
    .powi(2);
    let wanted = 1.0 + 4.0 * 5.0 * k * k / (1261.0 * ring.square(GRAVITY_M_S2));
    assert!((found / wanted - 1.0).abs() < 2e-3, "memory: {found} for {wanted}");
}

#[test]
fn what_the_first_mode_makes_of_a_thinning_liquid_the_waves_beside_it_feel() {
    // Of the ring's height after a quarter of a second, what is odd in its start decays freely.
    let left = |index: f64, first: f64| {
        let model = model(0.2, &[active("shear_thinning", [index, 0.0])]);
        let after = |ring: f64| {
            let mut state = ReducedState::default();
            state.height[0][0] = first;
            state.bound_waves.height[0][0] = ring;
            for _ in 0..120 {
                step(&model, &mut state, &Forcing::default());
            }
            let rate = state.bound_waves.rate[0][0] / (GRAVITY_M_S2 * 109.0).sqrt();
            (state.bound_waves.height[0][0], rate)
        };
        let (up, down) = (after(1e-4), after(-1e-4));
        (0.5 * (up.0 - down.0)).hypot(0.5 * (up.1 - down.1)) / 1e-4
    };
    assert!((left(1.0, 2e-2) / left(1.0, 1e-3) - 1.0).abs() < 1e-9);
    assert!(left(0.5, 2e-2) > 1.2 * left(0.5, 1e-3), "{} {}", left(0.5, 2e-2), left(0.5, 1e-3));
}

#[test]
fn foam_rubs_on_a_small_ring_by_five_thirds_of_what_it_rubs_on_the_first_mode() {
    let foam = active("foam", [0.1, 0.0]);
    let ring = SloshMode::new(&GLASS, Wave::Ring(0));
    let Slot::Line(law) = foam.entry.slot else { panic!("foam acts along the line") };
    let left = |effects: &[Active]| {
        let model = model(0.02, effects);
        let mut lost = 0.0;
        let mut after = |small: f64| {
            let mut state = ReducedState::default();
            (state.height[0][0], state.bound_waves.height[0][0]) = (1e-2, small);
            for _ in 0..240 {
                step(&model, &mut state, &Forcing::default());
                let (a, v) = (state.height[0][0], state.rate[0][0]);
                let speed =
                    (v * v + model.frequency_and_damping(0).expect("a first mode").0.powi(2) * a * a).sqrt();
                lost += 0.5 * DT * law(&foam.values, speed, &GLASS) / (2.0 * ring.mass_kg);
            }
            [state.bound_waves.height[0][0], state.bound_waves.rate[0][0] / ring.square(GRAVITY_M_S2).sqrt()]
        };
        let (up, down) = (after(1e-4), after(-1e-4));
        ((up[0] - down[0]).hypot(up[1] - down[1]), lost)
    };
    let (plain, _) = left(&[]);
    let (foamed, lost) = left(&[foam]);
    let ratio = (plain / foamed).ln() / lost;
    assert!((ratio / (5.0 / 3.0) - 1.0).abs() < 0.05, "{ratio}");
}

#[test]
fn a_wave_along_a_lean_carries_a_saddle_at_its_own_frequency_and_a_rolled_camera_sees_none() {
    const STEPS: u32 = 40;
    let saddle = |name: &str, height: f64| {
        let model = model(1e-7, &[active(name, [0.035, 0.0])]);
        let mut state = ReducedState::default();
        state.height[0][0] = height;
        for _ in 0..STEPS {
            step(&model, &mut state, &Forcing::default());
        }
        state.bound_waves.height[1][0]
    };
    // What is odd in the amplitude is the lean's; what is even is the second order's.
    let odd = |name: &str| 0.5 * (saddle(name, 1e-2) - saddle(name, -1e-2));
    // s'' + w2^2 s = -g B t a cos w1 t from rest: s = -g B t a (cos w1 t - cos w2 t)/(w2^2 - w1^2).
    let modes = [Wave::First(0), Wave::Saddle(0)].map(|wave| SloshMode::new(&GLASS, wave));
    let squares = modes.map(|mode| mode.square(GRAVITY_M_S2));
    let [one, two] = squares.map(|square| (square.sqrt() * f64::from(STEPS) * DT).cos());
    let kappa = modes.map(|mode| mode.steepness);
    let bent = Coupling::with(Wave::Saddle(0)).lean(kappa, GLASS.radius_m);
    let wanted = -GRAVITY_M_S2 * bent * 0.035_f64.tan() * 1e-2 * (one - two) / (squares[1] - squares[0]);
    assert!((odd("container_tilt") / wanted - 1.0).abs() < 0.02, "{} for {wanted}", odd("container_tilt"));
    assert_eq!(odd("camera_slope"), 0.0);
    assert!(saddle("camera_slope", 1e-2).abs() > 1e-5);
}

#[test]
fn the_first_mode_swings_at_the_frequency_that_the_model_states() {
    let plain = model(1e-7, &[]).swinging_frequency();
    for (name, values) in [
        ("vertical_acceleration", [1.0, 0.0]),
        ("surface_tension", [0.2, 0.0]),
        ("radius", [0.002, 0.0]),
        ("viscoelastic", [5.0, 1.0]),
        ("viscoelastic", [5.0, 0.05]),
    ] {
        let model = model(1e-7, &[active(name, values)]);
        // At rate from the level: a liquid that remembers has nothing to forget then.
        let mut state = ReducedState::default();
        state.rate[0][0] = 1e-3;
        let found = free_frequency(&model, state, |state| state.height[0][0]);
        let stated = model.swinging_frequency();
        assert!((found / stated - 1.0).abs() < 2e-3, "{name} {values:?}: {found} for {stated}");
        assert!((stated / plain - 1.0).abs() > 0.01, "{name} does nothing: {stated} and {plain}");
    }
}
