//! `setup` for clear water: distance by the wall or by a ruler, and the remedies.

use crate::scenes::{HEIGHT, WIDTH, at_rest, optics, pairs, said, scenes};
use meniscus_service::setup::{Inspection, Setup, SetupOrigin, StatedPlace, inspect, inspect_clear};
use meniscus_usb::camera::OutlineImage;
use meniscus_virtual::camera_study::traced::set::{Behind, Kind, Light, TracedScene};
use std::path::Path;

fn look(scene: &TracedScene, place: Option<StatedPlace>) -> Inspection {
    let origin =
        SetupOrigin { outline: OutlineImage::Infrared, camera: "a traced camera", made_by: "a test" };
    inspect_clear(&pairs(scene, 16), optics(scene), place, said(scene), origin)
}

/// The place as a ruler tells it.
fn by_ruler(scene: &TracedScene) -> StatedPlace {
    let wall_mm = scene.truth.distance_mm - 35.0 - scene.truth.wall_mm + 2.0;
    StatedPlace { wall_m: 1e-3 * wall_mm, height_m: 1e-3 * (scene.truth.camera_height_mm - 1.5) }
}

fn missed(inspection: &Inspection) -> Vec<String> {
    let missed = inspection.findings.iter().filter(|finding| finding.check.missed());
    missed.map(|finding| format!("{}: {}", finding.check.name, finding.remedy)).collect()
}

#[test]
fn setup_measures_the_wall_of_a_clear_glass_or_takes_its_place() {
    for set in ["develop", "judge"] {
        let scene = at_rest(set);
        // Stereo sees the wall of this glass.
        let measured = look(&scene, None);
        assert!(measured.ok(), "{:#?}", missed(&measured));
        let setup = measured.setup.expect("seen");
        let off_mm = setup.view.distance_mm - scene.truth.distance_mm;
        println!("{set}: distance {off_mm:+.2} mm off by the depth of the wall");
        assert!(off_mm.abs() < 3.0);
        // Of this one the room behind it.
        let behind = TracedScene { depth_m: vec![0.7; WIDTH * HEIGHT], ..scene.clone() };
        let blind = look(&behind, None);
        assert!(blind.setup.is_none());
        assert!(blind.remedies()[0].remedy.contains("--distance-mm"), "{:#?}", missed(&blind));
        let stated = look(&behind, Some(by_ruler(&scene)));
        assert!(stated.ok(), "{:#?}", missed(&stated));
        let setup = stated.setup.expect("seen");
        let off_mm = setup.view.distance_mm - scene.truth.distance_mm;
        println!("{set}: distance {off_mm:+.2} mm off by a ruler that is 2 mm wrong");
        assert!(off_mm.abs() < 3.0);

        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("clear-{set}.toml"));
        setup.write(&path).expect("written");
        let back = Setup::read(&path).expect("read");
        assert_eq!(
            (back.clone(), back.settings(optics(&scene)).liquid),
            (setup, meniscus::surface::Liquid::Clear)
        );
    }
}

/// The remedy follows from the image.
#[test]
fn setup_says_what_is_missing_of_card_and_lamp() {
    let remedies = |scene: &TracedScene| look(scene, Some(by_ruler(scene))).remedies()[0].remedy.clone();
    let of = |set: &str, light: Light, kind: Kind| {
        let all = scenes(set, kind).into_iter();
        all.filter(move |scene| scene.truth.light == light).collect::<Vec<_>>()
    };
    let visible = of("", Light::Visible, Kind::Water);
    assert_eq!(visible.len(), 4);
    for scene in &visible {
        assert!(remedies(scene).contains("850 nm"), "{}: {}", scene.truth.name, remedies(scene));
    }
    for scene in &of("", Light::NearInfrared, Kind::Empty) {
        let seen = look(scene, Some(by_ruler(scene)));
        assert!(seen.rest.is_none_or(|rest| rest.seen == 0.0), "{}: a profile", scene.truth.name);
        let wanted = if scene.truth.behind == Behind::Card { "takes too little" } else { "too dark" };
        assert!(remedies(scene).contains(wanted), "{}: {}", scene.truth.name, remedies(scene));
    }
    // A set-up of an opaque liquid refuses water as before, and says that there is another way.
    let scene = &at_rest("develop");
    let behind = TracedScene { depth_m: vec![0.7; WIDTH * HEIGHT], ..scene.clone() };
    let origin =
        SetupOrigin { outline: OutlineImage::Infrared, camera: "a traced camera", made_by: "a test" };
    let opaque = inspect(&pairs(&behind, 16), optics(scene), said(scene), origin);
    assert!(
        opaque.setup.is_none() && opaque.remedies()[0].remedy.contains("--outline clear"),
        "{:#?}",
        missed(&opaque)
    );
}
