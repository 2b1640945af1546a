//! Attacks on the terminal of the person who runs the program.

use crate::optional::skip;
use crate::resealed::resealed;
use crate::support::{Scratch, meniscus_command};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// A terminal that moves no cursor gets plain lines.
///
/// `run` on a terminal of its own with TERM=dumb: no escape sequence comes out.
#[test]
fn a_dumb_terminal_gets_plain_lines() {
    let scratch = Scratch::new("dumb");
    let program = meniscus_command();
    let on_terminal = |term: &str| {
        let line = format!("{} run --seconds 2 --out out", program.get_program().display());
        let output = Command::new("script")
            .args(["-qec", &line, "/dev/null"])
            .env("TERM", term)
            .current_dir(&scratch.0)
            .stdin(Stdio::null())
            .output();
        output.map(|output| (output.status.success(), output.stdout))
    };
    let Ok((ended, dumb)) = on_terminal("dumb") else { return skip("script, of util-linux") };
    let text = String::from_utf8_lossy(&dumb);
    assert!(ended && !dumb.contains(&0x1b), "{text}");
    assert!(text.contains("running: 0 of 2 s") && text.lines().count() > 5, "{text}");
    // The terminal is one: another TERM gets the dashboard.
    let (_, full) = on_terminal("xterm").expect("it starts again");
    assert!(full.contains(&0x1b));
}

/// A sequence that gives a terminal another title, one that moves its cursor, and one in a single character (C1).
const SEQUENCE: &str = "\x1b]0;in\x07\x1b[2A\u{9b}31m";

/// Asserts that no control character comes out of `meniscus` with `arguments`; returns what came.
fn plain_words(folder: &Path, arguments: &[&str]) -> String {
    let output = meniscus_command().args(arguments).current_dir(folder).output().expect("it starts");
    let all = [output.stdout, output.stderr].concat();
    let text = String::from_utf8_lossy(&all).into_owned();
    let control = text.chars().find(|letter| letter.is_control() && *letter != '\n');
    assert_eq!(control, None, "{arguments:?}: {text:?}");
    text
}

/// A model, a recording or a camera that carries sequences for a terminal is refused.
///
/// Resealed models whose liquid or provenance is such a sequence, a recording of such a liquid, a folder of such a camera.
#[test]
fn files_carry_no_sequences_to_a_terminal() {
    let scratch = Scratch::new("sequences");
    let head = meniscus_shipped::MODEL[..600].to_vec();
    for (what, word) in [("liquid", &b"glycerine"[..]), ("provenance", b"meniscus train ")] {
        let at = head.windows(word.len()).position(|part| part == word).expect("in the header");
        let mut blob = meniscus_shipped::MODEL.to_vec();
        blob[at..at + 9].copy_from_slice(b"\x1b]0;in!\x07!");
        fs::write(scratch.0.join("a.blob"), resealed(blob)).expect("written");
        for arguments in [
            &["flash", "a.blob", "--to", "slots"][..],
            &["run", "--model", "a.blob", "--patient", "--seconds", "1.5", "--out", "out"],
        ] {
            let words = plain_words(&scratch.0, arguments);
            assert!(words.contains(&format!("the header's {what} holds control characters")), "{words}");
        }
    }
    let mut made = meniscus_shipped::RECORDING.to_vec();
    let name = b"\\\"liquid\\\":\\\"glycerine";
    let at = made.windows(name.len()).position(|part| part == name).expect("its provenance") + 13;
    made[at..at + 9].copy_from_slice(b"\\\\u001b[m");
    fs::write(scratch.0.join("made.safetensors"), made).expect("written");
    let words = plain_words(&scratch.0, &["run", "--source", "made.safetensors", "--seconds", "1.5"]);
    assert!(words.contains("its liquid holds control characters"), "{words}");
    let images = scratch.0.join("images");
    fs::create_dir(&images).expect("a folder");
    fs::write(images.join("frames.csv"), "frame,time_s,depth,infrared\n").expect("written");
    let camera =
        meniscus_bags::Calibration::of(&meniscus::surface::Optics::default(), 0.05, format!("a{SEQUENCE}"));
    let text = serde_json::to_string(&camera).expect("JSON");
    fs::write(images.join("camera.json"), text).expect("written");
    let words = plain_words(&scratch.0, &["record", "--source", "images", "--out", "again.csv"]);
    assert!(words.contains("its camera cannot be"), "{words}");
}

/// A name that is a sequence for a terminal is spelled out in messages.
///
/// A model, a recording, a profile, a scene and a motion with such a name, each refused; a profile with such a board.
#[test]
fn messages_carry_no_sequences_to_a_terminal() {
    let scratch = Scratch::new("messages");
    let name = format!("a{SEQUENCE}.csv");
    fs::write(scratch.0.join(&name), format!("name = '{SEQUENCE}'\n")).expect("written");
    for arguments in [
        &["run", "--model", &name][..],
        &["run", "--source", &name],
        &["run", "--profile", &name],
        &["run", "--motion", &name],
        &["run", "--setup", &name, "--source", "simulated-usb"],
        &["record", "--source", &name, "--out", "again.csv"],
        &["simulate", "--scene", &name, "--out", "x.safetensors"],
    ] {
        let words = plain_words(&scratch.0, arguments);
        assert!(words.contains("error: ") && words.contains("\\u{1b}]0;in\\u{7}"), "{arguments:?}: {words}");
    }
}
