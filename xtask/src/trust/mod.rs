//! `cargo xtask trust`: the attack tests by class, and the promises that they attack.
//!
//! ```text
//! tests/attacks/CLASS.rs --parsed--> promises (first line of each test's documentation)
//!         |                                  |
//!         '--run, or --results--> results ---+--> docs/trust.md, one table a class
//!                                            '--> checks: open attacks, classes, bombs, skips, exposure of the unit, mutants,
//!                                                   licences, crates of a board
//! ```

mod exposure;
mod licences;
mod mutants;
mod page;
mod promises;
mod results;

use crate::board;
use crate::report::{self, Check, Target};
use crate::workspace;
use anyhow::Result;
use clap::Args;
use promises::Promise;
use results::Outcome;
use std::path::PathBuf;

/// Fewest classes of attacks.
const CLASSES: f64 = 12.0;
/// Fewest attacks.
const ATTACKS: f64 = 40.0;
/// Classes whose attacks exhaust memory or time.
const BOMBS: [&str; 3] = ["bombs", "databases", "devices"];
/// Exposure of the unit by systemd's own measure, 0 to 10.
const EXPOSURE: f64 = 2.5;
/// The same with the drop-in that opens the network.
const EXPOSURE_NETWORK: f64 = 4.0;

#[derive(Args)]
pub(crate) struct Options {
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
    /// Only check that docs/trust.md lists the promises of the tests; run none.
    #[arg(long)]
    list: bool,
    /// Read the results of the attacks from a file, as the test command prints them, and run none. A skipped test is not seen
    /// there; where `CI` is set it has failed.
    #[arg(long, value_name = "FILE", conflicts_with = "list")]
    results: Option<PathBuf>,
}

/// Runs the verb; whether every check meets its target.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let promises = promises::read(&root)?;
    let checks = if options.list {
        vec![Check::count("promises_not_on_the_page", "promises", 0.0, page::missing(&root, &promises)?)]
    } else {
        let outcomes = match &options.results {
            Some(file) => results::read(file)?,
            None => results::run(&root)?,
        };
        page::write(&root, &promises, &outcomes)?;
        checks(&root, &promises, &outcomes)?
    };
    report::print(&checks, options.json);
    Ok(checks.iter().all(Check::ok))
}

/// The checks of a run of all attacks.
fn checks(root: &std::path::Path, promises: &[Promise], outcomes: &[Outcome]) -> Result<Vec<Check>> {
    let at_least = |name, value: usize, least| Check {
        name,
        value: value as f64,
        unit: "",
        target: Target::AtLeast(least),
        offenders: Vec::new(),
    };
    let passed = |promise: &&Promise| results::passed(outcomes, &promise.test());
    let named = |promise: &Promise| format!("tests/attacks/{}.rs: {}", promise.class, promise.name);
    let open: Vec<String> = promises.iter().filter(|promise| !passed(promise)).map(named).collect();
    let exhausts = |promise: &&Promise| BOMBS.contains(&promise.class.as_str());
    let bombs: Vec<&Promise> = promises.iter().filter(exhausts).collect();
    let loose: Vec<String> =
        bombs.iter().filter(|promise| !passed(promise)).map(|promise| named(promise)).collect();
    let mut classes: Vec<&str> = promises.iter().map(|promise| promise.class.as_str()).collect();
    classes.dedup();
    let skipped: Vec<String> =
        outcomes.iter().filter(|outcome| outcome.skipped).map(|outcome| outcome.test.clone()).collect();
    let mut checks = vec![
        at_least("attacks_total", promises.len(), ATTACKS),
        Check::count("attacks_open", "attacks", 0.0, open),
        at_least("attack_classes", classes.len(), CLASSES),
        Check {
            name: "container_bombs_bounded",
            value: (bombs.len() - loose.len()) as f64,
            unit: "bombs",
            target: Target::AtLeast(bombs.len().max(1) as f64),
            offenders: loose,
        },
        Check::count("skipped_in_ci", "tests", 0.0, skipped),
    ];
    checks.extend(exposure::checks(root, EXPOSURE, EXPOSURE_NETWORK)?);
    checks.push(mutants::check(root)?);
    checks.push(licences::check(root)?);
    // Its size takes a build of some minutes: `cargo xtask board`, of every night.
    checks.push(board::crates(root)?);
    Ok(checks)
}
