//! Findings of an inspection by `meniscus setup`.

use meniscus_service::setup::Inspection;

/// Names of the checks that were missed.
pub(crate) fn missed(inspection: &Inspection) -> Vec<&str> {
    let missed = inspection.findings.iter().filter(|finding| finding.check.missed());
    missed.map(|finding| finding.check.name.as_str()).collect()
}

/// Value of a check; NaN where nothing was measured.
pub(crate) fn value(inspection: &Inspection, name: &str) -> f64 {
    let found = inspection.findings.iter().find(|finding| finding.check.name == name);
    found.and_then(|finding| finding.check.value).unwrap_or(f64::NAN)
}
