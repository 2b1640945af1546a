//! A whole edge on the wall: the camera's distance, what is dropped, and where the points come to lie.

use super::{ALL, AXIS, point, wall};
use crate::surface::config::Config;
use crate::surface::depth::place;
use crate::surface::edge_points::{Edge, Samples};
use crate::surface::outcome::{ExtractionError, Tally};
use crate::surface::refraction::GlassWall;
use crate::surface::settings::Settings;
use crate::surface::test_scene::{Images, Scene};
use crate::surface::wall_sample::{Glass, Wall};
use core::ops::Range;

/// Height of the flat surface, m.
const HEIGHT_M: f64 = 0.07;

/// Columns whose edge is placed: within the silhouette.
const COLUMNS: Range<usize> = 292..348;

/// Rows below the edge of the flat surface, which lies at row 194.2 on the axis and two rows lower at the sides.
const BELOW: Range<usize> = 195..214;

/// A flat liquid, its depth image, and the edge where the geometry has it.
struct Flat {
    scene: Scene,
    images: Images,
    edge: Edge,
}

/// Outcome of [`place`].
struct Placed {
    wall: Result<Wall, ExtractionError>,
    samples: Samples,
    tally: Tally,
}

impl Flat {
    fn new(scene: Scene) -> Self {
        let row = |column| scene.row_of(column, HEIGHT_M).expect("within the silhouette") as f32;
        Self {
            scene,
            images: scene.images(),
            edge: COLUMNS.map(|column| point(column, row(column))).collect(),
        }
    }

    fn standard() -> Self {
        Self::new(Scene::of(Settings::default()))
    }

    /// Moves the wall in a rectangle by `m`.
    fn shift(&mut self, columns: Range<usize>, rows: Range<usize>, m: f64) {
        let scene = self.scene;
        self.images.fill(columns, rows, |column, row| wall(&scene, column, row) + m);
    }

    /// Stripes of five columns, nearer, in their place and farther in turn: two of three are off by `m`.
    fn scatter(&mut self, rows: Range<usize>, m: f64) {
        for (k, column) in (280..360).step_by(5).enumerate() {
            self.shift(column..column + 5, rows.clone(), [-m, 0.0, m][k % 3]);
        }
    }

    fn hole(&mut self, columns: Range<usize>, rows: Range<usize>) {
        self.images.fill(columns, rows, |_, _| 0.0);
    }

    fn placed(&self) -> Placed {
        let config = Config::new(self.scene.settings).expect("sound");
        let wall = GlassWall { thickness_m: self.scene.settings.wall_m.unwrap_or(0.0) };
        let glass = Glass { axis_m: self.scene.axis_m as f32, wall };
        let (mut samples, mut tally) = (Samples::new(), Tally::default());
        let wall = place(&config, self.images.lent(0).0, glass, &self.edge, &mut samples, &mut tally);
        Placed { wall, samples, tally }
    }

    /// Distance of the wall beyond the stated one, m.
    fn offset(&self) -> f64 {
        f64::from(self.placed().wall.expect("a wall").offset_m)
    }

    /// Points that were dropped as not of the wall, as covered, and in holes; and those moved down.
    fn counts(&self) -> [u32; 4] {
        let Tally { not_the_wall, covered, holes, behind, .. } = self.placed().tally;
        [not_the_wall, covered, holes, behind]
    }
}

#[track_caller]
fn near(value: f64, due: f64, slack: f64) {
    assert!((value - due).abs() <= slack, "{value} for {due}");
}

#[test]
fn a_flat_surface_is_placed_flat_wherever_the_camera_stands() {
    let pitched = Settings { camera_pitch_rad: 0.05, ..Settings::default() };
    let colour = Settings { depth_lens_m: [0.015, 0.0, 0.004], ..Settings::default() };
    for settings in [Settings::default(), pitched, colour] {
        for (axis_m, farther_m) in [(0.0, 0.0), (0.004, 0.005), (-0.003, -0.006)] {
            let placed = Flat::new(Scene { axis_m, farther_m, ..Scene::of(settings) }).placed();
            let wall = placed.wall.expect("a wall");
            near(f64::from(wall.offset_m), farther_m, 3e-4);
            assert!(wall.scatter_m < 2e-4, "{wall:?}");
            assert_eq!(placed.tally, Tally::default());
            assert_eq!(placed.samples.len(), COLUMNS.len());
            for sample in &placed.samples {
                near(f64::from(sample.z_m), HEIGHT_M, 2e-4);
                assert_eq!((sample.lowered_m, sample.own_m2), (0.0, 0.0));
            }
        }
    }
}

/// The camera's distance is accepted within 15 mm, and stereo sees the middle of a wall of 3 mm 1 mm too near.
#[test]
fn the_distance_of_the_wall_has_a_limit_and_counts_the_glass() {
    for (farther_m, fits) in [(0.014, true), (0.016, false), (-0.014, true), (-0.016, false)] {
        let placed = Flat::new(Scene { farther_m, ..Scene::of(Settings::default()) }).placed();
        assert_eq!(placed.wall.is_ok(), fits, "{farther_m}");
        if let Err(error) = placed.wall {
            assert_eq!(error, ExtractionError::WallElsewhere);
        }
    }
    let mut empty = Flat::standard();
    empty.hole(ALL, 0..480);
    assert_eq!(empty.placed().wall, Err(ExtractionError::NoDepth));
    let mut glass = Flat::new(Scene::of(Settings { wall_m: Some(0.003), ..Settings::default() }));
    glass.shift(COLUMNS.start - 4..COLUMNS.end + 4, 194..270, -0.001);
    near(glass.offset(), 0.0, 1.5e-4);
}

/// Twenty rows below the edge, there where the wall faces the camera: within 0.2 of the silhouette's 67 px beside the axis.
#[test]
fn the_distance_is_that_of_the_front_twenty_rows_below_the_edge() {
    let mut lower = Flat::standard();
    lower.shift(ALL, 223..270, 0.010);
    near(lower.offset(), 0.0, 1e-4);
    let mut higher = Flat::standard();
    higher.shift(ALL, 150..213, 0.010);
    near(higher.offset(), 0.0, 1e-4);
    // 27 columns of the front, and more than these beside it.
    let mut sides = Flat::standard();
    sides.edge = (289..351).map(|column| point(column, 194.5)).collect();
    sides.shift(ALL, 212..222, 0.003);
    sides.shift(306..334, 212..222, 0.0);
    near(sides.offset(), 0.0, 1e-4);
    // Of seven windows at the front nothing is learned, of eight it is.
    for (columns, due) in [(319..322, 0.0), (319..323, 0.003)] {
        let mut few = Flat::standard();
        few.hole(300..340, 195..240);
        few.shift(columns, 195..240, 0.003);
        near(few.offset(), due, 1e-4);
    }
}

/// Eleven columns: a window of five belongs to what three of its columns show. Of the seven in the middle all five do.
#[test]
fn what_is_not_the_contact_line_is_dropped_and_counted() {
    let block = AXIS - 5..AXIS + 6;
    let kept = |flat: &Flat| flat.placed().samples.len();
    let mut before = Flat::standard();
    before.shift(block.clone(), BELOW, -0.02);
    assert_eq!((before.counts(), kept(&before)), ([11, 0, 0, 0], COLUMNS.len() - 11));
    let mut cover = Flat::standard();
    cover.shift(block.clone(), 180..194, -0.02);
    assert_eq!((cover.counts(), kept(&cover)), ([0, 11, 0, 0], COLUMNS.len() - 11));
    let mut hole = Flat::standard();
    hole.hole(block, BELOW);
    assert_eq!((hole.counts(), kept(&hole)), ([0, 0, 7, 0], COLUMNS.len()));
}

/// Points without a depth of their own stay if half of the points or more have a wall twenty rows below.
#[test]
fn holes_are_kept_if_half_of_the_edge_is_measured() {
    let half = COLUMNS.len() / 2;
    for (measured, kept) in [(half, COLUMNS.len()), (half - 1, 0)] {
        let mut flat = Flat::standard();
        flat.hole(ALL, 195..240);
        // The window of a column reaches two columns beside it.
        flat.shift(COLUMNS.start - 2..COLUMNS.start + measured - 2, 214..224, 0.0);
        assert_eq!((flat.counts(), flat.placed().samples.len()), ([0, 0, COLUMNS.len() as u32, 0], kept));
    }
}

/// Windows that scatter by a millimetre allow for six; a still image for four, the wildest for ten; and the glass for half as much
/// again as it is thick.
#[test]
fn the_tolerance_follows_the_scatter_and_the_glass() {
    let dropped = |thickness: f32, scatter_m: f64, off_m: f64, farther_m: f64| {
        let settings = Settings { wall_m: Some(thickness), ..Settings::default() };
        let mut flat = Flat::new(Scene { farther_m, ..Scene::of(settings) });
        flat.scatter(212..224, scatter_m);
        flat.shift(AXIS - 5..AXIS + 6, 195..209, off_m);
        flat.counts()[0] > 0
    };
    for farther_m in [0.0, 0.006] {
        assert!(!dropped(0.0, 0.0, -0.0035, farther_m) && dropped(0.0, 0.0, -0.0045, farther_m));
    }
    assert!(!dropped(0.0, 0.001, -0.0055, 0.0) && dropped(0.0, 0.001, -0.0065, 0.0));
    assert!(!dropped(0.0, 0.003, -0.0095, 0.0) && dropped(0.0, 0.003, -0.0105, 0.0));
    assert!(!dropped(0.002, 0.0, -0.0065, 0.0) && dropped(0.002, 0.0, -0.0075, 0.0));
}

/// Liquid 3 mm a row behind the wall that meets it six rows below the edge, in some columns.
fn rising(columns: Range<usize>, settings: Settings) -> Flat {
    let mut flat = Flat::new(Scene::of(settings));
    for column in columns {
        let index = column - COLUMNS.start;
        let row = flat.edge[index].row as usize;
        (1..6).for_each(|k| flat.shift(column..column + 1, row + k..row + k + 1, 0.003 * (6 - k) as f64));
        // What the room shows above the edge.
        flat.edge[index].row = row as f32;
    }
    flat
}

#[test]
fn an_edge_above_liquid_behind_comes_down_to_the_contact_line() {
    let placed = rising(COLUMNS, Settings::default()).placed();
    assert_eq!((placed.tally.behind, placed.samples.len()), (COLUMNS.len() as u32, COLUMNS.len()));
    let flat = Flat::standard();
    for (sample, point) in placed.samples.iter().zip(&flat.edge) {
        let row = f64::from(point.row.floor()) + 6.0;
        let due = flat.scene.hit([0.0; 3], point.column as f64, row).expect("the wall").z_m;
        near(f64::from(sample.z_m), due, 2e-4);
        assert!(sample.own_m2 > 0.0 && sample.lowered_m > 0.005, "{sample:?}");
    }
}

/// Three neighbours must show it; a point takes the mean of the seven around it.
#[test]
fn a_lone_column_does_not_move_the_edge() {
    assert_eq!(rising(320..322, Settings::default()).counts(), [0; 4]);
    let flat = rising(320..323, Settings::default());
    assert_eq!(flat.counts(), [0, 0, 0, 5]);
    let (placed, before) = (flat.placed(), Flat::standard());
    let at = 321 - COLUMNS.start;
    let down = f64::from(before.placed().samples[at].z_m - placed.samples[at].z_m);
    // A row is 0.95 mm at 0.365 m; the edge was put onto the row above, 0.2 of a row.
    near(down, 0.95e-3 * (18.0 / 7.0 - 0.2), 2e-4);
}

/// Residuals of a millimetre allow for eight behind; a still image for five, and the glass for half as much again as it is thick.
#[test]
fn what_counts_as_behind_follows_the_scatter_and_the_glass() {
    let moved = |thickness: f32, scatter_m: f64, behind_m: f64| {
        let settings = Settings { wall_m: Some(thickness), ..Settings::default() };
        let mut flat = Flat::new(Scene::of(settings));
        flat.scatter(213..224, scatter_m);
        flat.shift(ALL, 195..199, behind_m);
        flat.counts()[3] > 0
    };
    assert!(!moved(0.0, 0.0, 0.0045) && moved(0.0, 0.0, 0.0055));
    assert!(!moved(0.0, 0.001, 0.0075) && moved(0.0, 0.001, 0.0085));
    assert!(!moved(0.0, 0.003, 0.0115) && moved(0.0, 0.003, 0.0125));
    assert!(!moved(0.002, 0.0, 0.0075) && moved(0.002, 0.0, 0.0085));
}
