//! Glasses that are no upright cylinders, and setups that cannot be.

use super::{COARSE_M, FINER_M, GLASS, Scratch, setup};
use meniscus_data::glass::{Profile, WallShape};
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Glass, Lattice, Recording, WALL_POINTS};
use meniscus_sph::validate::FirstMode;
use meniscus_sph::{Error, Setup, Simulator, record, relative_closure};

#[test]
fn a_cone_rests_level_and_sloshes_at_its_own_frequency() {
    let glass = Glass { wall: WallShape::Straight { taper: 0.15 }, ..GLASS };
    let mut simulator =
        Simulator::new(&Setup { glass, ..setup(&["viscosity=0.1", "wall_slip=inf"]) }).expect("it settles");
    let volume: f64 = simulator.motion().map(|(_, _, m)| m).sum::<f64>() / 1261.0;
    // A cone's stub: pi h (a^2 + a b + b^2)/3.
    let (a, b) = (glass.radius_m, glass.radius_at(glass.fill_m));
    let truth = std::f64::consts::PI * glass.fill_m * (a * a + a * b + b * b) / 3.0;
    assert!((volume / truth - 1.0).abs() < 0.01, "{volume} m3 for {truth}");
    let inside = |x: [f64; 3]| x[0].hypot(x[1]) <= glass.radius_at(x[2]) + 0.5 * COARSE_M;
    assert!(simulator.motion().all(|(x, _, _)| inside(x)));
    // Pushed by a tilt of gravity for a moment, the first moment of the liquid rings.
    let ring = |simulator: &mut Simulator| {
        let mut series = Vec::new();
        while simulator.time_s() < 0.9 {
            simulator
                .step(|t| if t < 0.05 { 2.0 * (std::f64::consts::PI * t / 0.05).sin() } else { 0.0 })
                .expect("it rings");
            let moment: f64 = simulator.motion().map(|(_, v, m)| m * v[0]).sum();
            if simulator.time_s() > 0.1 {
                series.push((simulator.time_s(), moment));
            }
        }
        let guess = meniscus_sph::validate::Tone { hz: 3.4, decay: 1.0 };
        meniscus_sph::validate::fit(&series, guess, &[]).expect("it rings").tone.hz
    };
    let hz = ring(&mut simulator);
    let straight = Setup { glass: GLASS, ..setup(&["viscosity=0.1", "wall_slip=inf"]) };
    let plain = ring(&mut Simulator::new(&straight).expect("it settles"));
    let theory = |glass: &Glass| FirstMode::new(glass).expect("a mode").hz();
    let (measured, theory) = (hz / plain, theory(&glass) / theory(&GLASS));
    println!("cone {hz} Hz, cylinder {plain} Hz: {measured} for {theory}");
    assert!((measured / theory - 1.0).abs() < 0.02, "{measured} for {theory}");
}

/// A round bottom, a belly and a narrow rim. The tracers fill the glass, the books close, and the file keeps its shape.
#[test]
fn a_wine_glass_is_recorded_and_read_again() {
    let points = [[0.0, 0.0], [0.008, 0.0225], [0.028, 0.035], [0.055, 0.0385], [0.1, 0.031]];
    let glass = Glass::curved(Profile::new(&points).expect("a profile"), 0.06, 0.1);
    let motion = Motion::parse("strokes:7", 2.0).expect("a known motion");
    let setup = Setup { glass, spacing_m: FINER_M, ..setup(&[]) };
    let recording = record(&setup, &motion, 40, "test", |_| ()).expect("the glass is simulated");
    assert!(
        recording.wall_m[..WALL_POINTS].iter().all(|h| (h - 0.06).abs() < 5e-4),
        "it does not rest level"
    );
    assert!(recording.wall_m.iter().any(|h| (h - 0.06).abs() > 1e-3), "it was not stirred");
    let closure = relative_closure(&recording.energy);
    assert!(closure < 0.01, "energy closes to {closure}");
    let lattice = Lattice::new(&glass);
    let lowest = lattice.tracer(40, 0, 0.06);
    assert!(glass.wall_distance(&lowest) > 0.0, "{lowest:?} is outside");

    let file = Scratch::new("wine.safetensors");
    recording.save(&file.0).expect("written");
    assert_eq!(Recording::load(&file.0).expect("read").glass, glass);
    assert!(!recording.is_plain(), "no model knows such a glass");
}

#[test]
fn setups_that_cannot_be_are_refused() {
    let refusal = |setup: Setup| match Simulator::new(&setup) {
        Err(Error::Setup(why)) => why,
        other => panic!("{:?}", other.map(|s| s.particles())),
    };
    assert!(refusal(setup(&["fill=0.12"])).contains("rim from the fill"));
    assert!(refusal(Setup { step_s: Some(0.01), ..setup(&[]) }).contains("would blow up"));
    assert!(
        refusal(Setup { glass: Glass { wall: WallShape::Straight { taper: 0.5 }, ..GLASS }, ..setup(&[]) })
            .contains("a taper of 0.5")
    );
    let steep = Glass { rim_m: 0.072, ..GLASS };
    assert!(refusal(Setup { glass: steep, ..setup(&["container_tilt=0.3"]) }).contains("below the rim"));
}
