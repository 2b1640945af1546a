//! Values with their targets, as a table or as JSON.

use serde_json::{Value, json};

/// A value with its target.
#[derive(Clone, Debug)]
pub(crate) struct Check {
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) target: String,
    /// Whether the target is met; none without a target.
    pub(crate) ok: Option<bool>,
}

impl Check {
    /// Whether nothing is wrong: the target is met, or there is none.
    pub(crate) fn passed(&self) -> bool {
        self.ok != Some(false)
    }
}

/// Returns a check whose verdict is known.
pub(crate) fn check(name: &str, value: f64, unit: &str, target: &str, ok: bool) -> Check {
    Check { name: name.into(), value, unit: unit.into(), target: target.into(), ok: Some(ok) }
}

/// Returns a value without a target. One that is not known is wrong all the same.
pub(crate) fn informational(name: &str, value: f64, unit: &str) -> Check {
    Check { ok: (!value.is_finite()).then_some(false), ..check(name, value, unit, "informational", true) }
}

/// Returns the check of a condition: its value is 1 where the condition holds.
pub(crate) fn must(name: &str, so: bool) -> Check {
    check(name, f64::from(u8::from(so)), "1", "= 1", so)
}

/// Returns the check of a value that may not be above a limit; NaN misses it.
pub(crate) fn at_most(name: &str, value: f64, unit: &str, limit: f64) -> Check {
    check(name, value, unit, &format!("<= {limit}"), value <= limit)
}

/// Returns the array `checks` of a report.
pub(crate) fn json(checks: &[Check]) -> Value {
    let one = |check: &Check| {
        let Check { name, value, unit, target, ok } = check;
        let value = value.is_finite().then_some(*value);
        json!({ "name": name, "value": value, "unit": unit, "target": target, "ok": ok })
    };
    checks.iter().map(one).collect()
}

/// Prints a line for each check.
pub(crate) fn print(checks: &[Check]) {
    for Check { name, value, unit, target, ok } in checks {
        let verdict = ok.map_or("", |ok| if ok { "ok" } else { "MISSED" });
        println!("{name:<30} {value:>12.4} {unit:<3} {target:<18} {verdict}");
    }
}
