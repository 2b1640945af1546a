//! What a person sees: the dashboard while it runs, the picture at the end, the wizard before it.

mod dashboard;
mod glass;
mod wizard;

pub use dashboard::{Caption, Dashboard};
pub use glass::{GlassPicture, Layer};
pub use wizard::{Step, Wish, Wizard};
