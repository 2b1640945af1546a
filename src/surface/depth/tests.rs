//! Comparisons with the wall on depth images of exact geometry, counted and computed by hand.
#![allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]

extern crate std;

mod placing;

use super::*;
use crate::surface::edge_points::Move;
use crate::surface::settings::Settings;
use crate::surface::test_scene::{Images, ROOM_M, Scene};

/// Column of the axis, and a row of an edge in the middle of the glass.
const AXIS: usize = 320;
const EDGE: usize = 200;
/// Columns around the glass.
const ALL: core::ops::Range<usize> = 240..400;

const LIMITS: Limits = Limits { seen_m: 0.0, tolerance_m: 0.004, behind_m: 0.005, background_m: None };

fn point(column: usize, row: f32) -> EdgePoint {
    EdgePoint { column, row, own_px2: 0.0, moved: Move::default() }
}

/// An endless cylinder, whose depth image shows the wall at every row.
struct Wallpaper {
    scene: Scene,
    config: Config,
    images: Images,
}

impl Wallpaper {
    fn new(settings: Settings) -> Self {
        Self::of(Scene::of(settings))
    }

    fn of(scene: Scene) -> Self {
        let mut images = scene.images();
        images.fill(ALL, 0..480, |column, row| wall(&scene, column, row));
        Self { scene, config: scene.config(), images }
    }

    /// Moves the wall in a rectangle by `m`.
    fn shift(&mut self, columns: core::ops::Range<usize>, rows: core::ops::Range<usize>, m: f64) {
        let scene = self.scene;
        self.images.fill(columns, rows, |column, row| wall(&scene, column, row) + m);
    }

    fn hole(&mut self, columns: core::ops::Range<usize>, rows: core::ops::Range<usize>) {
        self.images.fill(columns, rows, |_, _| 0.0);
    }

    fn look(&self) -> Look<'_> {
        let apart = self.scene.settings.depth_lens_m;
        let axis_m = self.scene.axis_m as f32;
        Look {
            config: &self.config,
            depth: self.images.lent(0).0,
            axis_m,
            depth_axis_m: axis_m - apart[0],
            apart,
        }
    }
}

fn wall(scene: &Scene, column: usize, row: usize) -> f64 {
    scene.hit(scene.settings.depth_lens_m, column as f64, row as f64).map_or(ROOM_M, |hit| hit.depth_m)
}

/// The wall itself has no residual, whatever the pitch and the lens; 3 mm behind it the residual is 3 mm, to a unit of the image.
#[test]
fn the_wall_is_flat_in_residuals() {
    let pitched = Settings { camera_pitch_rad: 0.06, ..Settings::default() };
    let apart = Settings { depth_lens_m: [0.015, -0.002, 0.004], ..pitched };
    for settings in [Settings::default(), pitched, apart] {
        let mut paper = Wallpaper::new(settings);
        for (column, row) in [(300, 150), (320, 200), (345, 260)] {
            for m in [0.0, 0.003] {
                paper.shift(ALL, 0..480, m);
                let seen = paper.look().window(column, row).expect("no hole");
                assert!((f64::from(seen) - m).abs() < 1e-4, "{settings:?} {column} {row}: {seen} for {m}");
            }
        }
    }
}

/// A window holds five columns and six rows, and no more.
#[test]
fn a_window_is_the_median_of_thirty_pixels() {
    let columns = AXIS - 2..AXIS + 3;
    let mut paper = Wallpaper::new(Settings::default());
    paper.hole(columns.clone(), EDGE..EDGE + 6);
    assert_eq!(paper.look().window(AXIS, EDGE), None, "all around it is no part of it");
    paper.hole(ALL, 0..480);
    paper.shift(columns.start..columns.start + 1, EDGE..EDGE + 3, 0.0);
    paper.shift(columns.end - 1..columns.end, EDGE + 4..EDGE + 6, 0.0);
    assert_eq!(paper.look().window(AXIS, EDGE), None, "five pixels are a hole");
    paper.shift(columns.end - 1..columns.end, EDGE + 3..EDGE + 4, 0.0);
    assert!(paper.look().window(AXIS, EDGE).expect("six are none").abs() < 1e-4);
    // Thirteen pixels show one thing and seventeen another, which come later.
    paper.shift(columns.clone(), EDGE..EDGE + 6, 0.003);
    paper.shift(columns.clone(), EDGE..EDGE + 2, 0.001);
    paper.shift(columns.start..columns.start + 3, EDGE + 2..EDGE + 3, 0.001);
    let seen = paper.look().window(AXIS, EDGE).expect("no hole");
    assert!((seen - 0.003).abs() < 1e-4, "{seen}");
    assert_eq!(paper.look().window(AXIS, 478), None, "beyond the last row there is nothing");
}

/// Below the edge lie the rows 2 to 7 and, if these are too far, 8 to 13; above it the rows 8 to 3.
#[test]
fn the_windows_around_an_edge_tell_what_it_is() {
    let judge = |paint: &dyn Fn(&mut Wallpaper), measured: bool| {
        let mut paper = Wallpaper::new(Settings::default());
        paint(&mut paper);
        paper.look().judge(point(AXIS, EDGE as f32 + 0.4), LIMITS, measured)
    };
    let (near, far) = (-0.006, 0.006);
    let (first, second, above) = (EDGE + 2..EDGE + 8, EDGE + 8..EDGE + 14, EDGE - 8..EDGE - 2);
    assert_eq!(judge(&|_| {}, true), Verdict::Wall);
    assert_eq!(judge(&|_| {}, false), Verdict::Wall);
    assert_eq!(judge(&|p| p.shift(ALL, first.clone(), near), true), Verdict::NotTheWall);
    assert_eq!(judge(&|p| p.shift(ALL, first.clone(), 0.5 * near), true), Verdict::Wall);
    assert_eq!(judge(&|p| p.shift(ALL, first.clone(), far), true), Verdict::Wall, "the next one disagrees");
    let both = |p: &mut Wallpaper| p.shift(ALL, first.start..second.end, far);
    assert_eq!(judge(&both, true), Verdict::NotTheWall);
    assert_eq!(judge(&|p| p.shift(ALL, second.clone(), near), true), Verdict::Wall, "not asked");
    assert_eq!(judge(&|p| p.hole(ALL, first.clone()), true), Verdict::Hole { kept: true });
    assert_eq!(judge(&|p| p.hole(ALL, first.clone()), false), Verdict::Hole { kept: false });
    assert_eq!(judge(&|p| p.shift(ALL, above.clone(), near), true), Verdict::Covered);
    assert_eq!(judge(&|p| p.shift(ALL, above.clone(), 0.5 * near), true), Verdict::Wall);
    assert_eq!(judge(&|p| p.shift(ALL, above.clone(), far), true), Verdict::Wall, "a room behind");
    assert_eq!(judge(&|p| p.shift(ALL, 0..EDGE - 8, near), true), Verdict::Wall, "farther above");
    assert_eq!(judge(&|p| p.shift(ALL, EDGE - 2..EDGE + 2, near), true), Verdict::Wall, "the border itself");
    let hole_below_cover = |p: &mut Wallpaper| {
        p.hole(ALL, first.clone());
        p.shift(ALL, above.clone(), near);
    };
    assert_eq!(judge(&hole_below_cover, true), Verdict::Covered);
    // The camera may stand elsewhere than stated: residuals count from the wall that was seen.
    let mut paper = Wallpaper::new(Settings::default());
    paper.shift(ALL, 0..480, 0.008);
    let limits = Limits { seen_m: 0.008, ..LIMITS };
    assert_eq!(paper.look().judge(point(AXIS, EDGE as f32), limits, true), Verdict::Wall);
    assert_eq!(paper.look().judge(point(AXIS, EDGE as f32), LIMITS, true), Verdict::NotTheWall);
}

/// Residuals of rows below the edge, in mm from the first; what is behind meets the wall where the line through the last two does.
fn behind(column: usize, residuals_mm: &[f64], limits: Limits) -> f32 {
    let mut paper = Wallpaper::new(Settings::default());
    for (k, mm) in residuals_mm.iter().enumerate() {
        paper.shift(column..column + 1, EDGE + 1 + k..EDGE + 2 + k, 1e-3 * mm);
    }
    paper.look().rows_behind(point(column, EDGE as f32), limits)
}

#[test]
fn liquid_behind_is_followed_down_to_where_it_meets_the_wall() {
    let near = |found: f32, due: f32| assert!((found - due).abs() < 0.1, "{found} for {due}");
    near(behind(AXIS, &[], LIMITS), 0.0);
    // Falling by 4 mm a row from 24 mm in row 1, it is at zero in row 7: two rows below the 8 mm of row 5.
    near(behind(AXIS, &[24.0, 20.0, 16.0, 12.0, 8.0], LIMITS), 7.0);
    near(behind(AXIS, &[24.0, 20.0, 16.0, 12.0, 8.0, 4.0], LIMITS), 7.0);
    // The same with a row in which nothing is known: 12 mm in two rows.
    near(behind(AXIS, &[30.0, 900.0, 18.0, 900.0, 6.0], LIMITS), 6.0);
    // No fall, or too slow a one: half a row, or two and a half.
    near(behind(AXIS, &[10.0, 10.0, 10.0], LIMITS), 3.5);
    near(behind(AXIS, &[10.0], LIMITS), 1.5);
    near(behind(AXIS, &[11.0, 10.0, 9.0], LIMITS), 5.5);
    near(behind(AXIS, &[40.0, 6.0], LIMITS), 2.5);
    // Below a row of the wall nothing counts, nor does what is hardly behind it.
    near(behind(AXIS, &[0.0, 20.0, 10.0], LIMITS), 0.0);
    near(behind(AXIS, &[4.5, 4.5], LIMITS), 0.0);
    near(behind(AXIS, &[12.0; 30], LIMITS), 20.5);
    let moved = Limits { seen_m: 0.008, ..LIMITS };
    near(behind(AXIS, &[32.0, 28.0, 24.0, 20.0, 16.0], moved), 7.0);
}

/// The edge was moved down by six rows; of the rows above it, from the lowest up, this is behind the wall, mm.
#[test]
fn a_move_is_certain_where_most_of_its_rows_show_liquid_behind() {
    let confirms = |residuals_mm: &[f64]| {
        let mut paper = Wallpaper::new(Settings::default());
        for (k, mm) in residuals_mm.iter().enumerate() {
            paper.shift(AXIS..AXIS + 1, EDGE - 1 - k..EDGE - k, 1e-3 * mm);
        }
        let moved = Move { rows: 6.4, faint: true, ..Move::default() };
        paper.look().confirms(EdgePoint { moved, ..point(AXIS, EDGE as f32 + 0.3) }, LIMITS)
    };
    assert!(confirms(&[8.0, 19.0, 28.0, 34.0, 40.0, 45.0]));
    assert!(confirms(&[0.0, 0.0, 19.0, 28.0, 34.0, 40.0]), "a border two rows too high");
    assert!(!confirms(&[0.0, 0.0, 0.0, 28.0, 34.0, 40.0]), "half of them");
    assert!(!confirms(&[]), "the wall alone");
    assert!(!confirms(&[300.0; 6]), "the room");
    assert!(!confirms(&[0.0, 0.0, 0.0, 0.0, 30.0, 300.0]), "a pixel between wall and room");
    assert!(!confirms(&[8.0, 19.0, 28.0]), "rows of which three of six are the wall");
}

/// Liquid stands within the glass, 70 mm deep at its axis and 2 sqrt(35^2 - x^2) beside it, and nearer than 0.8 of the distance to
/// the room behind.
#[test]
fn what_is_behind_the_glass_is_not_liquid() {
    assert!(behind(AXIS, &[66.0, 66.0], LIMITS) > 0.0);
    assert_eq!(behind(AXIS, &[74.0, 74.0], LIMITS), 0.0);
    // Column 345 looks 25.5 px to the right, x = 26.6 mm at the distance of the axis: a chord of 45.5 mm.
    assert!(behind(345, &[43.0, 43.0], LIMITS) > 0.0);
    assert_eq!(behind(345, &[48.0, 48.0], LIMITS), 0.0);
    // Of a glass 15 mm to the right that column is 11.6 mm from the axis: 66 mm.
    let mut aside = Wallpaper::of(Scene { axis_m: 0.015, ..Scene::of(Settings::default()) });
    for (m, behind) in [(0.063, true), (0.069, false)] {
        aside.shift(345..346, EDGE + 1..EDGE + 3, m);
        assert_eq!(aside.look().rows_behind(point(345, EDGE as f32), LIMITS) > 0.0, behind, "{m}");
    }
    let room = |m: f32| Limits { background_m: Some(m), ..LIMITS };
    assert!(behind(AXIS, &[38.0, 38.0], room(0.05)) > 0.0);
    assert_eq!(behind(AXIS, &[42.0, 42.0], room(0.05)), 0.0);
    assert_eq!(behind(AXIS, &[74.0, 74.0], room(0.5)), 0.0);
}

/// The room is looked at from row 14 to row 9 above the edge.
#[test]
fn the_background_is_the_median_distance_of_what_is_above_the_edge() {
    let edge: Edge = (300..340).map(|column| point(column, EDGE as f32 + 0.5)).collect();
    let mut paper = Wallpaper::new(Settings::default());
    paper.shift(ALL, EDGE - 14..EDGE - 8, 0.2);
    let room = paper.look().background(&edge, 0.05).expect("a room");
    assert!((room - 0.15).abs() < 1e-4, "{room}");
    paper.shift(ALL, EDGE - 14..EDGE - 8, 0.04);
    assert_eq!(paper.look().background(&edge, 0.05), None, "nothing is behind");
    paper.hole(ALL, EDGE - 14..EDGE - 8);
    assert_eq!(paper.look().background(&edge, 0.05), None, "no depth");
    // A third of the columns that are asked show something nearer than the others.
    paper.shift(ALL, EDGE - 14..EDGE - 8, 0.2);
    paper.shift(300..312, EDGE - 14..EDGE - 8, 0.1);
    let room = paper.look().background(&edge, 0.05).expect("a room");
    assert!((room - 0.15).abs() < 1e-4, "{room}");
}

/// A wall point that the outline's lens sees in one pixel, projected into the depth lens.
#[test]
fn a_pixel_of_the_outline_finds_its_wall_in_the_depth_image() {
    let settings = Settings { depth_lens_m: [0.05, 0.02, -0.01], ..Settings::default() };
    let paper = Wallpaper::new(settings);
    let lens = settings.intrinsics;
    for (column, row) in [(300, 150), (320, 200), (345, 260)] {
        let hit = paper.scene.hit([0.0; 3], column as f64, row as f64).expect("the wall");
        let [right, down, forward] = settings.depth_lens_m.map(f64::from);
        let (x, below, z) = (hit.x_m, f64::from(settings.camera_height_m) - hit.z_m, hit.depth_m);
        let u = f64::from(lens.ppx) + f64::from(lens.fx) * (x - right) / (z - forward);
        let v = f64::from(lens.ppy) + f64::from(lens.fy) * (below - down) / (z - forward);
        let found = paper.look().in_depth(column, row);
        assert_eq!(found, Some((u.round() as usize, v.round() as usize)), "{column} {row}");
    }
    assert_eq!(paper.look().in_depth(20, 200), None, "beside the glass");
    assert_eq!(paper.look().in_depth(320, 10), None, "above the depth image");
    // A glass at the left border of the outline is not in the depth image.
    let mut left = Wallpaper::new(settings);
    left.scene.axis_m = -0.3;
    assert_eq!(left.look().in_depth(30, 200), None);
    let one_lens = Wallpaper::new(Settings::default());
    assert_eq!(one_lens.look().in_depth(20, 10), Some((20, 10)));
}
