//! `cargo xtask ci`: the script that hosted CI runs, `.ci/run`.

use crate::process::{self, Step};
use crate::workspace;
use anyhow::Result;

/// Runs `.ci/run` and returns whether it passed.
pub(crate) fn run() -> Result<bool> {
    let step = Step::new("ci", [".ci/run"]);
    Ok(process::timed(&workspace::root()?, &step)?.passed)
}
