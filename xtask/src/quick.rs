//! `cargo xtask quick`: the loop of an edit. Format, lints and unit tests of what changed against HEAD.

use crate::process::{self, Step, cargo};
use crate::workspace::{self, Package};
use anyhow::Result;
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Wall time within which an edit of the core should be checked, its dependencies compiled.
const TARGET: Duration = Duration::from_secs(60);

/// Options of `cargo xtask quick`.
#[derive(Args)]
pub(crate) struct Options {
    /// Check the crates that depend on the changed ones, too.
    #[arg(long)]
    dependants: bool,
}

/// Runs the steps and returns whether all passed. It stops at the first that fails: its messages stay at the end.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let packages = workspace::packages(&root)?;
    let mut chosen = changed_packages(&packages, &root, &changed_files(&root)?);
    if options.dependants {
        chosen = with_dependants(&packages, chosen);
    }
    if chosen.is_empty() {
        println!("no crate differs from HEAD; only the format is checked");
    }
    let begin = Instant::now();
    for step in steps(&packages, &chosen) {
        if !process::timed(&root, &step)?.passed {
            return Ok(false);
        }
    }
    let took = begin.elapsed();
    println!("quick: {:.1} s for {}", took.as_secs_f64(), chosen.join(", "));
    if took > TARGET && !options.dependants {
        println!("quick: longer than {} s; the first run compiles dependencies", TARGET.as_secs());
    }
    Ok(true)
}

/// Files that differ from HEAD or are new.
fn changed_files(root: &Path) -> Result<Vec<PathBuf>> {
    let differing = process::output(root, ["git", "diff", "--name-only", "HEAD"])?;
    let new = process::output(root, ["git", "ls-files", "--others", "--exclude-standard"])?;
    Ok(differing.lines().chain(new.lines()).map(|path| root.join(path)).collect())
}

/// Names of the packages that own the files, in the order of the workspace.
fn changed_packages(packages: &[Package], root: &Path, files: &[PathBuf]) -> Vec<String> {
    let owners: Vec<&str> = files
        .iter()
        .filter_map(|file| workspace::owner(packages, root, file))
        .map(|package| package.name.as_str())
        .collect();
    let names = packages.iter().map(|package| &package.name);
    names.filter(|name| owners.contains(&name.as_str())).cloned().collect()
}

/// The packages and all that depend on them, directly or not.
fn with_dependants(packages: &[Package], mut chosen: Vec<String>) -> Vec<String> {
    loop {
        let depends = |package: &&Package| {
            !chosen.contains(&package.name) && package.members.iter().any(|member| chosen.contains(member))
        };
        let more: Vec<String> = packages.iter().filter(depends).map(|p| p.name.clone()).collect();
        if more.is_empty() {
            return chosen;
        }
        chosen.extend(more);
    }
}

/// Format of the whole workspace, then lints and unit tests of the chosen packages.
fn steps(packages: &[Package], chosen: &[String]) -> Vec<Step> {
    let cargo = cargo();
    let mut steps = vec![Step::new("format", [cargo.as_str(), "fmt", "--all", "--check"])];
    let mut add = |name: &str, verb: &str, names: &[&String], rest: &[&str]| {
        let mut words = vec![cargo.clone(), verb.to_owned()];
        words.extend(names.iter().flat_map(|name| ["-p".to_owned(), (*name).clone()]));
        words.extend(rest.iter().map(|word| (*word).to_owned()));
        steps.push(Step::new(name, words));
    };
    let all: Vec<&String> = chosen.iter().collect();
    if !all.is_empty() {
        add("lints", "clippy", &all, &["--all-targets", "--", "-D", "warnings"]);
    }
    // `--lib` refuses a package without a library.
    let with_library = |name: &&String| packages.iter().any(|p| p.name == **name && p.has_library);
    let libraries: Vec<&String> = chosen.iter().filter(with_library).collect();
    if !libraries.is_empty() {
        add("unit tests", "test", &libraries, &["--lib"]);
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn package(name: &str, members: &[&str]) -> Package {
        Package {
            name: name.to_owned(),
            folder: PathBuf::from(format!("/w/crates/{name}")),
            roots: Vec::new(),
            has_library: name != "program",
            members: members.iter().map(|&member| member.to_owned()).collect(),
            published: true,
            manifest: Value::Null,
        }
    }

    #[test]
    fn an_edit_selects_its_crate_and_on_request_what_depends_on_it() {
        let packages = [package("low", &[]), package("middle", &["low"]), package("program", &["middle"])];
        let file = |path: &str| PathBuf::from(path);
        let edited = [file("/w/crates/low/src/a.rs"), file("/w/README.md")];
        let chosen = changed_packages(&packages, Path::new("/w"), &edited);
        assert_eq!(chosen, ["low"]);
        assert_eq!(with_dependants(&packages, chosen), ["low", "middle", "program"]);
    }

    #[test]
    fn a_program_without_library_is_linted_and_not_unit_tested() {
        let packages = [package("low", &[]), package("program", &["low"])];
        let lines: Vec<String> =
            steps(&packages, &["program".to_owned(), "low".to_owned()]).iter().map(Step::line).collect();
        assert!(lines[1].contains("-p program -p low --all-targets"), "{lines:?}");
        assert!(lines[2].ends_with("test -p low --lib"), "{lines:?}");
        assert_eq!(steps(&packages, &[]).len(), 1);
    }
}
