//! Values of missed targets that CI accepts, until they are mended.

use crate::report::{Check, Target};
use crate::workspace;
use anyhow::{Context, Result};
use std::collections::BTreeMap;

/// Accepted value of each measure that misses its target.
type Baseline = BTreeMap<String, f64>;

/// Path of a file with accepted values, from the root of the repository.
pub(crate) struct Accepted(pub(crate) &'static str);

impl Accepted {
    fn read(&self) -> Result<Baseline> {
        let path = workspace::root()?.join(self.0);
        let text =
            std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        serde_json::from_str(&text).with_context(|| format!("{} is not an object of numbers", path.display()))
    }
}

/// Returns whether no check is worse than the file accepts, and prints those that are.
pub(crate) fn no_worse(checks: &[Check], accepted: &Accepted) -> Result<bool> {
    let worse = worse(checks, &accepted.read()?, accepted.0);
    worse.iter().for_each(|line| eprintln!("{line}"));
    Ok(worse.is_empty())
}

/// Returns one line for each measure that is worse than `baseline`, and for each accepted value that a target has overtaken.
fn worse(checks: &[Check], baseline: &Baseline, file: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for check in checks {
        let accepted = baseline.get(check.name);
        match accepted {
            None if !check.ok() => lines.push(format!("{}: {} misses its target", check.name, check.value)),
            Some(accepted) if check.ok() => {
                lines.push(format!("{}: the target is met; take {accepted} out of {file}", check.name));
            }
            Some(accepted) if further(check, *accepted) => lines.push(format!(
                "{}: {} is worse than {accepted}, which {file} accepts",
                check.name, check.value
            )),
            _ => {}
        }
    }
    lines
}

/// Whether the value is further from its target than `accepted`. Values are compared as they are printed.
fn further(check: &Check, accepted: f64) -> bool {
    const PRINTED: f64 = 5e-4;
    match check.target {
        Target::AtMost(_) => check.value > accepted + PRINTED,
        Target::AtLeast(_) => check.value < accepted - PRINTED,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "xtask/sample.json";

    fn check(name: &'static str, value: f64, target: Target) -> Check {
        Check { name, value, unit: "", target, offenders: Vec::new() }
    }

    #[test]
    fn a_value_may_stay_or_come_nearer_but_not_go_away() {
        let baseline = Baseline::from([("cycles".to_owned(), 4.0), ("examples".to_owned(), 0.75)]);
        let of = |cycles: f64, examples: f64| {
            let checks = [
                check("cycles", cycles, Target::AtMost(0.0)),
                check("examples", examples, Target::AtLeast(1.0)),
            ];
            worse(&checks, &baseline, FILE).len()
        };
        assert_eq!(of(4.0, 0.75), 0);
        assert_eq!(of(3.0, 0.8), 0);
        assert_eq!(of(5.0, 0.7), 2);
        assert_eq!(of(0.0, 0.75), 1, "a target that is met leaves the file");
    }

    #[test]
    fn a_miss_that_is_not_accepted_fails() {
        let lines = worse(&[check("crates", 3.0, Target::AtLeast(10.0))], &Baseline::new(), FILE);
        assert_eq!(lines, ["crates: 3 misses its target"]);
    }
}
