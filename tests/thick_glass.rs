//! Setup before path-traced glasses at rest, whose walls and bases are thick: `tests/fixtures/optics/still`.
//!
//! The scenes have their own renderer, and another fill and height of the camera each (`make.py` there).

#[path = "support/findings.rs"]
mod findings;

use findings::{missed, value};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus_service::setup::{Inspection, MeasuredGlass, Pair, SetupOrigin, inspect};
use meniscus_ui::terminal::{Step, Wizard};
use meniscus_usb::camera::OutlineImage;
use meniscus_virtual::camera_study::traced::degrade::{Faults, degrade};
use meniscus_virtual::camera_study::traced::set::{Kind, TracedScene, folder, read, settings};
use ratatui::crossterm::event::{KeyCode, KeyEvent};

const WIDTH: usize = 640;
/// Thickest wall of which the silhouette's radius still passes for the inner one.
const PASSES_MM: f64 = 2.0;

/// Scenes that nobody looked at while setup was written.
fn judged(kind: Kind) -> Vec<TracedScene> {
    let all = read(&folder().join("still"), "judge").expect("the repository holds the set");
    all.into_iter().filter(|scene| scene.truth.liquid == kind).collect()
}

fn pairs(scene: &TracedScene) -> Vec<Pair> {
    let pair = |frame: u64| {
        let pair = degrade(scene, WIDTH, &Faults::default(), frame);
        let stamp = Stamp { sequence: frame as u32, captured: Micros(1_000_000 + 16_667 * frame) };
        Pair { depth: Some(pair.depth), outline: pair.infrared, stamp }
    };
    (0..24).map(pair).collect()
}

fn look(scene: &TracedScene, pairs: &[Pair], said: MeasuredGlass) -> Inspection {
    let origin = SetupOrigin { outline: OutlineImage::Infrared, camera: "a path tracer", made_by: "a test" };
    inspect(pairs, settings(&scene.truth).optics(), said, origin)
}

/// Stated measures of a scene's glass, without wall and base.
fn inner(scene: &TracedScene) -> MeasuredGlass {
    MeasuredGlass::of([35.0, scene.truth.fill_mm, 110.0])
}

/// The same with them.
fn whole(scene: &TracedScene) -> MeasuredGlass {
    let truth = &scene.truth;
    MeasuredGlass { wall_mm: Some(truth.wall_mm), base_mm: Some(truth.base_mm), ..inner(scene) }
}

/// With the wall stated the camera is found where it stands; without, a thick wall is taken for another radius.
#[test]
fn a_stated_wall_brings_radius_and_distance_to_the_truth() {
    let scenes = judged(Kind::Coffee);
    assert!(scenes.len() >= 8 && scenes.iter().any(|scene| scene.truth.wall_mm > 4.0));
    for scene in &scenes {
        let (truth, pairs) = (&scene.truth, pairs(scene));
        let seen = look(scene, &pairs, whole(scene));
        let [radius_mm, distance_mm] = ["radius_seen_mm", "distance_mm"].map(|name| value(&seen, name));
        println!(
            "{}: wall {} mm, base {} mm: radius {radius_mm:.2}, distance {distance_mm:.2}, fill {:.2} of {} mm",
            truth.name,
            truth.wall_mm,
            truth.base_mm,
            value(&seen, "fill_seen_mm"),
            truth.fill_mm
        );
        assert!(seen.ok(), "{}: {:?}", truth.name, missed(&seen));
        assert!((radius_mm - 35.0).abs() < 1.0 && (distance_mm - truth.distance_mm).abs() < 1.0);
        let unstated = look(scene, &pairs, inner(scene));
        let off_mm = (value(&unstated, "distance_mm") - truth.distance_mm).abs();
        println!("  wall unstated: distance {off_mm:.2} mm off, missed {:?}", missed(&unstated));
        assert!(off_mm > (distance_mm - truth.distance_mm).abs(), "{}: {off_mm}", truth.name);
        if truth.wall_mm > 3.0 {
            assert!(missed(&unstated).contains(&"radius_seen_mm"), "{}", truth.name);
            assert!(unstated.remedies().iter().any(|one| one.remedy.contains("--wall-mm")));
        } else if truth.wall_mm < PASSES_MM {
            assert!(unstated.ok(), "{}: {:?}", truth.name, missed(&unstated));
        }
    }
}

/// The glass above a bright liquid is lit by it, and has the same sides. Of too few valid points setup may complain
/// (docs/limits.md).
#[test]
fn lit_glass_above_a_bright_liquid_is_no_liquid() {
    let scenes = judged(Kind::Milk);
    assert!(scenes.len() >= 2);
    for scene in &scenes {
        let (truth, seen) = (&scene.truth, look(scene, &pairs(scene), whole(scene)));
        let fill_mm = value(&seen, "fill_seen_mm");
        println!("{}: fill {fill_mm:.2} of {} mm, missed {:?}", truth.name, truth.fill_mm, missed(&seen));
        assert!((fill_mm - truth.fill_mm).abs() < 3.0, "{fill_mm}");
        assert!((value(&seen, "distance_mm") - truth.distance_mm).abs() < 1.0);
        assert!((value(&seen, "rest_level_mm") - truth.fill_mm).abs() < 0.3);
        assert!(missed(&seen).iter().all(|name| *name == "rest_points_valid"), "{:?}", missed(&seen));
    }
}

/// A base whose lower face mirrors the liquid, as of a camera that looks down: the dark body goes on below the inner bottom.
#[test]
fn a_base_that_shows_the_liquid_is_named_and_passes_once_it_is_stated() {
    let scene = judged(Kind::Coffee).into_iter().min_by(|a, b| a.truth.base_mm.total_cmp(&b.truth.base_mm));
    let scene = scene.expect("a scene");
    let truth = &scene.truth;
    let base_mm = 8.0;
    let row = |height_mm: f64| {
        let (away_mm, below_mm) = (truth.distance_mm - 35.0, truth.camera_height_mm - height_mm);
        (239.5 + 384.0 * below_mm / away_mm).round() as usize
    };
    let mut pairs = pairs(&scene);
    for pair in &mut pairs {
        // The base shows a row of the liquid, some way above its foot, and is bright only at its lower rim.
        let line = |height_mm: f64| pair.outline[WIDTH * row(height_mm)..][..WIDTH].to_vec();
        let (dark, bright) = (line(6.0), line(truth.fill_mm + 15.0));
        let (foot, rim) = (row(0.0).saturating_sub(2), row(-base_mm));
        for below in foot..rim + 4 {
            let shown = if below < rim { &dark } else { &bright };
            pair.outline[WIDTH * below..][..WIDTH].copy_from_slice(shown);
        }
    }
    let wall = MeasuredGlass { base_mm: None, ..whole(&scene) };
    let unstated = look(&scene, &pairs, wall);
    println!("fill seen {:.2} of {} mm", value(&unstated, "fill_seen_mm"), truth.fill_mm);
    assert!(missed(&unstated).contains(&"fill_seen_mm"), "{:?}", missed(&unstated));
    assert!(unstated.remedies().iter().any(|one| one.remedy.contains("--base-mm")));
    let stated = look(&scene, &pairs, MeasuredGlass { base_mm: Some(base_mm), ..wall });
    assert!(stated.ok(), "{:?}", missed(&stated));
    // The place of the camera comes from the upper edge, so that the base does not move it.
    let view = |seen: &Inspection| seen.setup.as_ref().map(|setup| setup.view.clone());
    assert_eq!(view(&stated), view(&unstated));
}

/// The wizard asks for wall and base, and takes an empty line for a thin one.
#[test]
fn the_wizard_asks_for_wall_and_base() {
    let mut wizard = Wizard::new("a camera".into(), Vec::new(), MeasuredGlass::of([35.0, 70.0, 110.0]));
    let press = |wizard: &mut Wizard, codes: &[KeyCode]| {
        for code in codes {
            wizard.key(KeyEvent::from(*code));
        }
    };
    press(&mut wizard, &[KeyCode::Enter, KeyCode::Enter]);
    assert_eq!(wizard.step(), Step::Measure);
    assert_eq!(wizard.said().map(|said| (said.wall_mm, said.base_mm)), Ok((None, None)));
    press(
        &mut wizard,
        &[KeyCode::Down, KeyCode::Down, KeyCode::Down, KeyCode::Char('3'), KeyCode::Char('.')],
    );
    press(&mut wizard, &[KeyCode::Char('5'), KeyCode::Down, KeyCode::Char('8')]);
    assert_eq!(wizard.said().map(|said| (said.wall_mm, said.base_mm)), Ok((Some(3.5), Some(8.0))));
    press(&mut wizard, &[KeyCode::Up, KeyCode::Char('9')]);
    assert!(wizard.said().is_err_and(|what| what.contains("wall_mm = 9 is out of range: 0 to 6")));
    press(&mut wizard, &[KeyCode::Backspace]);
    assert_eq!(wizard.said().map(|said| (said.wall_mm, said.base_mm)), Ok((None, Some(8.0))));
}
