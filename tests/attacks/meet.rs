//! The program before a file that is made to exhaust it, with limits on its memory and time.

use crate::support::{Scratch, meniscus_command};
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Memory and time within which a reader has to give a bomb up.
const MEMORY_KIB: u64 = 256 * 1024;
const WITHIN: Duration = Duration::from_secs(10);

/// End of a program that has met a bomb.
#[derive(Debug)]
pub(crate) struct Met {
    /// Peak of the resident memory, KiB.
    peak_kib: u64,
    took: Duration,
    /// Whether it ended by itself.
    ended: bool,
    failed: bool,
    said: String,
}

/// Runs `meniscus` with `arguments`, and ends it when it exceeds memory or time.
pub(crate) fn meet(folder: &Path, arguments: &[&str]) -> Met {
    let said = folder.join("said.txt");
    let mut child = meniscus_command()
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&said).expect("a file"))
        .spawn()
        .expect("it starts");
    let (begun, status) = (Instant::now(), format!("/proc/{}/status", child.id()));
    let mut met = Met { peak_kib: 0, took: Duration::ZERO, ended: true, failed: false, said: String::new() };
    let exit = loop {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let peak = text
            .lines()
            .find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.trim().parse().ok());
        met.peak_kib = met.peak_kib.max(peak.unwrap_or(0));
        if let Some(exit) = child.try_wait().expect("a child") {
            break Some(exit);
        }
        if met.peak_kib > MEMORY_KIB || begun.elapsed() > WITHIN {
            let _gone = child.kill();
            let _waited = child.wait();
            break None;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    met.took = begun.elapsed();
    (met.ended, met.failed) = (exit.is_some(), exit.is_some_and(|exit| exit.code() == Some(1)));
    met.said = fs::read_to_string(&said).unwrap_or_default();
    met
}

/// Asserts that `meniscus record --source` gives up what `make` has made, with `words`.
pub(crate) fn defused(name: &str, words: &str, make: impl FnOnce(&Path)) {
    let scratch = Scratch::new(&format!("bomb-{name}"));
    make(&scratch.0);
    let bomb = fs::read_dir(&scratch.0).expect("listed").flatten().map(|entry| entry.file_name());
    let bomb: Vec<String> = bomb.map(|name| name.to_string_lossy().into_owned()).collect();
    let bomb = bomb.iter().find(|name| name.starts_with("bomb")).expect("a bomb");
    judged(&meet(&scratch.0, &["record", "--source", bomb, "--out", "kept.csv"]), name, words);
}

/// Asserts that the program that `met` bomb `name` gave it up within the limits, with `words`.
pub(crate) fn judged(met: &Met, name: &str, words: &str) {
    eprintln!(
        "{name}: {} MiB, {:?}: {}",
        met.peak_kib / 1024,
        met.took,
        met.said.lines().last().unwrap_or("")
    );
    // A program that ends at once may not have been looked at.
    assert!(met.ended && (met.peak_kib > 0 || met.took < Duration::from_millis(200)), "{name}: {met:?}");
    assert!(met.peak_kib <= MEMORY_KIB && met.took <= WITHIN, "{name}: {met:?}");
    assert!(met.failed && met.said.contains(words), "{name}: '{words}' is not in {met:?}");
}

/// A folder of images whose one pair `make` writes as `depth.png` and `infrared.png`.
pub(crate) fn pair(folder: &Path, make: impl FnOnce(&Path)) {
    let folder = folder.join("bomb");
    fs::create_dir(&folder).expect("a folder");
    fs::write(folder.join("frames.csv"), "frame,time_s,depth,infrared\n0,0,depth.png,infrared.png\n")
        .expect("written");
    make(&folder);
    // The second image is as bad as the first: a reader that goes on meets it.
    let _same = symlink("depth.png", folder.join("infrared.png"));
}
