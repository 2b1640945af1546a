//! A glass that is set up with stated measures, and read with that setup.

use crate::reading::{connect, errors, lens_of, read, stream};
use crate::rendered::{Rendered, SHOWN, Troubles, USUAL};
use meniscus::surface::{Config, OutlineAssembler, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_service::setup::{
    Gather, Inspection, MeasuredGlass, Pair, SetupOrigin, StatedCamera, StatedPlace, inspect_outline,
};
use meniscus_usb::camera::OutlineImage;
use std::path::Path;

/// Measures of the glass by hand.
pub(crate) const SAID: MeasuredGlass = MeasuredGlass::of([35.0, 70.0, 110.0]);

/// Returns the inspection of a resting glass by a camera that is said to be `stated`.
fn looked_at(place: Settings, focal_px: f32, stated: StatedCamera) -> (Inspection, Vec<Pair>) {
    let mut session = connect(Rendered::new(USUAL, focal_px, place, Troubles::default()).resting());
    let rectifier = stated.lens.rectifier();
    let (mut colour, mut grey) = (vec![0; rectifier.colour_bytes()], vec![0; rectifier.grey_bytes()]);
    let mut gather =
        Gather::of_outline((640, 480), OutlineAssembler::colour(rectifier, &mut colour, &mut grey));
    let mut pairs = Vec::new();
    let (_, ended) = stream(&mut session, 40, |payload| pairs.extend(gather.take(Stream::Outline, payload)));
    ended.expect("no trouble");
    let origin = SetupOrigin { outline: OutlineImage::Colour, camera: "a webcam", made_by: "a test" };
    (inspect_outline(&pairs, stated, SAID, origin), pairs)
}

/// A place with a tilt, and its measures by a ruler that is some millimetres wrong.
fn by_ruler() -> (Settings, StatedCamera) {
    let place = Settings {
        camera_height_m: 0.028,
        camera_distance_m: 0.420,
        camera_pitch_rad: 0.05,
        ..Settings::default()
    };
    let stated = StatedCamera {
        lens: lens_of(USUAL, 604.0),
        place: StatedPlace { wall_m: 0.385 + 0.003, height_m: 0.028 - 0.002 },
    };
    (place, stated)
}

#[test]
fn a_glass_is_set_up_by_ruler_and_read_with_that_setup() {
    let (place, stated) = by_ruler();
    let (inspection, pairs) = looked_at(place, 610.0, stated);
    assert!(pairs.len() == 40 && pairs.iter().all(|pair| pair.depth.is_none()));
    let missed: Vec<_> = inspection.findings.iter().filter(|finding| finding.check.missed()).collect();
    assert!(missed.is_empty(), "{missed:#?}");
    let names: Vec<&str> = inspection.findings.iter().map(|finding| &*finding.check.name).collect();
    assert!(!names.contains(&"depth_share") && names.contains(&"radius_seen_mm"), "{names:?}");
    let setup = inspection.setup.expect("seen");
    assert!((setup.view.pitch_deg.to_radians() - 0.05).abs() < 0.01, "{:?}", setup.view);

    // The file comes back as it was, and the reader sees the waves with it.
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("webcam-glass.toml");
    setup.write(&path).expect("written");
    let back = meniscus_service::setup::Setup::read(&path).expect("read");
    assert_eq!(back, setup);
    let lens = back.lens.expect("a webcam's");
    let config = Config::new(back.settings(lens.optics())).expect("sound");
    let mut session = connect(Rendered::new(USUAL, 610.0, place, Troubles::default()));
    let seen = read(&mut session, lens, config, SHOWN / 2);
    let errors = errors(&seen.observations);
    println!("3 mm, 2 mm and 1 % wrong: {errors:.3?}");
    assert!(errors.heights_rms_mm < 1.0 && errors.points > 0.97 && errors.inside > 0.9, "{errors:?}");
}

#[test]
fn a_lens_or_a_distance_that_does_not_fit_the_glass_is_refused() {
    let (place, right) = by_ruler();
    let missed = |stated: StatedCamera| {
        let (inspection, _) = looked_at(place, 610.0, stated);
        let missed = inspection.findings.iter().filter(|finding| finding.check.missed());
        let missed: Vec<String> = missed.map(|f| format!("{}: {}", f.check.name, f.remedy)).collect();
        missed.join("\n")
    };
    let wrong_lens = missed(StatedCamera { lens: lens_of(USUAL, 700.0), ..right });
    assert!(
        wrong_lens.contains("radius_seen_mm: the sides of the liquid do not fit to the stated lens"),
        "{wrong_lens}"
    );
    let far = StatedPlace { wall_m: 0.430, ..right.place };
    let wrong_distance = missed(StatedCamera { place: far, ..right });
    assert!(wrong_distance.contains("radius_seen_mm"), "{wrong_distance}");
    let above = StatedPlace { height_m: 0.090, ..right.place };
    let wrong_height = missed(StatedCamera { place: above, ..right });
    assert!(wrong_height.contains("camera_height_mm"), "{wrong_height}");
}
