//! Refusals before a run, help texts, and a reader that goes away early.

use super::{folder, meniscus, refused};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

#[test]
fn a_bad_model_is_refused_with_its_reason() {
    let folder = folder("models");
    let run = |model: &str| meniscus(&folder, &["run", "--model", model, "--json"]);
    refused(&run("nowhere.blob"), &["nowhere.blob", "cannot read"]);

    let sound = fs::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../models/glycerine.blob")))
        .expect("shipped");
    fs::write(folder.join("cut.blob"), &sound[..sound.len() / 2]).expect("written");
    refused(&run("cut.blob"), &["cut.blob", "cut short"]);

    let mut flipped = sound.clone();
    flipped[sound.len() / 2] ^= 4;
    fs::write(folder.join("flipped.blob"), &flipped).expect("written");
    refused(&run("flipped.blob"), &["flipped.blob", "CRC-32"]);

    let mut newer = sound;
    newer[8] = 7;
    fs::write(folder.join("newer.blob"), &newer).expect("written");
    refused(&run("newer.blob"), &["version 7", "versions 3 to 4"]);

    fs::write(folder.join("text.blob"), "not a blob, though long enough to be one").expect("written");
    refused(&run("text.blob"), &["not a weight blob"]);
}

#[test]
fn bad_words_are_refused_before_anything_runs() {
    let folder = folder("words");
    let run = |arguments: &[&str]| meniscus(&folder, &[&["run"], arguments].concat());
    refused(&run(&["--faults", "gremlins:0.1"]), &["gremlins", "drop"]);
    refused(&run(&["--faults", "drop:1.5"]), &["drop:1.5", "from 0 to 1"]);
    refused(&run(&["--seconds", "-3"]), &["-3"]);
    refused(&run(&["--seconds", "0.2"]), &["0.2", "out of range"]);
    refused(&run(&["--source", "nowhere.safetensors"]), &["nowhere.safetensors"]);
    fs::write(folder.join("noise.safetensors"), [7; 100]).expect("written");
    refused(&run(&["--source", "noise.safetensors"]), &["noise.safetensors", "not a recording"]);
    assert!(!folder.join("out").exists(), "nothing is written for a run that never began");
}

#[test]
fn an_output_folder_that_cannot_be_written_is_refused_before_the_run() {
    let folder = folder("out");
    fs::write(folder.join("taken"), "a file stands where the folder should be").expect("written");
    let started = Instant::now();
    let output = meniscus(&folder, &["run", "--seconds", "10", "--out", "taken/inside"]);
    refused(&output, &["--out", "taken/inside"]);
    for flag in ["--estimates", "--turns"] {
        let output = meniscus(&folder, &["run", "--seconds", "10", flag, "taken/inside"]);
        refused(&output, &["cannot make the folder of", "taken/inside"]);
    }
    assert!(started.elapsed().as_secs() < 9, "it must not run for ten seconds first");
    assert_eq!(fs::read_to_string(folder.join("taken")).expect("kept").len(), 40);
}

#[test]
fn help_teaches() {
    let folder = folder("help");
    let help =
        |arguments: &[&str]| String::from_utf8_lossy(&meniscus(&folder, arguments).stdout).into_owned();
    let all = help(&["--help"]);
    for verb in ["run", "simulate", "train", "doctor", "dump"] {
        assert!(all.contains(verb), "{all}");
    }
    let run = help(&["run", "--help"]);
    for word in ["Coasting", "--faults", "drop:0.05", "--json", "Examples"] {
        assert!(run.contains(word), "`{word}` is missing in: {run}");
    }
}

/// As `meniscus ... | head` does, which closes its end early.
#[test]
fn nobody_who_reads_on_is_no_panic() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"));
    let output = command.args(["simulate", "--list"]).stdout(writer).output().expect("it starts");
    assert_eq!(output.status.code(), Some(141), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}
