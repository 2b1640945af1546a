//! `cargo xtask house`: measures of the architecture, each with a target.
//!
//! | measure | file |
//! |---|---|
//! | `crates`, `upward_imports` | `layers` |
//! | `file_cycles_between_modules`, `file_cycles_inside_crates` | `imports`, `cycles` |
//! | `largest_crate_share` | `shares` |
//! | `tuple_parameters_per_10k`, `functions_over_80_lines` | `functions` |
//! | `duplicate_public_type_names_in_a_crate` | `type_names` |
//! | `rustdoc_examples` | `entry_points`, `examples` |
//! | `largest_embedded_bytes` | `embedded` |
//! | `rebuild_core_cpu_s`, `rebuild_cli_after_leaf_edit_cpu_s` | `rebuild` |
//!
//! Targets that are missed today stand in `xtask/house.json` with their value. CI runs `--no-worse`: no measure may move
//! away from its target, and a value in that file that is no longer needed has to go.

mod cycles;
mod embedded;
mod entry_points;
mod examples;
mod functions;
mod imports;
mod layers;
mod rebuild;
mod shares;
mod sources;
mod type_names;

use crate::baseline::{self, Accepted};
use crate::report::{self, Check};
use crate::workspace;
use anyhow::Result;
use clap::Args;

/// Missed targets of the architecture that CI accepts.
const ACCEPTED: Accepted = Accepted("xtask/house.json");

/// Options of `cargo xtask house`.
#[derive(Args)]
pub(crate) struct Options {
    /// One JSON object on standard output instead of the table.
    #[arg(long)]
    json: bool,
    /// Measure what an edit costs, too: two release builds after the first, minutes.
    #[arg(long)]
    rebuild: bool,
    /// Fail only where a missed target is further away than `xtask/house.json` says: for CI.
    #[arg(long)]
    no_worse: bool,
}

/// Measures, prints, and returns whether every target was met.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let checks = measure(options.rebuild)?;
    report::print(&checks, options.json);
    if options.no_worse {
        return baseline::no_worse(&checks, &ACCEPTED);
    }
    Ok(checks.iter().all(Check::ok))
}

fn measure(rebuild: bool) -> Result<Vec<Check>> {
    let root = workspace::root()?;
    let packages = workspace::packages(&root)?;
    let all = sources::read_all(&root, &packages)?;
    let trees = sources::trees(&packages, &all);
    let mut checks = vec![layers::crates(&root, &packages), layers::upward_imports(&packages)];
    checks.extend(cycles::checks(&root, &trees));
    checks.push(shares::check(&all));
    checks.extend(functions::checks(&all));
    checks.push(type_names::check(&root, &trees));
    checks.push(examples::check(&root, &trees));
    checks.push(embedded::check(&root, &all)?);
    if rebuild {
        checks.extend(rebuild::checks(&root)?);
    }
    Ok(checks)
}
