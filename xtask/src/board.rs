//! `cargo xtask board`: the program of a board, its crates and its size.
//!
//! A board has the command `meniscus` without its features: a camera on the bus, set-up, flash slots, service and publishing. The
//! Debian package of a board holds it, built with the profile `board`.

use crate::process::{cargo, command, output};
use crate::report::{self, Check, Target};
use crate::workspace;
use anyhow::{Context, Result, ensure};
use clap::Args;
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Stdio;

/// Package and features of the program.
const PROGRAM: [&str; 3] = ["-p", "meniscus-cli", "--no-default-features"];
/// Most crates, those of the project and procedural macros included, those of build scripts not.
const CRATES: f64 = 120.0;
/// Largest program, stripped, MiB.
const SIZE_MIB: f64 = 12.0;

#[derive(Args)]
pub(crate) struct Options {
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Build for this target, as aarch64-unknown-linux-gnu, in place of this machine's.
    #[arg(long)]
    target: Option<String>,
}

/// Runs the verb; whether every check meets its target.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let checks = [crates(&root)?, size(&root, options.target.as_deref())?];
    report::print(&checks, options.json);
    Ok(checks.iter().all(Check::ok))
}

/// Returns the check of the crates that the program consists of. It builds nothing.
pub(crate) fn crates(root: &Path) -> Result<Check> {
    let words = ["tree", "--locked", "-e", "normal", "--prefix", "none", "--format", "{p}"];
    let tree = output(root, std::iter::once(cargo().as_str()).chain(words).chain(PROGRAM))?;
    let found = names(&tree);
    ensure!(found.len() > 1, "cargo tree lists no crates");
    let value = found.len() as f64;
    Ok(Check {
        name: "board_crates",
        value,
        unit: "crates",
        target: Target::AtMost(CRATES),
        offenders: found.into_iter().collect(),
    })
}

/// Returns the crates in the output of `cargo tree`, each version once.
fn names(tree: &str) -> BTreeSet<String> {
    let of_line = |line: &str| {
        let mut words = line.split_whitespace();
        Some(format!("{} {}", words.next()?, words.next()?))
    };
    tree.lines().filter_map(of_line).collect()
}

/// Builds the program and returns the check of its size.
fn size(root: &Path, triple: Option<&str>) -> Result<Check> {
    let mut build = command(&cargo());
    build
        .args(["build", "--locked", "--profile", "board", "--bin", "meniscus"])
        .args(PROGRAM)
        .current_dir(root);
    let mut folder = workspace::target(root);
    if let Some(triple) = triple {
        build.args(["--target", triple]);
        folder = folder.join(triple);
    }
    ensure!(build.stdout(Stdio::null()).status()?.success(), "the program of a board does not build");
    let path = folder.join("board/meniscus");
    let bytes = std::fs::metadata(&path).with_context(|| path.display().to_string())?.len();
    Ok(Check {
        name: "board_binary_mib",
        value: bytes as f64 / f64::from(1 << 20),
        unit: "MiB",
        target: Target::AtMost(SIZE_MIB),
        offenders: vec![format!("{}: {bytes} bytes", path.display())],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_crate_counts_once_and_two_versions_count_twice() {
        let tree = "meniscus-cli v0.1.0 (/w)\nsyn v2.0.1 (proc-macro)\nsyn v3.0.0\nsyn v3.0.0 (*)\n\n";
        assert_eq!(names(tree).len(), 3);
    }

    #[test]
    fn the_program_of_a_board_has_few_crates() {
        let check = crates(&workspace::root().expect("the repository")).expect("cargo tree");
        assert!(check.ok() && check.value > 50.0, "{check:?}");
    }
}
