//! From images to the liquid's edge: 21 heights above the bottom of the glass.
//!
//! ```text
//! infrared --region--binarise--glass--trace--contact--.
//!                              '-> X                 +--depth--hidden--resample--> SurfaceProfile
//! depth --------------------------------------------'
//! ```
//!
//! The liquid must be opaque in the near infrared. The camera stands slightly below the rest surface,
//! so the upper edge of the liquid in the image is its contact line on the wall that faces the camera.
//! Only the region around the glass is touched. [`Config`] is checked once and constant, [`State`]
//! remembers where the glass was and counts what the stages did.

mod binarise;
mod config;
mod contact;
mod deproject;
mod depth;
mod edge;
mod extract;
mod glass;
mod hidden;
mod profile;
mod region;
mod resample;
mod trace;

pub use config::{Config, ConfigError, Intrinsics, Liquid, MAX_COLUMNS, Settings};
pub use extract::{NotSeen, State, Tally, extract};
pub use profile::{POINTS, PROFILE_HALF_SPAN, SurfaceProfile, profile_abscissa};
