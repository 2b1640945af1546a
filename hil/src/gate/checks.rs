//! Values with their targets, as a table or as JSON.

use serde_json::{Value, json};

/// Name, value, unit, target, and whether it is met.
#[derive(Clone, Debug)]
pub(crate) struct Check(
    pub(crate) String,
    pub(crate) f64,
    pub(crate) String,
    pub(crate) String,
    pub(crate) bool,
);

pub(crate) fn check(name: &str, value: f64, unit: &str, target: &str, ok: bool) -> Check {
    Check(name.into(), value, unit.into(), target.into(), ok)
}

/// Something that has to be so: 1 when it is.
pub(crate) fn must(name: &str, so: bool) -> Check {
    check(name, f64::from(u8::from(so)), "1", "= 1", so)
}

/// A value that may not be above a limit; one that is no number misses.
pub(crate) fn at_most(name: &str, value: f64, unit: &str, limit: f64) -> Check {
    check(name, value, unit, &format!("<= {limit}"), value <= limit)
}

/// The array `checks` of a report.
pub(crate) fn json(checks: &[Check]) -> Value {
    let one = |Check(name, value, unit, target, ok): &Check| {
        let value = value.is_finite().then_some(*value);
        json!({ "name": name, "value": value, "unit": unit, "target": target, "ok": ok })
    };
    checks.iter().map(one).collect()
}

/// A line each.
pub(crate) fn print(checks: &[Check]) {
    for Check(name, value, unit, target, ok) in checks {
        println!("{name:<30} {value:>12.4} {unit:<3} {target:<18} {}", if *ok { "ok" } else { "MISSED" });
    }
}
