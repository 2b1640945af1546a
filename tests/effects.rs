//! Effects, motions and glasses of the simulator against theory, coarsely: 8.75 mm (about 420 particles), and 7 mm where the
//! surface's edge matters. `meniscus simulate validate` holds every effect at 5 mm. The bounds are the measured
//! errors, rounded up: contact line -1 %, foam's exponent +10 %, memory -21 %, thinning -10 %; an effect that does nothing is 100 % off.

#[path = "effects/command.rs"]
mod command;
#[path = "effects/glasses.rs"]
mod glasses;
#[path = "effects/leaning.rs"]
mod leaning;
#[path = "effects/motions.rs"]
mod motions;

use meniscus::reduced::effects::find;
use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::{Liquid, known};
use meniscus_data::recording::Glass;
use meniscus_sph::validate::effect;
use meniscus_sph::{Setup, Simulator};
use std::path::PathBuf;

const GLASS: Glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
const COARSE_M: f64 = 0.00875;

/// Where the surface itself matters.
const FINER_M: f64 = 0.007;

fn setup(effects: &[&str]) -> Setup {
    let mut on = Effects::default();
    for effect in effects {
        on.parse(effect).expect("a known effect");
    }
    let liquid = Liquid::load("glycerine").expect("a known liquid");
    Setup { glass: GLASS, liquid, spacing_m: COARSE_M, seed: 0, no_slip: true, effects: on, step_s: None }
}

/// Holds `name` against its theory: every deviation within `percent`.
fn hold(name: &str, percent: f64) {
    hold_at(COARSE_M, name, percent);
}

/// The same at another spacing.
fn hold_at(spacing_m: f64, name: &str, percent: f64) {
    let law = find(name).and_then(|effect| effect.simulator.law()).expect("the simulator carries it");
    let held = effect(law, spacing_m).expect("the case runs to its end");
    assert!(!held.is_empty(), "{name} has no case");
    for held in held {
        println!("{name}: {} {} for {}, {:+.1} %", held.what, held.measured, held.theory, held.error());
        assert!(held.error().abs() < percent, "{name}: {held:?}, {:+.1} %", held.error());
    }
}

#[test]
fn a_line_that_slides_and_foam_slow_the_slosh_as_their_laws_say() {
    hold_at(FINER_M, "contact_line", 5.0);
    hold_at(FINER_M, "foam", 15.0);
}

#[test]
fn tension_and_slip_change_frequency_and_decay_as_theory_says() {
    hold("surface_tension", 8.0);
    hold("wall_slip", 10.0);
}

#[test]
#[ignore = "a minute; `simulate validate` has the same at 5 mm: cargo xtask nightly --only sizing"]
fn a_liquid_that_thins_decays_as_its_own_law_says() {
    hold_at(FINER_M, "shear_thinning", 12.0);
}

#[test]
fn memory_raises_the_frequency_and_the_decay() {
    hold("viscoelastic", 25.0);
}

#[test]
fn an_inclined_glass_has_an_inclined_surface() {
    hold_at(FINER_M, "container_tilt", 3.0);
}

#[test]
fn every_known_liquid_runs() {
    for name in known() {
        let liquid = Liquid::load(name).expect("a known liquid");
        let mut simulator = Simulator::new(&Setup { liquid, ..setup(&[]) }).expect("it settles");
        while simulator.time_s() < 0.05 {
            simulator.step(|t| 2.0 * (20.0 * t).sin()).expect(name);
        }
        assert!(simulator.motion().all(|(_, v, _)| v.iter().all(|v| v.abs() < 1.0)), "{name} blew up");
    }
}

/// A file or folder of this process that is gone when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(std::env::temp_dir().join(format!("meniscus-effects-{}-{name}", std::process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What a failed test did not make cannot be removed.
        let _ = std::fs::remove_file(&self.0);
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
