//! The whole way on images of exact geometry, and each refusal just on either side of its limit.

use super::*;
use crate::surface::settings::Settings;
use crate::surface::test_scene::{Images, Scene, TONES};
use crate::surface::{POINTS, profile_abscissa};

type Outcome = Result<SurfaceProfile, ExtractionError>;

fn standard() -> Scene {
    Scene::of(Settings::default())
}

fn see(scene: &Scene, images: &Images, state: &mut ExtractionState) -> Outcome {
    let (depth, outline) = images.lent(7);
    extract(&scene.config(), state, depth, outline)
}

fn seen(scene: &Scene, images: &Images) -> Outcome {
    see(scene, images, &mut ExtractionState::new())
}

/// Level, inclined and curved surfaces, of a glass that stands beside its line and farther than stated, come back to a third of a
/// millimetre: a third of a pixel.
#[test]
fn a_known_surface_is_read_back() {
    let shapes: [fn(f64) -> f64; 3] = [|_| 0.07, |x| 0.07 + 0.2 * x, |x| 0.066 + 6.0 * x * x];
    for (surface, farther_m) in shapes.into_iter().zip([0.0, 0.005, -0.004]) {
        let scene = Scene { axis_m: 0.008, farther_m, surface, ..standard() };
        let mut state = ExtractionState::new();
        let profile = see(&scene, &scene.images(), &mut state).expect("a profile");
        for point in 0..POINTS {
            let due = surface(0.035 * profile_abscissa(point));
            let height = f64::from(profile.height_m[point]);
            assert!(!profile.valid[point] || (height - due).abs() < 3e-4, "{point}: {height} for {due}");
        }
        assert!(profile.valid.iter().filter(|valid| **valid).count() >= 19);
        // Its sides tell in which direction it stands, and that is taken at the stated distance.
        let axis_m = f64::from(profile.glass_x_m.expect("its sides"));
        assert!((axis_m - 0.008 * 0.4 / (0.4 + farther_m)).abs() < 1e-4, "{axis_m}");
        assert_eq!((profile.sequence, state.tally()), (7, Tally { profiles: 1, ..Tally::default() }));
        let offset_m = f64::from(state.wall_offset_m().expect("measured"));
        assert!((offset_m - farther_m).abs() < 3e-4, "{offset_m} for {farther_m}");
    }
}

/// Without a depth image the wall is where the settings have it: a glass 5 mm farther, seen from 40 mm below its surface, seems lower by
/// 40 mm x 5 / 365.
#[test]
fn an_outline_alone_is_read_at_the_stated_distance() {
    for (farther_m, lower_m) in [(0.0, 0.0), (0.005, 0.04 * 5.0 / 370.0)] {
        let scene = Scene { farther_m, ..standard() };
        let images = scene.images();
        let mut state = ExtractionState::new();
        let profile = extract_outline(&scene.config(), &mut state, images.lent(0).1).expect("a profile");
        let height = f64::from(profile.height_m[POINTS / 2]);
        assert!((height - (0.07 - lower_m)).abs() < 2e-4, "{height}");
        assert_eq!((state.wall_offset_m(), state.tally().profiles), (Some(0.0), 1));
    }
}

/// The glass is looked for around its last position, and everywhere once it is lost.
#[test]
fn the_region_follows_the_glass_until_it_is_lost() {
    let scene = Scene { axis_m: 0.02, ..standard() };
    let (config, images) = (scene.config(), scene.images());
    let mut state = ExtractionState::new();
    let wide = state.region(&config);
    assert!(wide.right - wide.left >= 2 * scene.settings.search_half_width_px);
    assert_eq!(state.wall_offset_m(), None);
    see(&scene, &images, &mut state).expect("a profile");
    let near = state.region(&config);
    let middle = (near.left + near.right) as f64 / 2.0;
    let due = 319.48 + 384.21 * 0.02 / 0.4;
    assert!((middle - due).abs() <= 1.5, "{middle} for {due}");
    assert!(near.right - near.left < wide.right - wide.left);
    let mut grey = images.clone();
    grey.outline.fill(128);
    assert_eq!(see(&scene, &grey, &mut state), Err(ExtractionError::NoContrast));
    assert_eq!(state.region(&config), wide);
    assert_eq!(state.tally(), Tally { profiles: 1, not_seen: 1, ..Tally::default() });
}

/// Each measure of each image wrong alone.
#[test]
fn an_image_of_another_size_is_refused() {
    let (scene, images) = (standard(), standard().images());
    let (depth, outline) = images.lent(0);
    let config = scene.config();
    let refused = |depth, outline| {
        assert_eq!(
            extract(&config, &mut ExtractionState::new(), depth, outline),
            Err(ExtractionError::WrongSize)
        );
    };
    refused(DepthFrame { width: 639, ..depth }, outline);
    refused(DepthFrame { height: 479, ..depth }, outline);
    refused(DepthFrame { bytes: &depth.bytes[2..], ..depth }, outline);
    refused(depth, OutlineFrame { width: 639, ..outline });
    refused(depth, OutlineFrame { height: 479, ..outline });
    refused(depth, OutlineFrame { bytes: &outline.bytes[1..], ..outline });
}

/// A glass that was last seen beside the image, and a camera so high that the glass lies below its image.
#[test]
fn a_glass_outside_of_the_image_is_refused() {
    let (scene, images) = (standard(), standard().images());
    let mut state = ExtractionState { axis_m: Some(5.0), ..ExtractionState::new() };
    assert_eq!(see(&scene, &images, &mut state), Err(ExtractionError::RegionEmpty));
    let high = Scene { settings: Settings { camera_height_m: 1.0, ..Settings::default() }, ..scene };
    assert_eq!(seen(&high, &images), Err(ExtractionError::RegionEmpty));
}

#[test]
fn the_contrast_has_to_reach_the_setting() {
    let (images, contrast) = (standard().images(), f32::from(TONES.1 - TONES.0));
    let with = |least_contrast: f32| {
        let settings = Settings { least_contrast, ..Settings::default() };
        seen(&Scene::of(settings), &images)
    };
    assert!(with(0.95 * contrast).is_ok());
    assert_eq!(with(1.05 * contrast), Err(ExtractionError::NoContrast));
}

/// A surface that fades into the room over 40 rows has no edge: within an edge's few rows it changes by less than half of the contrast.
#[test]
fn a_surface_that_fades_away_has_no_edge() {
    let (scene, mut images) = (standard(), standard().images());
    for row in 174..214 {
        let grey = f64::from(TONES.1) - f64::from(TONES.1 - TONES.0) * f64::from(row - 174) / 40.0;
        for column in 290..350 {
            images.outline[row as usize * 640 + column] = grey as u8;
        }
    }
    assert!(seen(&scene, &images).is_err());
}

/// A silhouette up to 4.5 mm wider than the inner glass is that of its wall; a wider one is another glass, unless its wall was stated.
#[test]
fn a_glass_that_is_wider_than_any_wall_is_refused() {
    let with = |wider_m: f64, wall_m: Option<f32>| {
        let scene = Scene::of(Settings { wall_m, ..Settings::default() });
        let scene = Scene { radius_m: 0.035 + wider_m, ..scene };
        seen(&scene, &scene.images()).map(|_| ())
    };
    assert_eq!(with(0.004, None), Ok(()));
    assert_eq!(with(0.0052, None), Err(ExtractionError::GlassNotFound));
    assert_eq!(with(0.0052, Some(0.0052)), Ok(()));
}

/// Columns whose liquid reaches up to the top of the image have no edge. Twenty others are enough, nineteen are not; and the same
/// of the points that the depth image leaves.
#[test]
fn a_profile_needs_twenty_columns() {
    let scene = standard();
    let with = |free: usize| {
        let (mut traced, mut placed) = (scene.images(), scene.images());
        for column in (280..360).filter(|column| !(310..310 + free).contains(column)) {
            (0..200).for_each(|row| traced.outline[row * 640 + column] = TONES.0);
            // A hand's breadth before the glass.
            placed.fill(column..column + 1, 194..212, |_, _| 0.3);
        }
        [seen(&scene, &traced).map(|_| ()), seen(&scene, &placed).map(|_| ())]
    };
    assert_eq!(with(20), [Ok(()), Ok(())]);
    assert_eq!(with(19), [Err(ExtractionError::TooFewColumns); 2]);
}

/// A room that is cut off at white beside half of the edge or more is booked.
#[test]
fn an_edge_beside_white_is_booked_from_half_of_it_on() {
    let scene = standard();
    let booked = |columns: core::ops::Range<usize>| {
        let mut images = scene.images();
        for row in 0..200 {
            for column in columns.clone() {
                let grey = &mut images.outline[row * 640 + column];
                *grey = if *grey == TONES.1 { 255 } else { *grey };
            }
        }
        let mut state = ExtractionState::new();
        see(&scene, &images, &mut state).expect("a profile");
        state.tally().saturated
    };
    assert_eq!([booked(0..1), booked(280..310), booked(280..330), booked(280..360)], [0, 0, 1, 1]);
}
