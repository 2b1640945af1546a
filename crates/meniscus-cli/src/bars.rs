//! Progress bars whose time left is not claimed before anything is done.

use indicatif::style::TemplateError;
use indicatif::{HumanDuration, ProgressBar, ProgressState, ProgressStyle};
use std::fmt::Write;

/// Whether the terminal moves no cursor, so that it gets plain lines: TERM=dumb, as in editors and logs.
pub(super) fn is_plain_terminal() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// Returns a bar of this length; a hidden one for a terminal that moves no cursor.
pub(super) fn bar(length: u64) -> ProgressBar {
    if is_plain_terminal() { ProgressBar::hidden() } else { ProgressBar::new(length) }
}

/// Returns a bar without a length; a hidden one for a terminal that moves no cursor.
pub(super) fn spinner() -> ProgressBar {
    if is_plain_terminal() { ProgressBar::hidden() } else { ProgressBar::new_spinner() }
}

/// Returns a style from a template, in which `{left}` is the time left.
pub(super) fn style(template: &str) -> Result<ProgressStyle, TemplateError> {
    Ok(ProgressStyle::with_template(template)?.with_key("left", left))
}

/// Writes the time left, or that it is not known yet.
fn left(state: &ProgressState, out: &mut dyn Write) {
    // A terminal that is gone is no reason to stop.
    let _shown = if state.pos() == 0 {
        write!(out, "starting")
    } else {
        write!(out, "{} left", HumanDuration(state.eta()))
    };
}
