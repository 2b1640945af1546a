//! Outputs of commands that do not come to their end: nothing half written, nothing lost that was there, no model of which
//! nothing was learnt.

#[path = "support/optional.rs"]
mod optional;
#[path = "support/program.rs"]
mod program;

use optional::skip;
use program::{errors, folder, json, meniscus};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The shipped recording, from the folder of a test.
fn copy_recording(folder: &Path) {
    let recording = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings/glycerine-unseen.safetensors");
    fs::copy(recording, folder.join("own.safetensors")).expect("copied");
}

/// A correction in which no candidate is better: with no forgetting allowed, each one is refused.
#[test]
fn a_correction_that_improves_nothing_fails_and_writes_no_blob() {
    let folder = folder("outputs", "nothing");
    copy_recording(&folder);
    let arguments = "correct --recordings own.safetensors --steps 10 --forgetting 0 --out new.blob --json";
    let output = meniscus(&folder, arguments);
    let said = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("nothing was learnt") && said.contains("no blob is written"), "{said}");
    assert!(said.contains("--forgetting"), "{said}");
    assert!(json(&output)["blob"].is_null());
    assert!(!folder.join("new.blob").exists());
}

#[test]
fn a_refused_run_leaves_an_earlier_report_as_it_is() {
    let folder = folder("outputs", "report");
    fs::create_dir(folder.join("out")).expect("a folder");
    fs::write(folder.join("out/run.json"), "{\"earlier\": true}\n").expect("written");
    let output = meniscus(&folder, "run --motion nowhere.csv");
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    assert_eq!(fs::read_to_string(folder.join("out/run.json")).expect("kept"), "{\"earlier\": true}\n");
    let files = fs::read_dir(folder.join("out")).expect("listed").count();
    assert_eq!(files, 1);
}

/// A disk of 300 kB in memory: what is larger says that the disk is full, and leaves neither a whole name nor a part.
#[test]
fn a_full_disk_is_named_and_nothing_half_written_stays() {
    let folder = folder("outputs", "full");
    copy_recording(&folder);
    fs::create_dir(folder.join("disk")).expect("a folder");
    let program = env!("CARGO_BIN_EXE_meniscus-under-test");
    let commands = [
        "quantize --to bf16 --source own.safetensors --out disk/small.blob",
        "flash shipped --to disk/slots",
        "insert --effect foam=0.1 --out disk/foam.blob",
        "simulate --motion still --seconds 0.3 --spacing-mm 8 --out disk/still.safetensors",
    ];
    let mut script = String::from("mount -t tmpfs -o size=300k tmpfs disk || exit 77\n");
    for (k, command) in commands.iter().enumerate() {
        script += &format!("{program} {command} >said{k}.txt 2>&1; echo $? >status{k}.txt\n");
        script += &format!("find disk -type f >left{k}.txt; rm -rf disk/*\n");
    }
    let status = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(&folder)
        .status();
    if !status.is_ok_and(|status| status.success()) {
        return skip("a mount name space (unshare --user --mount)");
    }
    let read = |name: String| fs::read_to_string(folder.join(name)).expect("written");
    for (k, command) in commands.iter().enumerate() {
        let (said, left) = (read(format!("said{k}.txt")), read(format!("left{k}.txt")));
        assert_eq!(read(format!("status{k}.txt")).trim(), "1", "{command}: {said}");
        assert!(said.contains("its disk is full"), "{command}: {said}");
        assert_eq!(left, "", "{command} leaves files on the full disk");
    }
}
