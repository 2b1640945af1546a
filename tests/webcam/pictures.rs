//! A folder of images with their times in the place of a webcam.

use crate::reading::{Each, config_of, lens_of};
use crate::rendered::{Rendered, Troubles, USUAL, recording};
use image::ExtendedColorType;
use meniscus::runtime::ProfileSensor;
use meniscus::surface::{POINTS, Settings};
use meniscus::usb::uvc::Stream;
use meniscus_platform::clock::NoClock;
use meniscus_webcam::{Pictures, Session};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes `count` rendered frames at 30 Hz into a folder; `name` names each by its number and its time in microseconds.
fn pictures(folder: &str, rests: bool, count: usize, name: impl Fn(usize, u64) -> String) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("webcam").join(folder);
    let _old = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut webcam = Rendered::new(USUAL, 610.0, Settings::default(), Troubles::default());
    webcam.rests = rests;
    for number in 0..count {
        webcam.render();
        webcam.shown += 1;
        let path = folder.join(name(number, number as u64 * 1_000_000 / 30));
        image::save_buffer(path, &webcam.images.infrared, 640, 480, ExtendedColorType::L8).expect("written");
    }
    folder
}

#[test]
fn a_folder_of_images_with_their_times_is_read_like_a_camera() {
    let named = |_, us: u64| format!("glass-{}.{:06}.png", us / 1_000_000, us % 1_000_000);
    let folder = pictures("by-name", false, 60, named);
    let images = Pictures::open(&folder).expect("opened");
    assert_eq!(images.count(), 60);
    let mut session = Session::connect(images, "a folder").expect("30 images a second");
    assert_eq!((session.webcam().mode.size, session.webcam().mode.rate_hz().round()), ([640, 480], 30.0));
    let lens = lens_of(USUAL, 610.0);
    let (mut colour, mut grey) =
        (vec![0; lens.rectifier().colour_bytes()], vec![0; lens.rectifier().grey_bytes()]);
    let config = config_of(lens, Settings::default());
    let mut sensor = ProfileSensor::of_outline(config, lens.rectifier(), &mut colour, &mut grey);
    let (mut squares, mut points, truth) = (0.0, 0.0, recording());
    let bytes = session.buffer_bytes();
    let take = |payload: &[u8]| {
        let seen = sensor.accept(Stream::Outline, payload, &mut NoClock).expect("a frame each");
        let profile = seen.profile.expect("seen");
        let frame = (seen.stamp.captured.0 as f64 * 6e-5).round() as usize;
        for i in (0..POINTS).filter(|i| profile.valid[*i]) {
            squares += f64::from(profile.height_m[i] - truth.profile(frame)[i]).powi(2);
            points += 1.0;
        }
    };
    let mut sink = Each { left: usize::MAX, bytes, take, notes: Vec::new() };
    session.stream(&mut sink).expect("it ends with the last image");
    assert_eq!((usize::MAX - sink.left, sink.notes), (60, vec![]));
    assert_eq!(sensor.losses().1.frames(), 0);
    let rms_mm = 1e3 * f64::sqrt(squares / points);
    println!("a folder: {rms_mm:.3} mm");
    assert!(rms_mm < 0.25, "{rms_mm}");
}

#[test]
fn a_folder_is_set_up_and_run_by_the_command() {
    let numbered = |number: usize, _| format!("frame{number:04}.png");
    let folder = pictures("command", true, 100, numbered);
    let meniscus = |arguments: &[&str]| {
        let program = env!("CARGO_BIN_EXE_meniscus-under-test");
        let home = folder.parent().expect("a folder");
        let output = Command::new(program).args(arguments).current_dir(home).output().expect("it starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.success(), text(&output.stdout), text(&output.stderr))
    };
    let asked =
        ["setup", "--source", "command", "--yes", "--radius-mm", "35", "--fill-mm", "70", "--rim-mm", "110"];
    let stated =
        ["--distance-mm", "365", "--camera-height-mm", "30", "--focal-px", "610", "--pairs", "30", "--force"];
    let set_up = || meniscus(&[&asked[..], &stated].concat());
    let (ok, _, message) = set_up();
    assert!(!ok && message.contains("have no times") && message.contains("frame0000.png"), "{message}");
    let table = folder.join("times.csv");
    let write = |times: &mut dyn Iterator<Item = f64>| {
        let rows: String = (0..).zip(times).map(|(n, time)| format!("frame{n:04}.png,{time:.4}\n")).collect();
        std::fs::write(&table, format!("file,time_s\n{rows}")).expect("written");
    };
    write(&mut (0..99).map(|n| f64::from(n) / 30.0));
    let (ok, _, message) = set_up();
    assert!(!ok && message.contains("99 times for 100 images"), "{message}");
    write(&mut (0..100).map(|n| if n == 40 { 1.0 } else { f64::from(n) / 30.0 }));
    let (ok, _, message) = set_up();
    assert!(
        !ok && message.contains("frame0040.png is of 1 s") && message.contains("times must rise"),
        "{message}"
    );
    write(&mut (0..100).map(|n| f64::from(n) / 30.0));
    let (ok, shown, message) = set_up();
    assert!(ok, "{shown}{message}");
    let run =
        ["run", "--source", "command", "--setup", "glass.toml", "--seconds", "3", "--json", "--out", "out"];
    let (ok, shown, message) = meniscus(&run);
    assert!(ok, "{shown}{message}");
    let report: serde_json::Value = serde_json::from_str(&shown).expect("one object");
    // 90 images in 3 s, of which 8 fill the window of 16 turns.
    let tracking = report["modes"]["tracking"].as_u64().expect("a count");
    assert!((70..=91).contains(&tracking), "{report:#}");
    assert_eq!(report["losses"]["infrared"]["counter_gap"], 0, "{report:#}");
    assert!(report["webcam"].as_str().is_some_and(|webcam| webcam.contains("640x480")), "{report:#}");
}
