//! Terminal views: the dashboard during a run, the picture at the end, the wizard before it.

mod curve;
mod dashboard;
mod glass;
mod numbers;
mod scale_end;
mod section;
mod surface;
#[cfg(test)]
mod tests;
mod wizard;

pub use dashboard::{Caption, Dashboard};
pub use glass::{GlassPicture, Layer};
pub use wizard::{Step, Wish, Wizard};
