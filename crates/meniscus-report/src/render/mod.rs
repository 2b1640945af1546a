//! The forms of a report.

mod html;
mod markdown;
mod text;

pub(crate) use html::html;
pub(crate) use markdown::markdown;
pub(crate) use text::text;

use crate::checks::Check;

/// Value of a check with five significant digits, the same in every form that is read later.
fn value(check: &Check) -> String {
    check.value.map_or("not measured".into(), |value| format!("{value:.4e}"))
}
