//! Progress bars whose time left is not claimed before anything is done.

use indicatif::style::TemplateError;
use indicatif::{HumanDuration, ProgressState, ProgressStyle};
use std::fmt::Write;

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
