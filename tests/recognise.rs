//! The right liquid is named from what a camera sees of it, and none where it is not among those asked.

use meniscus::surface::{Settings, SurfaceProfile};
use meniscus::units::Micros;
use meniscus::usb::frame::Stamp;
use meniscus::usb::uvc::Stream;
use meniscus_bags::{Calibration, Image, McapWriter};
use meniscus_data::recording::Recording;
use meniscus_discover::identify::{recognise, render_profiles};
use meniscus_service::identify::Note;
use meniscus_virtual::render::{Images, Liquid, Scene, SceneSettings};
use serde_json::Value;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The liquids that come with the program.
fn shipped() -> Vec<Note> {
    Note::all_of(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/liquids")))
        .expect("the shipped notes")
}

/// Returns the camera's view of the shipped recording, which no note was learnt from.
fn glycerine() -> (Vec<Option<SurfaceProfile>>, f64) {
    let recording = Recording::load(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../recordings/glycerine-unseen.safetensors"
    )))
    .expect("it is shipped");
    let motion = &recording.provenance.motion;
    assert!(shipped().iter().all(|note| note.liquid != "glycerine" || !note.recordings.contains(motion)));
    (render_profiles(&recording, 0.24, 5).expect("the shipped glass"), recording.glass.fill_m)
}

#[test]
fn the_shipped_recording_is_glycerine_and_none_of_the_others() {
    let (seen, fill_m) = glycerine();
    let all = shipped();
    assert_eq!(all.len(), 6);
    let said = recognise(&all, fill_m, &seen, |_, _, _| {});
    assert_eq!(said.liquid.as_deref(), Some("glycerine"), "{}", said.line());
    let others: Vec<Note> = all.iter().filter(|note| note.liquid != "glycerine").cloned().collect();
    let said = recognise(&others, fill_m, &seen, |_, _, _| {});
    assert_eq!(said.liquid, None, "{}", said.line());
    // Four seconds do, and a tenth of the frames may be lost.
    let lossy: Vec<_> = seen.iter().take(240).enumerate().map(|(n, p)| p.filter(|_| n % 10 != 7)).collect();
    let said = recognise(&all, fill_m, &lossy, |_, _, _| {});
    assert_eq!(said.liquid.as_deref(), Some("glycerine"), "{}", said.line());
}

#[test]
fn what_is_believed_begins_even_and_grows() {
    let (seen, fill_m) = glycerine();
    let mut believed = Vec::new();
    recognise(&shipped(), fill_m, &seen, |frame, trail, recogniser| {
        if [10, 240, 500].contains(&frame) {
            let mut p = [0.0; 6];
            let verdict = recogniser.verdict(trail, &mut p);
            assert!((p.iter().sum::<f64>() + verdict.none - 1.0).abs() < 1e-9);
            believed.push(p.into_iter().fold(0.0, f64::max));
        }
    });
    assert!(believed[0] < 0.2 && believed[1] > 0.7 && believed[2] > believed[1] - 0.05, "{believed:?}");
}

/// Films `frames` of the shipped recording into a file as a camera writes them.
fn film(path: &Path, frames: Range<usize>) {
    let recording = Recording::load(Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../recordings/glycerine-unseen.safetensors"
    )))
    .expect("it is shipped");
    let settings = SceneSettings { disparity_rms_px: 0.24, seed: 5, ..SceneSettings::of(&recording.glass) };
    let calibration = Calibration::of(&settings.camera.optics(), 0.05, "a rendered D435");
    let mut writer = McapWriter::create(path, &calibration).expect("a file");
    let (mut scene, mut images) = (Scene::new(settings), Images::new(&settings));
    for frame in frames {
        scene.render(&Liquid::of(&recording, frame), frame as u64, &mut images);
        let captured = Micros((frame as u64 * 1_000_000 + 30) / 60);
        let stamp = Stamp { sequence: frame as u32, captured };
        for (stream, pixels) in [(Stream::Depth, &images.depth), (Stream::Outline, &images.infrared)] {
            writer.write(&Image { stream, stamp, pixels: pixels.clone() }).expect("written");
        }
    }
    writer.finish().expect("closed");
}

/// Writes the setup file of a glass like that of the shipped recording with this radius.
fn setup(path: &Path, radius_mm: f64) {
    let settings = Settings::default();
    assert_eq!(
        (settings.camera_distance_m, settings.camera_height_m),
        (0.4, 0.03),
        "where the camera stands"
    );
    let text = format!(
        "made_by = \"a test\"\n[glass]\nradius_mm = {radius_mm:.1}\nfill_mm = 70.0\nrim_mm = 110.0\n[liquid]\ntone = \"dark\"\n\
         least_contrast = {:.1}\n[view]\ncamera = \"a rendered D435\"\ndistance_mm = 400.0\nheight_mm = 30.0\npitch_deg = 0.0\n",
        settings.least_contrast
    );
    fs::write(path, text).expect("a file");
}

/// Runs `meniscus recognise` from `folder`.
fn command(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .arg("recognise")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("it starts")
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("recognise").join(name);
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

#[test]
fn a_cameras_recording_is_named_and_learnt_from() {
    let folder = folder("filmed");
    film(&folder.join("one.mcap"), 0..300);
    film(&folder.join("two.mcap"), 300..600);
    setup(&folder.join("glass.toml"), 35.0);
    let said = command(&folder, &["one.mcap", "--setup", "glass.toml", "--json"]);
    let text = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    let json: Value = serde_json::from_str(&text).expect("an object");
    assert_eq!(json["recordings"][0]["said"]["liquid"], "glycerine", "{text}");

    let learnt = [
        "learn",
        "--recordings",
        "one.mcap",
        "two.mcap",
        "--setup",
        "glass.toml",
        "--out",
        "mine.liquid.json",
    ];
    let learnt = command(&folder, &learnt);
    assert!(learnt.status.success(), "{}", String::from_utf8_lossy(&learnt.stderr));
    let note = Note::read(&folder.join("mine.liquid.json")).expect("a note");
    assert_eq!((note.liquid.as_str(), note.radius_m, note.fill_m), ("mine", 0.035, 0.07));
    assert_eq!(note.recordings, ["one.mcap", "two.mcap"]);
    let shipped = shipped().into_iter().find(|note| note.liquid == "glycerine").expect("glycerine");
    let ratio = note.tone.frequency / shipped.tone.frequency;
    assert!((ratio - 1.0).abs() < 0.1, "{} of the shipped note's frequency", ratio);
}

#[test]
fn what_a_cameras_recording_lacks_is_named() {
    let folder = folder("refused");
    film(&folder.join("one.mcap"), 0..4);
    setup(&folder.join("other.toml"), 40.0);
    let own = concat!(env!("CARGO_MANIFEST_DIR"), "/../recordings/glycerine-unseen.safetensors");
    let wrong: [(&[&str], &str); 5] = [
        (&["one.mcap"], "need --setup FILE.toml"),
        (&["one.mcap", "--setup", "none.toml"], "none.toml"),
        (&["one.mcap", "--setup", "other.toml"], "learn it in this glass"),
        (&["one.mcap", own, "--setup", "other.toml"], "give one kind"),
        (&[own, "--setup", "other.toml"], "--setup is for a camera's recordings"),
    ];
    for (arguments, words) in wrong {
        let output = command(&folder, arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(words), "{arguments:?}: {said}");
        assert!(!said.contains("panicked"), "{said}");
    }
}
