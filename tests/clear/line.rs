//! The contact line of clear water: its error, and what a camera's faults, card, lamp and depth change.

use crate::figures::Figures;
use crate::scenes::{HEIGHT, JUDGED, WIDTH, before_a_card, scenes};
use meniscus::surface::{Config, ExtractionState, extract};
use meniscus::usb::frame::{DepthFrame, OutlineFrame, Stamp};
use meniscus_virtual::camera_study::traced::degrade::{Faults, degrade};
use meniscus_virtual::camera_study::traced::set::{Behind, Kind, Light, TracedScene, settings};

#[test]
fn water_before_a_card_is_read_within_the_targets() {
    for set in ["develop", JUDGED] {
        let scenes = before_a_card(set);
        assert!(scenes.len() >= 6, "{} scenes", scenes.len());
        let figures = Figures::of(&scenes, &Faults::default());
        figures.print(set);
        assert!(if set == JUDGED { figures.pass() } else { figures.rms_mm() <= 0.8 }, "{set}");
        let flat = figures.of_flat(&scenes);
        flat.print("  flat");
        assert!(!flat.pass() && flat.rms_mm() > 2.0 * figures.rms_mm(), "{set}");
    }
}

#[test]
fn a_cameras_faults_cost_less_than_the_target() {
    let scenes = before_a_card("");
    for (name, faults) in [
        ("dots of 60 grey", Faults { dots: 60.0, ..Faults::default() }),
        ("noise of 4 grey", Faults { grey_rms: 4.0, ..Faults::default() }),
        ("0.6 times the light", Faults { gain: 0.6, ..Faults::default() }),
        ("defocus of 1 px", Faults { defocus_px: 1.0, ..Faults::default() }),
        ("smear of 3 px", Faults { smear_px: 3, ..Faults::default() }),
    ] {
        let figures = Figures::of(&scenes, &faults);
        figures.print(name);
        assert!(figures.rms_mm() <= 0.8 && figures.seen() >= 0.9, "{name}");
    }
}

/// Informational but for the errors: without the card or without the light less is seen, and nothing is seen wrong.
#[test]
fn what_is_seen_without_card_or_light_is_right() {
    for (name, behind, light) in [
        ("no card", Behind::Plain, Light::NearInfrared),
        ("no light of 850 nm", Behind::Card, Light::Visible),
    ] {
        let fit = |scene: &TracedScene| scene.truth.behind == behind && scene.truth.light == light;
        let scenes: Vec<_> = scenes("", Kind::Water).into_iter().filter(fit).collect();
        assert_eq!(scenes.len(), 4);
        let figures = Figures::of(&scenes, &Faults::default());
        figures.print(name);
        assert!(figures.points.is_empty() || figures.rms_mm() <= 0.8, "{name}");
    }
}

/// Stereo measures the room behind the glass, its wall, nothing, or patches of these.
#[test]
fn the_depth_image_changes_nothing() {
    for scene in &before_a_card("develop") {
        let profile = |scene: &TracedScene| {
            let config = Config::new(settings(&scene.truth)).expect("sound settings");
            let pair = degrade(scene, WIDTH, &Faults::default(), 0);
            let stamp = Stamp::default();
            let depth = DepthFrame { bytes: &pair.depth, width: WIDTH, height: HEIGHT, stamp };
            let outline = OutlineFrame { bytes: &pair.infrared, width: WIDTH, height: HEIGHT, stamp };
            extract(&config, &mut ExtractionState::new(), depth, outline).expect("seen")
        };
        let own = profile(scene);
        for depth_m in [0.0, 0.2, 0.4, 2.0] {
            let other = TracedScene { depth_m: vec![depth_m; WIDTH * HEIGHT], ..scene.clone() };
            assert_eq!(profile(&other), own, "{} at {depth_m} m", scene.truth.name);
        }
    }
}
