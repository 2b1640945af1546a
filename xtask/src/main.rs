//! `cargo xtask`: checks of the project that are more than one cargo command.
//!
//! | verb | purpose |
//! |---|---|
//! | `quick` | format, lints and unit tests of the crates that an edit touched |
//! | `ci` | everything that hosted CI runs |
//! | `nightly` | steps that take hours, with a log |
//! | `house` | measures of the architecture, with targets |
//! | `words` | measures of the language, with targets |
//! | `trust` | attacks on the program, by class, and the page of promises |
//! | `under-attack` | runs of the program with and without attackers, in turn |
//! | `mutants` | known mistakes put into a copy of the core, each of which a test has to notice |
//! | `board` | crates and size of the program of a board |
//! | `package` | archives of the published crates |
//! | `book` | the pages of `docs/` as a book with search |
//! | `tutorial` | every chapter of the tutorial without a camera |

mod baseline;
mod board;
mod book;
mod built;
mod ci;
mod house;
mod mutants;
mod nightly;
mod package;
mod process;
mod quick;
mod report;
mod trust;
mod under_attack;
mod words;
mod workspace;

use anyhow::Result;
use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Checks of the project that are more than one cargo command.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// Format, lints and unit tests of the crates that changed against HEAD.
    Quick(quick::Options),
    /// All of CI: `.ci/run`.
    Ci,
    /// Steps that take hours, logged to docs/nightly/DATE.log.
    Nightly(nightly::Options),
    /// Measures of the architecture; fails if one misses its target.
    House(house::Options),
    /// Measures of README, docs, help texts and doc comments; fails if one misses its target.
    Words(words::Options),
    /// Attacks on the program; writes docs/trust.md and fails if a promise is broken.
    Trust(trust::Options),
    /// Runs of the program with and without attackers; fails if they slow it, mislead it or get in.
    UnderAttack(under_attack::Options),
    /// Known mistakes put into a copy of the core; fails if the tests do not notice one.
    Mutants(mutants::Options),
    /// Crates and size of the program of a board, which it builds; fails if one misses its target.
    Board(board::Options),
    /// Archives of all published crates, checked for their files and metadata.
    Package(package::Options),
    /// The pages of docs/ as a book with search, in target/book; fails if a link leads nowhere.
    Book,
    /// Every chapter of docs/tutorial.md without a camera, answers compared; takes a quarter of an hour or more.
    Tutorial,
}

fn main() -> Result<ExitCode> {
    let passed = match Arguments::parse().verb {
        Verb::Quick(options) => quick::run(&options)?,
        Verb::Ci => ci::run()?,
        Verb::Nightly(options) => nightly::run(&options)?,
        Verb::House(options) => house::run(&options)?,
        Verb::Words(options) => words::run(&options)?,
        Verb::Trust(options) => trust::run(&options)?,
        Verb::UnderAttack(options) => under_attack::run(&options)?,
        Verb::Mutants(options) => mutants::run(&options)?,
        Verb::Board(options) => board::run(&options)?,
        Verb::Package(options) => package::run(&options)?,
        Verb::Book => book::run()?,
        Verb::Tutorial => tutorial()?,
    };
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Runs the test of the tutorial with all chapters.
fn tutorial() -> Result<bool> {
    let cargo = process::cargo();
    let words =
        [cargo.as_str(), "test", "--release", "--workspace", "--test", "tutorial", "--", "--nocapture"];
    let step = process::Step::new("tutorial", words).with("MENISCUS_TUTORIAL", "all");
    Ok(process::timed(&workspace::root()?, &step)?.passed)
}
