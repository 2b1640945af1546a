//! Motions along every axis: energy books, equal slosh along x and y, a glass that turns with its room.

use super::{FINER_M, GLASS, Scratch, setup};
use meniscus_data::motion::Motion;
use meniscus_data::recording::{Lattice, Recording, WALL_POINTS};
use meniscus_sph::{Setup, record, relative_closure};
use std::path::PathBuf;

/// A short recording under `motion`.
fn short(setup: &Setup, motion: &str) -> Recording {
    let motion = Motion::parse(motion, 1.6).expect("a known motion");
    record(setup, &motion, 80, "test", |_| ()).expect("the glass is simulated")
}

#[test]
fn the_books_close_with_every_effect_and_under_every_motion() {
    let all = [
        "wall_slip=0.002",
        "surface_tension=0.5",
        "contact_line=0.02",
        "foam=0.1",
        "viscoelastic=10",
        "yield_stress=1",
        "container_tilt=0.1",
        "vertical_acceleration=1",
    ];
    // The last is the weakest slosh, of which the same grain of the particles is more.
    for (setup, motion, bound) in [
        (setup(&all), "strokes:7", 0.02),
        (setup(&[]), "carry:3", 0.02),
        (setup(&all), "tilts:3", 0.05),
        (setup(&all), "hand:3", 0.03),
    ] {
        let recording = short(&setup, motion);
        let closure = relative_closure(&recording.energy);
        let work = recording.energy.iter().map(|book| book.work).fold(0.0, f64::max);
        println!("{motion}: closure {closure}, work {work}");
        assert!(closure < bound, "{motion}: energy closes to {closure} of the slosh");
        assert!(work > 1e-5, "{motion}: the motion did only {work} J of work");
        let heat: Vec<_> = recording.energy.iter().map(|book| book.internal).collect();
        assert!(heat.last() > heat.first(), "{motion}: no heat");
    }
}

/// The direction of motion makes no difference: along y the surface does the same as along x, a quarter turn on. The
/// packing of the particles makes one, of 20 % relative to the slosh amplitude at this spacing.
#[test]
fn a_glass_moved_away_from_the_camera_sloshes_as_one_moved_along_x() {
    let recorded = |column: &str| {
        let file = Scratch::new(&format!("{column}.csv"));
        let place = |t: f64| 0.01 * (1.0 - (9.0 * t).cos());
        let lines: Vec<_> =
            (0..=40).map(|i| 0.02 * f64::from(i)).map(|t| format!("{t},{}", place(t))).collect();
        std::fs::write(&file.0, format!("t,{column}\n{}\n", lines.join("\n"))).expect("written");
        let motion = Motion::parse(&file.0.to_string_lossy(), 1.0).expect("a motion");
        record(&setup(&[]), &motion, 60, "test", |_| ()).expect("the glass is simulated")
    };
    let (along, away) = (recorded("x_m"), recorded("y_m"));
    assert_eq!((&along.glass_x_m, &along.glass_y_m), (&away.glass_y_m, &away.glass_x_m));
    assert!(along.is_plain() && away.is_level() && !away.is_plain());
    let (mut apart, mut slosh) = (0.0, 0.0);
    for (x, y) in along.wall_m.chunks_exact(WALL_POINTS).zip(away.wall_m.chunks_exact(WALL_POINTS)) {
        for (k, height) in x.iter().enumerate() {
            apart += f64::from(height - y[(k + WALL_POINTS / 4) % WALL_POINTS]).powi(2);
            slosh += (f64::from(*height) - GLASS.fill_m).powi(2);
        }
    }
    let apart = (apart / slosh).sqrt();
    println!("apart by {apart} of the slosh");
    assert!(apart < 0.25, "{apart}");
}

#[test]
fn a_glass_turned_with_its_room_stays_at_rest() {
    // An inclination so slow that the surface follows: its slope is the angle's tangent at the end.
    let file = Scratch::new("slow.csv");
    let angle = |t: f64| {
        0.1 * (t / 1.5_f64).min(1.0).powi(3)
            * (10.0 - 15.0 * (t / 1.5).min(1.0) + 6.0 * (t / 1.5).min(1.0).powi(2))
    };
    let lines: Vec<_> = (0..=40).map(|i| 0.05 * f64::from(i)).map(|t| format!("{t},{}", angle(t))).collect();
    std::fs::write(&file.0, format!("# pivot_m = 0.01, 0.03\nt,tilt_rad\n{}\n", lines.join("\n")))
        .expect("written");
    let motion = Motion::parse(&file.0.to_string_lossy(), 2.5).expect("a motion");
    let finer = Setup { spacing_m: FINER_M, ..setup(&[]) };
    let recording = record(&finer, &motion, 150, "test", |_| ()).expect("the glass is simulated");
    let last = recording.frames() - 1;
    let columns = Lattice::new(&GLASS).columns;
    let heights = &recording.column_m[columns.len() * last..];
    let parts = || columns.iter().zip(heights).map(|([x, _], z)| (x, f64::from(*z)));
    let slope = parts().map(|(x, z)| x * z).sum::<f64>() / parts().map(|(x, _)| x * x).sum::<f64>();
    println!("slope {slope} for {}", 0.1_f64.tan());
    assert!((slope / 0.1_f64.tan() - 1.0).abs() < 0.1, "{slope}");
    let file = Scratch::new("tilted.safetensors");
    recording.save(&file.0).expect("written");
    let read = Recording::load(&file.0).expect("read");
    assert_eq!((&read.tilt_rad, &read.glass_z_m), (&recording.tilt_rad, &recording.glass_z_m));
    assert_eq!(read.provenance.pivot_m, [0.01, 0.03]);
    assert!((read.tilt_rad[last] - 0.1).abs() < 1e-9 && !read.is_plain());
}

#[test]
fn recordings_from_before_the_new_channels_are_read() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors");
    let recording = Recording::load(&PathBuf::from(path)).expect("the recording is read");
    assert!(recording.is_plain() && recording.tilt_rad.len() == recording.frames());
}
