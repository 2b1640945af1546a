//! The share of mutants that tests notice, from the newest log of mutation testing. A run takes hours.

use crate::report::{Check, Target};
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Least share of the mutants that were tried.
const LEAST: f64 = 0.9;
/// End of the logs' names, behind their date.
const LOGS: &str = "-mutants.log";
/// Line of a log with its sums.
const SUMS: &str = "== together: ";

/// The check, by the newest log in `docs/nightly`.
pub(super) fn check(root: &Path) -> Result<Check> {
    let path = newest(&root.join("docs/nightly"))?;
    let text = fs::read_to_string(&path).with_context(|| format!("{} cannot be read", path.display()))?;
    let share = share(&text).with_context(|| {
        format!("{} has no line `{SUMS}N viable mutants tried, N caught`", path.display())
    })?;
    Ok(Check {
        name: "mutants_caught_share",
        value: share,
        unit: "by the log",
        target: Target::AtLeast(LEAST),
        offenders: vec![path.display().to_string()],
    })
}

/// The log of the last date.
fn newest(folder: &Path) -> Result<PathBuf> {
    let files = fs::read_dir(folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let logs = files.filter_map(|file| Some(file.ok()?.path()));
    let logs = logs.filter(|path| path.to_string_lossy().ends_with(LOGS));
    logs.max().with_context(|| format!("{} has no log of mutation testing", folder.display()))
}

/// Caught over tried of the sums of a log.
fn share(log: &str) -> Option<f64> {
    let sums = log.lines().find_map(|line| line.strip_prefix(SUMS))?;
    let (tried, rest) = sums.split_once(" viable mutants tried, ")?;
    let (caught, _) = rest.split_once(" caught")?;
    let [tried, caught]: [f64; 2] = [tried.parse().ok()?, caught.parse().ok()?];
    (tried > 0.0).then_some(caught / tried)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sums_of_a_log_give_its_share() {
        let log = "date 2026\n== together: 40 viable mutants tried, 38 caught, share 0.950; rest\n";
        assert_eq!(share(log), Some(0.95));
        assert_eq!(share("== together: 0 viable mutants tried, 0 caught"), None);
        assert_eq!(share("40 tried"), None);
    }
}
