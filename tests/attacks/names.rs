//! Attacks by names that are not as expected.

use crate::support::{Scratch, meniscus_command};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;

/// Names that are no text are names.
///
/// A model, a camera's recording, a simulator's recording and an output folder with a byte that is no UTF-8.
#[test]
fn names_that_are_no_text_are_taken() {
    let scratch = Scratch::new("names");
    let name = |ending: &str| scratch.0.join(OsStr::from_bytes(&[b"\xff\xfe ", ending.as_bytes()].concat()));
    fs::write(name("model.blob"), meniscus_shipped::MODEL).expect("written");
    fs::write(name("made.safetensors"), meniscus_shipped::RECORDING).expect("written");
    let run = |arguments: &[&OsStr]| {
        let output = meniscus_command().args(arguments).current_dir(&scratch.0).output().expect("it starts");
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let word = OsStr::new;
    let run_words =
        [word("run"), word("--patient"), word("--seconds"), word("1.5"), word("--json"), word("--out")];
    let (model, made, out) = (name("model.blob"), name("made.safetensors"), name("out"));
    run(&[&run_words[..], &[out.as_os_str(), word("--model"), model.as_os_str()]].concat());
    run(&[&run_words[..], &[out.as_os_str(), word("--source"), made.as_os_str()]].concat());
    let images = name("images");
    run(&[
        word("record"),
        word("--source"),
        word("simulated-usb"),
        word("--seconds"),
        word("0.5"),
        word("--out"),
        images.as_os_str(),
    ]);
    run(&[
        word("record"),
        word("--source"),
        images.as_os_str(),
        word("--out"),
        name("kept.mcap").as_os_str(),
    ]);
    run(&[word("flash"), model.as_os_str(), word("--to"), name("slots").as_os_str()]);
}
