//! Attacks by links that somebody has put into a folder that the program writes to.

use crate::boards::{board, flash, meniscus, said};
use crate::support::Scratch;
use std::fs;
use std::os::unix::fs::symlink;

/// A flash follows no link that somebody has put into its folder.
///
/// Links in the place of each part file and each slot; the file behind them stays, and no slot is a link afterwards.
#[test]
fn a_flash_follows_no_planted_link() {
    let scratch = Scratch::new("links");
    board(&scratch.0);
    let victim = scratch.0.join("victim");
    fs::write(&victim, "kept").expect("written");
    let names = ["slot-a.blob", "slot-a.sig", "slot-b.blob", "slot-b.sig", "active"];
    for name in names.iter().flat_map(|name| [(*name).to_owned(), format!("{name}.part")]) {
        symlink(&victim, scratch.0.join("slots").join(name)).expect("a link");
    }
    for (name, release) in [("a", 5), ("b", 6)] {
        let output = flash(&scratch.0, name, release, &[]);
        assert!(output.status.success(), "{}", said(&output));
    }
    assert_eq!(fs::read(&victim).expect("readable"), b"kept");
    for name in names {
        let kind = fs::symlink_metadata(scratch.0.join("slots").join(name)).expect("there").file_type();
        assert!(kind.is_file(), "{name} is a link");
    }
    let left = fs::read_dir(scratch.0.join("slots")).expect("listed").count();
    assert_eq!(left, names.len(), "no part file is left");
}

/// A file that is written replaces a link beside it, and leaves what the link points to.
///
/// A link in the place of the part file of a run's report.
#[test]
fn a_report_follows_no_planted_link() {
    let scratch = Scratch::new("report");
    let victim = scratch.0.join("victim");
    fs::write(&victim, "kept").expect("written");
    fs::create_dir(scratch.0.join("out")).expect("a folder");
    symlink(&victim, scratch.0.join("out/run.json.part")).expect("a link");
    let run = meniscus(&scratch.0, &["run", "--patient", "--seconds", "1.5", "--json", "--out", "out"]);
    assert!(run.status.success(), "{}", said(&run));
    assert_eq!(fs::read(&victim).expect("readable"), b"kept");
    assert!(fs::symlink_metadata(scratch.0.join("out/run.json")).expect("there").is_file());
}
