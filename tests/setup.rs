//! A glass of one's own: what was said of it against rendered images of it, the wizard's screen, and the file in use.

#[path = "support/findings.rs"]
mod findings;
#[path = "support/optional.rs"]
mod optional;
#[path = "setup/script.rs"]
mod script;
#[path = "setup/wizard.rs"]
mod wizard;

use findings::{missed, value};
use meniscus::blob::Model;
use meniscus::surface::{Config, Liquid, Optics, Settings};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags as bag;
use meniscus_bags::observe_images;
use meniscus_bags::{Calibration, Image};
use meniscus_platform::files::AlignedBytes;
use meniscus_service::setup::{Inspection, MeasuredGlass, Pair, Setup, SetupOrigin, inspect};
use meniscus_usb::camera::OutlineImage;
use meniscus_virtual::render::{Clutter, Images, Liquid as Seen, Scene, SceneSettings};
use std::fs;
use std::path::{Path, PathBuf};

/// The glass of the tests, as a person would say it.
const SAID: MeasuredGlass = MeasuredGlass::of([35.0, 70.0, 110.0]);

/// `count` pairs of a glass whose liquid stands at `height_mm` of a frame's number.
fn pairs(settings: SceneSettings, count: u64, x_m: f64, height_mm: impl Fn(u64) -> f64) -> Vec<Pair> {
    let (mut scene, mut images) = (Scene::new(settings), Images::new(&settings));
    let pair = |frame: u64| {
        let height_m = (1e-3 * height_mm(frame)) as f32;
        let liquid = Seen { glass_m: [x_m, 0.0], wall_m: &[height_m; 72], column_m: &[height_m; 194] };
        scene.render(&liquid, frame, &mut images);
        let stamp = Stamp { sequence: frame as u32, captured: Micros(16_667 * frame) };
        Pair { depth: Some(images.depth.clone()), outline: images.infrared.clone(), stamp }
    };
    (0..count).map(pair).collect()
}

fn look(pairs: &[Pair], said: MeasuredGlass) -> Inspection {
    let outline = OutlineImage::Infrared;
    let origin = SetupOrigin { outline, camera: "a rendered camera", made_by: "a test" };
    inspect(pairs, Optics::default(), said, origin)
}

/// The same glass at rest, `count` times, under `settings`.
fn at_rest(settings: SceneSettings, said: MeasuredGlass) -> Inspection {
    look(&pairs(settings, 24, 0.004, |_| 70.0), said)
}

/// A camera elsewhere than the settings' own.
fn camera(distance_m: f32, height_m: f32, pitch_deg: f32, liquid: Liquid) -> SceneSettings {
    let camera = Settings {
        camera_distance_m: distance_m,
        camera_height_m: height_m,
        camera_pitch_rad: pitch_deg.to_radians(),
        liquid,
        ..Settings::default()
    };
    SceneSettings { camera, ..SceneSettings::default() }
}

#[test]
fn the_camera_is_found_where_it_stands() {
    let table = [
        (0.40, 0.030, 0.0, Liquid::Dark),
        (0.33, 0.045, -6.0, Liquid::Dark),
        (0.52, 0.020, 5.0, Liquid::Dark),
        (0.45, 0.050, -9.0, Liquid::Bright),
    ];
    for (distance_m, height_m, pitch_deg, liquid) in table {
        let seen = at_rest(camera(distance_m, height_m, pitch_deg, liquid), SAID);
        let checks: Vec<_> = seen.findings.iter().map(|finding| &finding.check).collect();
        assert!(seen.ok(), "{distance_m} m, {pitch_deg} degrees: {:?}\n{checks:#?}", missed(&seen));
        let view = &seen.setup.as_ref().expect("a setup").view;
        println!("{distance_m} m: {view:?}, radius {:.2} mm", value(&seen, "radius_seen_mm"));
        assert!((view.distance_mm - 1e3 * f64::from(distance_m)).abs() < 3.0, "{view:?}");
        assert!((view.height_mm - 1e3 * f64::from(height_m)).abs() < 3.0, "{view:?}");
        assert!((view.pitch_deg - f64::from(pitch_deg)).abs() < 0.7, "{view:?}");
        // The sides of a bright liquid are shaded, so that it looks a little narrower.
        assert!((value(&seen, "radius_seen_mm") - 35.0).abs() < 1.0);
        assert!((value(&seen, "offset_mm") - 4.0).abs() < 1.0);
    }
}

/// A camera that is not where the settings without a setup have it: with the file the profile is the true one.
#[test]
fn the_file_brings_the_surface_to_where_it_is() {
    let elsewhere = camera(0.46, 0.042, -5.0, Liquid::Dark);
    let seen = at_rest(elsewhere, SAID);
    let path = folder("elsewhere").join("deep/glass.toml");
    seen.setup.as_ref().expect("a setup").write(&path).expect("written");
    let setup = Setup::read(&path).expect("read back");
    assert_eq!(Some(&setup), seen.setup.as_ref());
    let higher = pairs(elsewhere, 10, -0.01, |_| 73.0);
    let of = |settings| meniscus_service::setup::Rest::of(&higher, &Config::new(settings).expect("settings"));
    let with = of(setup.settings(Optics::default()));
    assert!((with.level_mm - 73.0).abs() < 0.3 && with.seen == 1.0, "{with:?}");
    let without = of(Settings::default());
    assert!(without.seen == 0.0 || (without.level_mm - 73.0).abs() > 2.0, "{without:?}");
}

#[test]
fn a_wrong_measure_is_named_with_what_to_do() {
    let glass = SceneSettings::default();
    for (said, name) in [
        (MeasuredGlass { radius_mm: 31.0, ..SAID }, "radius_seen_mm"),
        (MeasuredGlass { radius_mm: 38.0, ..SAID }, "radius_seen_mm"),
        (MeasuredGlass { fill_mm: 60.0, ..SAID }, "fill_seen_mm"),
        (MeasuredGlass { fill_mm: 79.0, ..SAID }, "fill_seen_mm"),
    ] {
        let seen = at_rest(glass, said);
        assert!(missed(&seen).contains(&name), "{said:?}: {:?}", missed(&seen));
        let remedies = seen.remedies();
        assert!(
            remedies.iter().any(|one| one.check.name == name && one.remedy.contains("measure")),
            "{remedies:?}"
        );
    }
    assert!(MeasuredGlass { fill_mm: 110.0, ..SAID }.check().is_err_and(|what| what.contains("rim")));
    assert!(
        MeasuredGlass { radius_mm: f64::NAN, ..SAID }.check().is_err_and(|what| what.contains("10 to 60"))
    );
}

#[test]
fn no_glass_a_clear_liquid_and_one_that_moves_are_distinguished() {
    let nothing = at_rest(SceneSettings { glass_present: false, ..SceneSettings::default() }, SAID);
    assert!(nothing.setup.is_none() && missed(&nothing).contains(&"liquid_seen"));
    assert!(nothing.remedies()[0].remedy.contains("before the middle of the camera"));
    assert!(look(&[], SAID).setup.is_none(), "no images at all");

    let clear = |clear| SceneSettings {
        clutter: Clutter { clear, ..Clutter::default() },
        ..SceneSettings::default()
    };
    let through = at_rest(clear(0.6), SAID);
    assert_eq!(value(&through, "opaque"), 0.0, "{:?}", missed(&through));
    assert!(
        through.remedies().iter().any(|one| one.remedy.contains("transparent")),
        "{:?}",
        through.remedies()
    );
    let water = at_rest(clear(0.97), SAID);
    assert!(water.setup.is_none() && water.remedies()[0].remedy.contains("clear in the near infrared"));

    let swinging =
        look(&pairs(SceneSettings::default(), 24, 0.0, |k| 70.0 + 2.0 * (0.5 * k as f64).sin()), SAID);
    assert!(missed(&swinging).contains(&"rest_noise_mm"), "{:?}", missed(&swinging));
}

/// Input of `correct`: one position for each frame interval, empty where the camera brought nothing.
#[test]
fn a_cameras_recording_is_read_interval_by_interval() {
    let shots = pairs(SceneSettings::default(), 16, 0.0, |_| 70.0);
    let kept = shots.into_iter().enumerate().filter(|(frame, _)| *frame != 7);
    let images = kept.flat_map(|(_, Pair { depth, outline, stamp })| {
        let stamp = Stamp { captured: Micros(stamp.captured.0 + 5_000_000), ..stamp };
        let depth = depth.expect("a camera with depth");
        [(Stream::Depth, depth), (Stream::Outline, outline)].map(|(stream, pixels)| Image {
            stream,
            stamp,
            pixels,
        })
    });
    let images: Vec<_> = images.map(Ok).collect();
    let calibration = Calibration::of(&Optics::default(), 0.05, "a rendered camera");
    let recording = bag::Recording { calibration, images: Box::new(images.into_iter()) };
    let config = Config::new(Settings::default()).expect("settings");
    let seen = observe_images(recording, config).expect("whole");
    let empty: Vec<usize> = (0..seen.len()).filter(|frame| seen[*frame].is_none()).collect();
    assert_eq!((seen.len(), empty), (16, vec![7]));
}

#[test]
fn a_setup_of_another_glass_is_refused_by_the_model() {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let header = Model::load(&bytes).expect("the shipped model").header;
    let setup = at_rest(SceneSettings::default(), SAID).setup.expect("a setup");
    let with =
        |glass: MeasuredGlass| Setup { glass, ..setup.clone() }.settings_for(&header, Optics::default());
    let near = with(MeasuredGlass::of([35.4, 69.5, 105.0])).expect("within what a person measures");
    assert!((near.radius_m, near.fill_m) == (0.035, 0.070), "the model's measures hold");
    assert!(
        (1e3 * f64::from(near.camera_height_m) - setup.view.height_mm - 0.5).abs() < 1e-3,
        "the camera moves"
    );
    let far = with(MeasuredGlass { radius_mm: 30.0, ..SAID }).expect_err("another glass");
    assert!(far.to_string().contains("radius 35.0 mm, the setup says 30.0 mm"), "{far}");
}

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("setup").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}
