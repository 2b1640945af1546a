//! Instructions of fixed work, stage by stage, against the table in `benches/instructions.toml`: a regression shows
//! on a machine whose clock says nothing.
//!
//! The count is callgrind's, with the kernels as any x86-64 runs them; there is no table for another kind of processor.
//! Without valgrind the test is skipped, which fails in CI. `MENISCUS_INSTRUCTIONS=write` writes the table anew.
#![cfg(target_arch = "x86_64")]

#[path = "support/optional.rs"]
mod optional;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Relative deviation of a count from the table that another split into codegen units explains.
const TOLERANCE: f64 = 0.10;

/// Times that every stage is run.
const TIMES: u64 = 2;

fn table_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../benches/instructions.toml")
}

/// Instructions of a run of each function whose name begins with `stage_`.
fn counted() -> Option<BTreeMap<String, u64>> {
    // Whether it starts: callgrind_annotate tells its version and fails.
    let found = |program: &str| Command::new(program).arg("--version").output().is_ok();
    if !found("valgrind") || !found("callgrind_annotate") {
        optional::skip("valgrind is not there (apt-get install valgrind)");
        return None;
    }
    let out = std::env::temp_dir().join(format!("meniscus-callgrind-{}", std::process::id()));
    let program = env!("CARGO_BIN_EXE_meniscus-under-test");
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", &format!("--callgrind-out-file={}", out.display()), program])
        .args(["bench", "--count", &TIMES.to_string()])
        .env("MENISCUS_NARROW", "1")
        .output()
        .expect("valgrind runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let annotated = Command::new("callgrind_annotate")
        .args(["--inclusive=yes", "--threshold=100", "--auto=no"])
        .arg(&out)
        .output()
        .expect("callgrind_annotate runs");
    std::fs::remove_file(&out).expect("the counts can be removed");
    let text = String::from_utf8_lossy(&annotated.stdout).into_owned();
    let mut counts = BTreeMap::new();
    for line in text.lines() {
        let Some((_, name)) = line.split_once("::stage_") else { continue };
        let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let number = line.split_whitespace().next().map(|number| number.replace(',', ""));
        if let Some(number) = number.and_then(|number| number.parse::<u64>().ok()) {
            // A function may stand in several lines, one a caller's file; the whole is the largest.
            let count: &mut u64 = counts.entry(name).or_default();
            *count = (*count).max(number / TIMES);
        }
    }
    Some(counts)
}

#[test]
fn no_stage_takes_more_instructions_than_the_table_says() {
    let Some(counts) = counted() else { return };
    let wanted = ["encode", "step", "field", "turns", "turns_small", "chain_f32", "chain_bf16", "chain_i8"];
    for stage in wanted {
        assert!(counts.get(stage).is_some_and(|count| *count > 1000), "{stage} was not counted: {counts:?}");
    }
    if std::env::var("MENISCUS_INSTRUCTIONS").is_ok_and(|value| value == "write") {
        let lines = wanted.map(|stage| format!("{stage} = {}\n", counts[stage])).concat();
        let head = "# Instructions of fixed work (crates/meniscus-cli/src/bench/work.rs), counted by callgrind with 128-bit vectors.\n\
                    # tests/instructions.rs holds the program against them; MENISCUS_INSTRUCTIONS=write writes them anew.\n";
        std::fs::write(table_path(), format!("{head}{lines}")).expect("the table can be written");
        return;
    }
    let text = std::fs::read_to_string(table_path()).expect("the table is there");
    let due: BTreeMap<&str, u64> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .filter_map(|line| line.split_once(" = ").and_then(|(name, count)| Some((name, count.parse().ok()?))))
        .collect();
    let mut off = Vec::new();
    for stage in wanted {
        let (is, was) = (counts[stage] as f64, due[stage] as f64);
        println!("{stage:12} {is:14.0} {:+.1} %", 100.0 * (is / was - 1.0));
        if (is / was - 1.0).abs() > TOLERANCE {
            off.push(format!("{stage}: {is:.0} instructions, the table says {was:.0}"));
        }
    }
    assert!(
        off.is_empty(),
        "{}; a wanted change writes the table anew, with the reason in the commit",
        off.join("; ")
    );
}
