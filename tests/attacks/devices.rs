//! Attacks by devices, pipes and files without an end in the place of files.

use crate::meet::{defused, judged, meet, pair};
use crate::support::Scratch;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;

/// A device or a pipe is no image, table or recording.
///
/// Links to /dev/zero and named pipes in the place of an image, of the table, of the camera and of the file itself.
#[test]
fn devices_and_pipes_are_refused() {
    let words = "a device, a pipe or a socket";
    let pipe = |path: PathBuf| {
        assert!(std::process::Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
    };
    defused("zero image", words, |folder| {
        pair(folder, |folder| symlink("/dev/zero", folder.join("depth.png")).expect("a link"));
    });
    defused("pipe image", words, |folder| pair(folder, |folder| pipe(folder.join("depth.png"))));
    defused("pipe camera", words, |folder| pair(folder, |folder| pipe(folder.join("camera.json"))));
    defused("zero file", words, |folder| symlink("/dev/zero", folder.join("bomb.bag")).expect("a link"));
    defused("pipe file", words, |folder| pipe(folder.join("bomb.mcap")));
    defused("zero table", words, |folder| {
        fs::create_dir(folder.join("bomb")).expect("a folder");
        symlink("/dev/zero", folder.join("bomb/frames.csv")).expect("a link");
    });
}

/// A model, a profile, a scene and a motion that never end are refused.
///
/// /dev/zero in the place of each.
#[test]
fn endless_models_and_texts_are_refused() {
    let scratch = Scratch::new("bomb-endless");
    for arguments in [
        &["run", "--model", "/dev/zero"][..],
        &["run", "--profile", "/dev/zero"],
        &["run", "--setup", "/dev/zero", "--source", "simulated-usb"],
        &["run", "--motion", "/dev/zero"],
        &["simulate", "--scene", "/dev/zero", "--out", "x.safetensors"],
        &["flash", "/dev/zero", "--to", "slots"],
    ] {
        judged(&meet(&scratch.0, arguments), &arguments.join(" "), "/dev/zero");
    }
}
