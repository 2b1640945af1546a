//! Clear water that sloshes: surfaces of the simulator, path-traced frame by frame and read one after the other.

use crate::figures::Figures;
use crate::scenes::JUDGED;
use meniscus_virtual::camera_study::traced::degrade::Faults;
use meniscus_virtual::camera_study::traced::set::{TracedScene, folder, read};

/// Returns the frames of a set, in windows of consecutive ones.
fn windows(set: &str) -> Vec<Vec<TracedScene>> {
    let frames = read(&folder().join("swing"), set).expect("the repository holds the set");
    let number = |frame: &TracedScene| -> u32 {
        frame.truth.name.rsplit('-').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    frames.chunk_by(|one, next| number(next) == number(one) + 1).map(<[TracedScene]>::to_vec).collect()
}

#[test]
fn water_in_a_swing_is_read_within_the_targets() {
    for set in ["develop", JUDGED] {
        let windows = windows(set);
        for window in &windows {
            let lines = window.iter().flat_map(|scene| scene.truth.contact_line_mm);
            let (low, high) = lines.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
            let name = &window[0].truth.name;
            println!("from {name} on: {} frames, a line from {low:.1} to {high:.1} mm", window.len());
        }
        let read = Figures::of_windows(&windows, &Faults::default());
        read.print(set);
        assert!(read.pass(), "{set}");
        let flat = read.of_flat(windows.iter().flatten());
        flat.print("  flat");
        assert!(!flat.pass() && flat.rms_mm() > 2.0 * read.rms_mm(), "{set}");
    }
}

#[test]
fn a_cameras_faults_cost_less_than_the_target_in_a_swing() {
    for (name, faults) in [
        ("dots of 60 grey", Faults { dots: 60.0, ..Faults::default() }),
        ("noise of 4 grey", Faults { grey_rms: 4.0, ..Faults::default() }),
        ("smear of 3 px", Faults { smear_px: 3, ..Faults::default() }),
    ] {
        let read = Figures::of_windows(&windows(JUDGED), &faults);
        read.print(name);
        assert!(read.rms_mm() <= 0.8 && read.seen() >= 0.9, "{name}");
    }
}
