//! `cargo xtask mutants`: known mistakes put into a copy of the workspace one at a time, each of which a test has to notice.
//!
//! The fixed sample of CI: the mistakes that an audit found unnoticed. `cargo mutants` tries all mutations of a file, which
//! takes hours (`cargo xtask nightly --only mutants`).

mod copied_tree;
mod mutations;

use crate::process::{Step, cargo};
use crate::report::{self, Check};
use crate::workspace;
use anyhow::{Context, Result, ensure};
use clap::Args;
use copied_tree::CopiedTree;
use mutations::{MUTATIONS, Mutation, Tests};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Instant;

/// Options of `cargo xtask mutants`.
#[derive(Args)]
pub(crate) struct Options {
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Only mutations of files whose path contains this.
    #[arg(long, value_name = "PATH")]
    only: Option<String>,
}

/// Outcome of a mutation.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    /// A test has failed.
    Caught,
    /// All tests have passed.
    Survived,
    /// The text to be replaced does not stand there exactly once, or what replaces it does not compile.
    Unusable(&'static str),
}

/// Runs the verb; whether every mutation was caught.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let target = workspace::target(&root);
    let copy = CopiedTree::of(&root, &target.join("mutants/tree"))?;
    let tester = Tester { folder: copy.root().to_owned(), target };
    let in_path =
        |mutation: &&Mutation| options.only.as_ref().is_none_or(|part| mutation.file.contains(part));
    let chosen: Vec<&Mutation> = MUTATIONS.iter().filter(in_path).collect();
    let mut sets: Vec<Tests> = Vec::new();
    for Mutation { tests, .. } in &chosen {
        if !sets.contains(tests) {
            sets.push(*tests);
            ensure!(tester.outcome(*tests)? == Outcome::Survived, "{tests:?} fails without a mutation");
        }
    }
    let mut survivors = Vec::new();
    for mutation in chosen {
        let begin = Instant::now();
        let outcome = attempt(&copy, &tester, mutation)?;
        let took = begin.elapsed().as_secs_f64();
        eprintln!("{outcome:?} in {took:.1} s: {}: {}", mutation.file, mutation.mistake);
        if outcome != Outcome::Caught {
            survivors.push(format!("{}: {}: {outcome:?}", mutation.file, mutation.mistake));
        }
    }
    let checks = [Check::count("mutants_of_the_sample_not_caught", "mutants", 0.0, survivors)];
    report::print(&checks, options.json);
    Ok(checks.iter().all(Check::ok))
}

/// Tries one mutation, and takes it back.
fn attempt(copy: &CopiedTree, tester: &Tester, mutation: &Mutation) -> Result<Outcome> {
    let Some(mutated) = copy.mutated(mutation)? else {
        return Ok(Outcome::Unusable("the text to replace does not stand there once"));
    };
    let outcome = tester.outcome(mutation.tests)?;
    drop(mutated);
    Ok(outcome)
}

/// Tests of the copy. Its own crates are built quickly and in parts; the crates of others are those that the checkout's tests
/// have built.
struct Tester {
    folder: PathBuf,
    target: PathBuf,
}

/// Settings of what is built anew with each mutant: optimised little.
const QUICKLY_BUILT: [&str; 3] = [
    "profile.release.incremental=true",
    "profile.release.package.meniscus.opt-level=1",
    "profile.release.package.meniscus-core-tests.opt-level=1",
];

impl Tester {
    /// Returns the outcome of `cargo test` of `tests`.
    fn outcome(&self, tests: Tests) -> Result<Outcome> {
        let words = ["test", "--release", "--locked", "--quiet"];
        let of_tests = match tests {
            Tests::Unit => vec!["-p", "meniscus", "--lib"],
            // Of the whole workspace, so that features are united as for the checkout's tests.
            Tests::Core(name) => vec!["--workspace", "--test", name],
        };
        let program = cargo();
        let quickly = QUICKLY_BUILT.iter().flat_map(|setting| ["--config", setting]);
        let words = [program.as_str()].into_iter().chain(words).chain(quickly).chain(of_tests);
        let step = Step::new("mutant", words).with("CARGO_TARGET_DIR", &shown(&self.target));
        let mut command = step.command(&self.folder)?;
        command.stdout(Stdio::null());
        let output = command.output().with_context(|| format!("`{}` did not start", step.line()))?;
        // Cargo ends alike when nothing could be compiled and when a test has failed; its last line differs.
        let failed = String::from_utf8_lossy(&output.stderr).contains("test failed");
        Ok(match (output.status.success(), failed) {
            (true, _) => Outcome::Survived,
            (false, true) => Outcome::Caught,
            (false, false) => Outcome::Unusable("it does not compile"),
        })
    }
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mutation whose text is gone tests nothing. It is mended with the file.
    #[test]
    fn every_mutation_applies_to_the_sources() {
        let root = workspace::root().expect("the repository");
        for Mutation { file, old, new, mistake, .. } in &MUTATIONS {
            let text = std::fs::read_to_string(root.join(file)).expect(file);
            assert_eq!(
                text.matches(old).count(),
                1,
                "{file}: {mistake}: mend xtask/src/mutants/mutations.rs"
            );
            assert_ne!(old, new, "{file}: {mistake}");
        }
    }
}
