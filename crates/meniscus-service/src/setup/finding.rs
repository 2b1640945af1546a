//! A check of an inspection with its remedy.

use meniscus_report::checks::Check;

/// One check with what to do if it is missed.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The check.
    pub check: Check,
    /// Action for a person.
    pub remedy: String,
}

/// Returns a check with its remedy.
pub(super) fn finding(check: Check, remedy: &str) -> Finding {
    Finding { check, remedy: remedy.into() }
}
