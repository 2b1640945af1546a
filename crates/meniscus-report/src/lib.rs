//! Reports of a study: checks against targets, tables, charts and pictures, as text, JSON, Markdown and HTML.
//!
//! A study fills one [`Report`]; every form is drawn from it, so that no two of them can differ.
//!
//! ```
//! use meniscus_report::Report;
//! use meniscus_report::checks::Check;
//!
//! let mut report = Report::new("Drift", "meniscus drift --seconds 60");
//! report.prose("The liquid is at rest.");
//! report.checks(&[Check::at_most("drift", 0.02, "mm", 0.05)]);
//! assert!(report.markdown().contains("| drift | 2.0000e-2 | mm | <= 0.05 | ok |"));
//! assert_eq!(report.json()["checks"][0]["ok"], true);
//! ```

#[cfg(feature = "pictures")]
mod block;
#[cfg(feature = "pictures")]
mod chart;
pub mod checks;
#[cfg(feature = "pictures")]
pub mod plot;
#[cfg(feature = "pictures")]
mod render;
#[cfg(feature = "pictures")]
mod report;

#[cfg(feature = "pictures")]
pub use chart::{Chart, Mark, Series};
#[cfg(feature = "pictures")]
pub use report::Report;

/// The same types under their former path.
#[cfg(feature = "pictures")]
pub mod html {
    pub use crate::{Chart, Mark, Report, Series};
}
