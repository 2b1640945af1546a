//! Decision from the fits of the candidate effects to a verdict.
//!
//! ```text
//! rank -> choose (one effect or two, against rules and thresholds) -> evidence -> decide -> Verdict
//! ```

pub mod assessment;
mod bounds;
mod choose;
pub mod decide;
pub mod evidence;
pub mod rank;
pub mod rules;
pub mod settings;
pub mod thresholds;
pub mod verdict;
