//! The depth filters against frames that the reference library has filtered, bit for bit.
//!
//! The frames lie in `fixtures/depth-filters`, made from synthetic images by the script beside them: all filters,
//! each with its defaults and with the ends of its settings.

use meniscus::depth_filters::{HoleFilling, LANES, Spatial, SpatialDisparity, fill_holes};
use meniscus_virtual::camera_study::golden::{Golden, folder};

/// Cases that `fixtures/depth-filters/make.py` writes.
const CASES: usize = 56;

#[test]
fn every_filtered_frame_is_the_librarys() {
    let golden = Golden::open(&folder()).expect("the committed manifest");
    let compared = golden.compare().expect("the committed frames");
    let unequal: Vec<_> = compared.iter().filter(|case| case.different > 0).collect();
    assert!(unequal.is_empty(), "{unequal:?}");
    assert_eq!(compared.len(), CASES);
    for filter in
        ["hole_filling", "spatial", "spatial_disparity", "disparity", "decimation", "temporal", "threshold"]
    {
        let of = |case: &str| case[3..].rsplit_once('_').is_some_and(|(name, _)| name == filter);
        assert!(compared.iter().any(|compared| of(&compared.case)), "no case of {filter}");
    }
}

/// The plain form of the spatial filter, pixel by pixel as its description says it, for the settings that
/// the library's frames do not cover.
fn spatial_by_the_book(settings: Spatial, image: &mut [u16], width: usize) {
    let (a, b) = (settings.alpha, 1.0 - settings.alpha);
    let mix = |c: u16, p: u16| (f32::from(c) * a + f32::from(p) * b + 0.5) as u16;
    let radius = [0, 2, 4, 8, 16, 255][usize::from(settings.holes)];
    let height = image.len() / width;
    for _ in 0..settings.iterations {
        for row in image.chunks_exact_mut(width) {
            let right: Vec<(usize, usize, u16)> = (1..width - 1).map(|x| (x, x - 1, 0)).collect();
            let left: Vec<_> = (0..width - 1).rev().map(|x| (x, x + 1, 1)).collect();
            for sweep in [right, left] {
                let mut run = 0;
                for (x, before, hole) in sweep {
                    let (c, p) = (row[x], row[before]);
                    if p > 0 && c > hole {
                        run = 0;
                        if c.abs_diff(p) <= settings.delta {
                            row[x] = mix(c, p);
                        }
                    } else if p > 0 && radius > 0 {
                        run += 1;
                        if run < radius {
                            row[x] = p;
                        }
                    }
                }
            }
        }
        for y in 1..height {
            for x in 0..width {
                let (c, p) = (image[y * width + x], image[(y - 1) * width + x]);
                if c.abs_diff(p) < settings.delta {
                    image[y * width + x] = mix(c, p);
                }
            }
        }
        for y in (0..height - 1).rev() {
            for x in 0..width {
                let (c, p) = (image[y * width + x], image[(y + 1) * width + x]);
                if c > 0 && p > 0 && c.abs_diff(p) < settings.delta {
                    image[y * width + x] = mix(c, p);
                }
            }
        }
    }
}

/// Steps, noise, holes and values near zero; a width and a height that are no multiple of the lanes.
fn rough(width: usize, height: usize, seed: u64) -> Vec<u16> {
    let mut random = seed;
    let mut draw = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize
    };
    (0..width * height)
        .map(|at| match draw() % 8 {
            0 => 0,
            1 => (draw() % 30) as u16,
            2 => u16::MAX - (draw() % 3) as u16,
            _ => (400 + 300 * ((at % width) / 9 % 3) + draw() % 25) as u16,
        })
        .collect()
}

#[test]
fn rows_side_by_side_are_rows_one_by_one() {
    let (width, height) = (45, 37);
    let mut room = vec![[0; LANES]; width];
    for (holes, alpha, delta) in
        [(0, 0.5, 20), (1, 0.3, 8), (3, 0.5, 50), (5, 0.77, 1), (0, 0.6, 20), (4, 0.25, 31)]
    {
        let settings = Spatial { alpha, delta, iterations: 3, holes };
        let mut image = rough(width, height, u64::from(holes) + 7);
        let mut wanted = image.clone();
        settings.apply(&mut image, width, &mut room).expect("sizes fit");
        spatial_by_the_book(settings, &mut wanted, width);
        assert!(image == wanted, "{settings:?}");
    }
}

#[test]
fn disparity_holes_are_filled_from_both_sides_and_from_the_next_row() {
    let settings = SpatialDisparity { iterations: 0, holes: 1, ..SpatialDisparity::default() };
    let mut image = [0.0, 0.0, 3.0, 0.0, 0.0, 7.0, 0.0, 0.0, 0.0, 0.0];
    settings.apply(&mut image, 5, &mut [[0.0; LANES]; 5]).expect("sizes fit");
    // A radius of 2 fills one pixel a direction; the end of row 0 takes the start of row 1, and the very
    // last pixel has nothing behind it.
    assert_eq!(image, [0.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 0.0, 0.0, 0.0]);
}

#[test]
fn buffers_of_a_wrong_size_are_named_and_nothing_is_changed() {
    let mut image = rough(20, 3, 1);
    let before = image.clone();
    let error = Spatial::default().apply(&mut image, 20, &mut [[0; LANES]; 19]).expect_err("too small");
    assert_eq!(error.to_string(), "the room has 19 elements, 20 are needed");
    assert!(fill_holes(&mut image, 21, HoleFilling::Left).is_err() && image == before);
    assert!(Spatial::default().apply(&mut image, 0, &mut []).is_err());
}
