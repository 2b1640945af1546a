//! Attacks that end a write within: full disks, `kill -9`, a limit on the size of files.

use crate::boards::{board, flash, meniscus, said};
use crate::optional::skip;
use crate::support::{Scratch, meniscus_command};
use std::fs;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A recording into a folder of images can be opened after its disk was full.
///
/// A disk of 2 MB in memory, filled by `record --out FOLDER`; the folder is then read again.
#[test]
fn a_folder_on_a_full_disk_can_be_opened() {
    let scratch = Scratch::new("full");
    let program = meniscus_command();
    // A name space of its own, in which a disk may be mounted without being root.
    let script = format!(
        "mount -t tmpfs -o size=2m tmpfs disk || exit 77\n\
         {0} record --source simulated-usb --seconds 4 --out disk/images >/dev/null 2>first.txt; echo $? >first\n\
         {0} record --source disk/images --out again.csv >again.txt 2>&1; echo $? >again\n",
        program.get_program().display()
    );
    fs::create_dir(scratch.0.join("disk")).expect("a folder");
    let status = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script])
        .current_dir(&scratch.0)
        .status();
    if !status.is_ok_and(|status| status.success()) {
        return skip("a mount name space (unshare --user --mount)");
    }
    let read = |name: &str| fs::read_to_string(scratch.0.join(name)).expect("written");
    let (first, again) = (read("first.txt"), read("again.txt"));
    assert!(read("first").trim() == "1" && first.contains("which are kept"), "{first}");
    let images: usize =
        first.split("behind ").nth(1).and_then(|rest| rest.split(' ').next()?.parse().ok()).expect(&first);
    assert_eq!((read("again").trim(), images > 0), ("0", true), "{again}");
    assert!(again.contains("profiles"), "{again}");
}

/// A folder of images can be opened after `kill -9`, with all pairs but the one under way.
///
/// A recording that is killed after eleven pairs.
#[test]
fn a_folder_of_a_killed_recording_can_be_opened() {
    let scratch = Scratch::new("killed");
    let images = scratch.0.join("images");
    let mut child = meniscus_command()
        .args(["record", "--source", "simulated-usb", "--seconds", "300", "--out"])
        .arg(&images)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let begun = Instant::now();
    while !images.join("infrared-0010.png").exists() && begun.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().expect("killed");
    let _waited = child.wait();
    let pairs = fs::read_dir(&images).expect("listed").flatten();
    let whole = |name: &str| name.starts_with("infrared-") && name.ends_with(".png");
    let pairs = pairs.filter(|file| whole(&file.file_name().to_string_lossy())).count();
    let recording = meniscus_bags::open(&images).expect("it opens");
    let read = recording.images.filter(Result::is_ok).count();
    assert!(pairs > 10 && read >= 2 * (pairs - 1), "{read} images of {pairs} pairs");
}

/// Runs `meniscus` until a file of it grows beyond `blocks` of 512 bytes. The system ends it there by SIGXFSZ, whose default it
/// leaves, so that each write can be cut at a chosen place.
fn cut_at(blocks: u32, folder: &Path, arguments: &str) -> ExitStatus {
    let program = meniscus_command();
    let line =
        format!("ulimit -c 0; ulimit -f {blocks}; exec {} {arguments}", program.get_program().display());
    let mut command = Command::new("sh");
    command.args(["-c", &line]).current_dir(folder).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().expect("a shell")
}

/// A flash that is ended within a write leaves the slot that boots, and no part of a model in the other.
///
/// A signed flash is cut at its first byte, within the model at three places and before its last block.
#[test]
fn a_flash_that_is_cut_leaves_both_slots() {
    let scratch = Scratch::new("cut-flash");
    board(&scratch.0);
    for (name, release) in [("a", 5), ("b", 6)] {
        assert!(flash(&scratch.0, name, release, &[]).status.success());
    }
    let slots = scratch.0.join("slots");
    let names = ["slot-a.blob", "slot-a.sig", "slot-b.blob", "slot-b.sig", "active"];
    let contents = || names.map(|name| fs::read(slots.join(name)).ok());
    let before = contents();
    let last = meniscus_shipped::MODEL.len() as u32 / 512;
    for blocks in [0, 1, last / 3, last / 2, last - 1] {
        let words = "flash a.blob --release 6 --signature a.6.sig --profile board.toml";
        let ended = cut_at(blocks, &scratch.0, words);
        assert!(!ended.success(), "cut at block {blocks}: {ended}");
        let after = contents();
        // Slot B boots; the flash goes to slot A, whose signature it takes away first.
        let same = |index: usize| after[index] == before[index];
        assert!([0, 2, 3, 4].into_iter().all(same), "cut at block {blocks}");
    }
    let booted =
        meniscus(&scratch.0, &["run", "--model", "slots", "--patient", "--seconds", "1.5", "--json"]);
    assert!(booted.status.success() && !said(&booted).contains("is used"), "{}", said(&booted));
    let again = flash(&scratch.0, "a", 6, &[]);
    assert!(again.status.success(), "{}", said(&again));
    assert_eq!(fs::read_dir(&slots).expect("listed").count(), names.len(), "no part file is left");
}

/// A report that is ended within its write does not take the place of the one before.
///
/// A second run into the same folder, which is cut within its report, and within its picture.
#[test]
fn a_report_that_is_cut_leaves_the_one_before() {
    let scratch = Scratch::new("cut-report");
    let words = "run --patient --seconds 1.5 --json --out out";
    assert!(meniscus(&scratch.0, &words.split(' ').collect::<Vec<_>>()).status.success());
    let out = scratch.0.join("out");
    let whole: Vec<_> = fs::read_dir(&out).expect("listed").flatten().map(|file| file.path()).collect();
    let contents = || whole.iter().map(|path| fs::read(path).unwrap_or_default()).collect::<Vec<_>>();
    let before = contents();
    assert!(before.iter().any(|bytes| bytes.len() > 1024), "nothing that can be cut");
    for blocks in [0, 1, 2] {
        let ended = cut_at(blocks, &scratch.0, words);
        assert!(!ended.success(), "cut at block {blocks}: {ended}");
        assert_eq!(contents(), before, "cut at block {blocks}");
    }
}
