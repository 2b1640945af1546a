//! Second-order waves of the reduced model beside those of the particle simulator, which shares no code with it.

use meniscus::reduced::{
    Baseline, Cylinder, Forcing, ReducedModel, ReducedState, Rheology, step, wall_harmonics,
};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Kinematics;
use meniscus_data::recording::wall_azimuth;
use meniscus_data::scene_file::GLASS;
use meniscus_sph::{Setup, WatchedGlass};
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;

/// Frames of the motion.
const FRAMES: usize = 110;

/// Steps of the reduced model in a frame.
const STEPS: usize = 4;

/// Acceleration of the glass in a frame, m/s2: a swing below the first mode that begins softly; then the liquid rings.
fn acceleration(frame: usize) -> f64 {
    let t = frame as f64 * FRAME_INTERVAL_S;
    if t < 0.9 { 0.8 * (t / 0.3).min(1.0) * (TAU * 2.9 * t).sin() } else { 0.0 }
}

/// Mean height along the wall over rest and its harmonic cos 2 theta, m.
fn second_order(wall_m: &[f32]) -> [f64; 2] {
    let (mut mean, mut cos2) = (0.0, 0.0);
    for (k, z) in wall_m.iter().enumerate() {
        let over = f64::from(*z) - GLASS.fill_m;
        mean += over / wall_m.len() as f64;
        cos2 += 2.0 * over * (2.0 * wall_azimuth(k)).cos() / wall_m.len() as f64;
    }
    [mean, cos2]
}

/// Part of the simulator's second order that the reduced model misses, root mean square.
fn missed(liquid: &Liquid, baseline: &Baseline, truth: &[[f64; 2]]) -> f64 {
    let glass =
        Cylinder { radius_m: GLASS.radius_m, depth_m: GLASS.fill_m, density_kg_m3: liquid.density_kg_m3 };
    let water = Rheology::newtonian(liquid.rheology.consistency);
    let model = ReducedModel::new(glass, water, baseline, &[], FRAME_INTERVAL_S / STEPS as f64);
    let mut state = ReducedState::default();
    let (mut off, mut size) = (0.0, 0.0);
    for (frame, due) in truth.iter().enumerate() {
        let [mean, _, _, cos2, _] = wall_harmonics(&model, &state, &[0.0; 2]);
        for (due, found) in due.iter().zip([mean, cos2]) {
            off += (due - found) * (due - found);
            size += due * due;
        }
        let push = Forcing { along_m_s2: [-acceleration(frame), 0.0], lift_m_s2: 0.0 };
        for _ in 0..STEPS {
            let _balance = step(&model, &mut state, &push);
        }
    }
    (off / size).sqrt()
}

/// Water that rings after a swing: an inviscid standing wave explains half of the simulator's second order. The guess that stood here before
/// missed more than no second order at all.
#[test]
fn the_second_order_of_water_is_that_of_a_standing_wave() {
    let stop = AtomicBool::new(false);
    let liquid = Liquid::load("water").expect("a known liquid");
    let effects = Effects::default();
    let setup = Setup {
        glass: GLASS,
        liquid: liquid.clone(),
        spacing_m: 0.005,
        seed: 3,
        no_slip: true,
        effects,
        step_s: None,
    };
    let mut glass = WatchedGlass::new(&setup, &stop).expect("it settles");
    for frame in 0..FRAMES {
        glass.advance(&stop, |_| Kinematics::along_x(acceleration(frame))).expect("it is simulated");
    }
    let truth: Vec<[f64; 2]> = glass.wall_m().iter().map(|wall| second_order(wall)).collect();
    let with = |drive| missed(&liquid, &Baseline { drive, ..Baseline::default() }, &truth);
    let theory = with(None);
    let [none, guess] = [[[0.0; 2]; 2], [[0.5, -0.5]; 2]].map(|drive| with(Some(drive)));
    println!(
        "missed: {:.0} % by theory, {:.0} % without, {:.0} % by the guess",
        100.0 * theory,
        100.0 * none,
        100.0 * guess
    );
    assert!(theory < 0.6 * none && guess > none, "{theory} {none} {guess}");
}
