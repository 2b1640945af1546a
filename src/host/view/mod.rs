//! What a person sees: the dashboard while it runs, the picture at the end.

mod dashboard;
pub mod picture;
pub mod plot;

pub use dashboard::{Caption, Dashboard};
