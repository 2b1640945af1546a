//! `cargo xtask words`: measures of the language, each with a target.
//!
//! | measure | file |
//! |---|---|
//! | `readme_words`, `readme_numbers_per_100_words`, `first_command_word`, `readme_status_word` | `readme` |
//! | `sentence_words_mean`, `sentence_words_longest` | `sentences` |
//! | `forbidden_words` | `senses` (the list), `forbidden`, `literals` |
//! | `doc_lines_starting_with_what_or_how` | `doc_comments` |
//! | `help_orphan_lines`, `help_lines_over_80` | `program`, `help` |
//! | `docs_commands_that_exist` | `commands` |
//!
//! Targets that are missed today stand in `xtask/words.json` with their value; CI runs `--no-worse`, as for
//! `cargo xtask house`.

mod commands;
mod doc_comments;
mod forbidden;
mod help;
mod literals;
mod markdown;
mod pages;
mod program;
mod readme;
mod senses;
mod sentences;

use crate::baseline::{self, Accepted};
use crate::report::{self, Check};
use crate::workspace;
use anyhow::{Context, Result};
use clap::Args;

/// Missed targets of the language that CI accepts.
const ACCEPTED: Accepted = Accepted("xtask/words.json");

/// Options of `cargo xtask words`.
#[derive(Args)]
pub(crate) struct Options {
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Fail only where a missed target is further away than `xtask/words.json` says: for CI.
    #[arg(long)]
    no_worse: bool,
    /// Profile in which the program with the help texts is built; the tests are built in `release`, too.
    #[arg(long, default_value = "release")]
    profile: String,
}

/// Measures, prints, and returns whether every target was met.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let checks = measure(&options.profile)?;
    report::print(&checks, options.json);
    if options.no_worse {
        return baseline::no_worse(&checks, &ACCEPTED);
    }
    Ok(checks.iter().all(Check::ok))
}

fn measure(profile: &str) -> Result<Vec<Check>> {
    let root = workspace::root()?;
    let pages = pages::read(&root)?;
    let comments = doc_comments::read(&root)?;
    let program = program::read(&root, profile)?;
    let readme = pages.first().context("there is no README.md")?;
    let mut checks = Vec::from(readme::checks(readme));
    checks.extend(sentences::checks(&pages));
    checks.push(forbidden::check(&pages, &comments, &literals::read(&root)?));
    checks.push(doc_comments::check(&comments));
    checks.extend(help::checks(&program));
    checks.push(commands::check(&pages, &program));
    Ok(checks)
}
