//! A small study of the surface: the same scenes as `meniscus camera study`, fewer of them, of another seed.

use meniscus_data::recording::{Recording, WALL_POINTS, wall_azimuth};
use meniscus_virtual::camera_study::conditions::{Case, Condition, LOOKS};
use meniscus_virtual::camera_study::judge::{Judged, Row, judge};
use meniscus_virtual::camera_study::scenes;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

#[test]
fn heights_lie_inside_their_intervals_and_nothing_is_made_up() {
    let scenes = scenes(11, 60, || ()).expect("sound scenes");
    let of = |keep: &dyn Fn(Condition) -> bool| {
        let chosen: Vec<&Judged> = scenes.iter().filter(|judged| keep(judged.case.condition)).collect();
        Row::of("", "", &chosen)
    };
    let nominal = of(&|condition| condition == Condition::Nominal);
    let all = of(&|condition| condition != Condition::NoLiquid);
    let none = of(&|condition| condition == Condition::NoLiquid);
    println!("{}", Row::HEAD.join("  "));
    for row in [&nominal, &all, &none] {
        println!("{}", row.cells().join("  "));
    }
    assert_eq!(none.profiles, 0, "a profile without liquid");
    assert!(nominal.rms_mm <= 0.6, "{nominal:?}");
    assert!(u64::from(nominal.profiles) == nominal.frames && nominal.points_seen >= 0.97, "{nominal:?}");
    assert!(
        all.coverage >= 0.93,
        "{all:?}: of 60 scenes, whose errors belong together, a little less than of 200"
    );
    // An interval that is wide enough to hold anything would say nothing.
    assert!(all.half_mm <= 1.0, "{all:?}");
}

/// Scenes of some seeds that `keep` chooses, as the reader sees them.
fn judged(seeds: Range<u64>, scenes: usize, keep: impl Fn(&Case) -> bool) -> Vec<Judged> {
    let cases = seeds.flat_map(|seed| (0..scenes).map(move |index| Case::new(seed, index)));
    cases.filter(keep).map(|case| judge(case).expect("a sound scene")).collect()
}

/// Row of all of them, printed.
fn row(judged: &[Judged]) -> Row {
    let row = Row::of("", "", &judged.iter().collect::<Vec<_>>());
    println!("{}", row.cells().join("  "));
    row
}

/// The lower side of a finger was taken for the surface in one of five scenes, with errors of up to 50 mm.
#[test]
fn a_finger_before_the_glass_is_not_the_surface() {
    let row = row(&judged(7001..7017, 100, |case| case.condition == Condition::Finger));
    assert!(row.scenes == 160 && row.points_seen >= 0.75, "{row:?}");
    assert!(row.coverage >= 0.95, "{row:?}");
    assert!(row.worst_mm <= 6.0, "{row:?}");
}

/// Foam that is brighter than a bright liquid was taken for liquid; foam on a dark one lowered the edge beside it. These scenes were
/// used for no choice: 93 % are inside, 78 % on mayonnaise, whose tone is nearly that of foam.
#[test]
fn foam_is_not_the_liquid() {
    let judged = judged(21..25, 200, |case| case.condition == Condition::Foam);
    for (look, (name, ..)) in LOOKS.iter().enumerate() {
        let own: Vec<&Judged> = judged.iter().filter(|judged| judged.case.look == look).collect();
        println!("{}", Row::of("", *name, &own).cells().join("  "));
    }
    let row = row(&judged);
    assert!(row.scenes == 80 && row.points_seen >= 0.9, "{row:?}");
    assert!(row.coverage >= 0.91, "{row:?}");
    assert!(row.half_mm <= 1.0 && row.worst_mm <= 6.0, "{row:?}");
}

/// Moves down to a faint band were taken back in single frames, also where the depth image shows liquid behind: errors of up to 14 mm in
/// these scenes, which were used for no choice.
#[test]
fn a_distant_surface_that_shows_behind_its_contact_line_is_not_taken_for_it() {
    let distant = |case: &Case| case.distance == 2 && case.condition != Condition::NoLiquid;
    let row = row(&judged(201..206, 200, distant));
    assert!(row.scenes > 250 && row.points_seen >= 0.9, "{row:?}");
    assert!(row.coverage >= 0.95 && row.half_mm <= 1.5, "{row:?}");
    assert!(row.worst_mm <= 6.0, "{row:?}");
}

/// Points 2.2 mm from the nearest first mode are dropped as something else than the surface, so waves must be nearer.
///
/// The nearest mode is found here by another solver, over the wall that faces the camera.
#[test]
fn contact_lines_of_a_recording_lie_near_a_first_mode() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors");
    let recording = Recording::load(path.as_ref()).expect("the shipped recording");
    let front: Vec<usize> = (0..WALL_POINTS).filter(|i| wall_azimuth(*i).sin() < -0.02).collect();
    let basis = DMatrix::from_fn(front.len(), 3, |row, column| {
        let (sin, cos) = wall_azimuth(front[row]).sin_cos();
        [1.0, cos, sin][column]
    });
    let svd = basis.clone().svd(true, true);
    let (mut farthest_m, mut low_m, mut high_m) = (0.0_f64, f64::INFINITY, f64::NEG_INFINITY);
    for wall in recording.wall_m.chunks(WALL_POINTS) {
        let heights = DVector::from_iterator(front.len(), front.iter().map(|i| f64::from(wall[*i])));
        let mode = svd.solve(&heights, 1e-12).expect("both factors");
        farthest_m = farthest_m.max((&heights - &basis * mode).amax());
        (low_m, high_m) = (low_m.min(heights.min()), high_m.max(heights.max()));
    }
    println!("span {:.1} mm, farthest {:.2} mm", 1e3 * (high_m - low_m), 1e3 * farthest_m);
    assert!(high_m - low_m > 0.020, "a recording that hardly moves shows nothing");
    assert!(farthest_m < 0.0015, "{farthest_m} m");
}
