//! From images to the liquid's edge: 21 heights above the bottom of the glass.
//!
//! ```text
//! outline ---region--binarise--glass--trace--foam--contact--.
//!                              '-> X                       +--depth--hidden--apart--resample--> SurfaceProfile
//! depth --------------------------------------------------'
//! ```
//!
//! The outline is traced in the left infrared image, or in the colour image, of which [`Rectifier`] makes a grey one as
//! if a lens like that of the depth image stood in the colour lens' place. The liquid must be opaque in that light, or clear
//! and darker than a bright card behind it ([`Liquid::Clear`], for which `clear` stands in the place of trace, foam and contact). The camera stands slightly below the rest surface,
//! so the upper edge of the liquid in the image is its contact line on the wall that faces the camera.
//! A camera without a depth image shows the outline alone ([`extract_outline`]): the wall is where the settings state it.
//!
//! Only the region around the glass is touched. [`Config`] is checked once and constant, [`ExtractionState`]
//! remembers where the glass was and counts what the stages did.

mod apart;
mod binarise;
mod clear;
mod config;
mod contact;
mod deproject;
mod depth;
mod edge;
mod edge_points;
mod extract;
mod first_mode;
mod foam;
mod glass;
mod hidden;
mod optics;
mod outcome;
mod outline;
mod profile;
mod rectify;
mod refraction;
mod region;
mod resample;
mod settings;
#[cfg(test)]
mod test_scene;
mod trace;
mod wall_sample;

pub use crate::usb::lens::{ColourLens, Intrinsics};
pub use config::{Config, ConfigError, MAX_COLUMNS, THICKEST_WALL_M};
pub use extract::{ExtractionState, extract, extract_outline};
pub use optics::Optics;
pub use outcome::{ExtractionError, Tally};
pub use outline::OutlineAssembler;
pub use profile::{POINTS, PROFILE_HALF_SPAN, SurfaceProfile, profile_abscissa};
pub use rectify::Rectifier;
pub use region::Region;
pub use settings::{Liquid, Settings};
