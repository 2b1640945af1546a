//! Instructions of the worker's turns with the node on, by callgrind: what the node's sink takes of them.

use std::path::Path;
use std::process::Command;

/// Bound on the instructions of the turns with the node, to those without it.
const RATIO: f64 = 1.01;

/// Counts the instructions of the worker and of the node's sink in a short run, and compares them.
pub(crate) fn scene() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("ros2-instructions");
    std::fs::create_dir_all(&folder).expect("a folder");
    let counts = folder.join("counts");
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", &format!("--callgrind-out-file={}", counts.display())])
        .arg(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["run", "--ros2", "--patient", "--seconds", "1.5", "--json", "--out", "out"])
        .current_dir(&folder)
        .env("MENISCUS_NARROW", "1")
        // Valgrind counts each byte of `rep movsb` as an instruction; the processor counts one.
        .env("GLIBC_TUNABLES", "glibc.cpu.x86_rep_movsb_threshold=1000000000")
        .output()
        .expect("valgrind is there (apt-get install valgrind)");
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{said}");
    let annotated = Command::new("callgrind_annotate")
        .args(["--inclusive=yes", "--threshold=100", "--auto=no"])
        .arg(&counts)
        .output()
        .expect("callgrind_annotate comes with valgrind");
    let text = String::from_utf8_lossy(&annotated.stdout);
    let of = |name: &str| {
        // A function may stand in several lines, one a caller's file; the whole is the largest.
        let numbers = text.lines().filter(|line| line.contains(name)).filter_map(|line| {
            line.split_whitespace().next().and_then(|number| number.replace(',', "").parse::<u64>().ok())
        });
        numbers.max().unwrap_or(0)
    };
    let (worker, sink) = (of("live::worker::Worker::run"), of("outlet::TurnOutlet as "));
    assert!(worker > 100_000_000 && sink > 100_000, "both were counted: {worker} {sink}");
    let ratio = worker as f64 / (worker - sink) as f64;
    println!(
        "{worker} instructions of the worker, {sink} of them for the node: {ratio:.4} times those without it"
    );
    assert!(ratio <= RATIO);
}
