//! Shares of trials.

/// Returns the share of `flags` that are set; not measured where there is none.
pub(super) fn share_set(flags: impl Iterator<Item = bool>) -> f64 {
    let flags: Vec<bool> = flags.collect();
    if flags.is_empty() {
        return f64::NAN;
    }
    flags.iter().filter(|flag| **flag).count() as f64 / flags.len() as f64
}
