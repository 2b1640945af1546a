//! Programs of the package `meniscus-tests`, built as the README's test command builds them.
//!
//! Features of dependencies are united over all that is built at once. A build of one package has fewer of them than
//! `cargo test --workspace`, and compiles the training framework a second time.

use crate::process::{Step, cargo};
use crate::workspace;
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};

/// Builds the program `name` in a profile of cargo, with cargo's messages on standard error, and returns its path.
pub(crate) fn program(root: &Path, profile: &str, name: &str) -> Result<PathBuf> {
    // One test, so that cargo counts the dependencies of tests in, as it does for the test command.
    let tests = ["--workspace", "--test", "docs"];
    let cargo = cargo();
    let words = [cargo.as_str(), "build", "--locked", "--profile", profile, "--bin", name];
    let step = Step::new("program", words.into_iter().chain(tests));
    let status = step.command(root)?.status()?;
    ensure!(status.success(), "`{}` failed; its messages stand above", step.line());
    let folder = if profile == "dev" { "debug" } else { profile };
    Ok(workspace::target(root).join(folder).join(name))
}
