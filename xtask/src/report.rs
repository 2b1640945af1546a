//! Measured values with their targets, as a table and as JSON.

use serde_json::{Value, json};
use std::fmt::Write as _;

/// Bound that a value has to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    AtMost(f64),
    AtLeast(f64),
}

impl Target {
    fn met_by(self, value: f64) -> bool {
        match self {
            Self::AtMost(bound) => value <= bound,
            Self::AtLeast(bound) => value >= bound,
        }
    }

    fn text(self) -> String {
        match self {
            Self::AtMost(bound) => format!("<= {}", number(bound)),
            Self::AtLeast(bound) => format!(">= {}", number(bound)),
        }
    }
}

/// Measured value with its target, and the places that are to be mended if it is missed.
#[derive(Clone, Debug)]
pub(crate) struct Check {
    pub(crate) name: &'static str,
    pub(crate) value: f64,
    pub(crate) unit: &'static str,
    pub(crate) target: Target,
    /// One line each, `FILE:LINE: reason` where there is a file.
    pub(crate) offenders: Vec<String>,
}

impl Check {
    /// A count of offenders of which there may be `most`.
    pub(crate) fn count(name: &'static str, unit: &'static str, most: f64, offenders: Vec<String>) -> Self {
        Self { name, value: offenders.len() as f64, unit, target: Target::AtMost(most), offenders }
    }

    /// Whether the target is met.
    pub(crate) fn ok(&self) -> bool {
        self.target.met_by(self.value)
    }
}

/// Prints the checks on standard output, as a table or as JSON.
pub(crate) fn print(checks: &[Check], as_json: bool) {
    if as_json {
        println!("{}", json(checks));
    } else {
        print!("{}", table(checks));
    }
}

/// The checks as lines of text, the offenders below each that misses its target.
fn table(checks: &[Check]) -> String {
    let mut text = String::new();
    for check in checks {
        let verdict = if check.ok() { "ok" } else { "MISSED" };
        let value = format!("{} {}", number(check.value), check.unit);
        let _ = writeln!(text, "{:<40} {value:>22} {:>12}  {verdict}", check.name, check.target.text());
        if !check.ok() {
            for offender in &check.offenders {
                let _ = writeln!(text, "    {offender}");
            }
        }
    }
    text
}

/// The checks as one JSON object, in the form that all commands of the project print.
fn json(checks: &[Check]) -> Value {
    let one = |check: &Check| {
        json!({"name": check.name, "value": check.value, "unit": check.unit, "target": check.target.text(),
               "ok": check.ok(), "offenders": if check.ok() { &[][..] } else { &check.offenders[..] }})
    };
    json!({"checks": checks.iter().map(one).collect::<Vec<_>>()})
}

/// A number without digits that say nothing.
fn number(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.3}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_target_is_said_and_its_offenders_are_listed() {
        let good = Check::count("good", "", 1.0, vec!["a.rs:1: fine".to_owned()]);
        let bad = Check::count("bad", "", 0.0, vec!["b.rs:2: wrong".to_owned()]);
        assert!(good.ok() && !bad.ok());
        let text = table(&[good.clone(), bad.clone()]);
        assert!(
            text.contains("MISSED") && text.contains("b.rs:2: wrong") && !text.contains("a.rs"),
            "{text}"
        );
        let value = json(&[good, bad]);
        assert_eq!(value["checks"][0]["ok"], true);
        assert_eq!(value["checks"][1]["ok"], false);
        assert_eq!(value["checks"][1]["offenders"][0], "b.rs:2: wrong");
    }

    #[test]
    fn a_lower_bound_is_missed_from_below() {
        let check =
            Check { value: 0.5, target: Target::AtLeast(1.0), ..Check::count("x", "", 0.0, Vec::new()) };
        assert!(!check.ok());
        assert!(Check { value: 1.0, ..check }.ok());
    }
}
