//! A glass that somebody has brought: measured by hand, looked at by the camera, written down for later runs.
//!
//! ```text
//! pairs of images --mean--> Portrait --body--> sides, rest line, foot --survey--> distance, pitch, height, radius
//!        '----------------------------extract (surface)--------------------------------rest--> level, slope, noise
//! said: radius, fill, rim --------------------------------------------------------inspect--> checks, Setup
//! ```
//!
//! What a person says of the glass is held against what the camera sees of it; where the camera stands is measured,
//! not asked. Of a webcam, which has no depth, lens, distance and height are stated, and what is seen of the glass checks
//! them. Of a clear liquid the depth image shows the wall of the glass, or not even that; then distance and height are
//! stated as well. The glass must stand still, upright, with the camera's horizontal level.
//!
//! **Refraction is not corrected: liquid in a thick wall looks wider than it is, so that the radius seen lies between
//! the inner and the outer one.**

mod body;
mod clear;
mod file;
mod finding;
mod findings;
mod inspect;
mod lens;
mod measured_glass;
mod portrait;
mod remedy;
mod rest;
mod survey;

pub use body::Body;
pub use file::{Misfit, Setup, SetupError};
pub use finding::Finding;
pub use inspect::{Inspection, SetupOrigin, StatedCamera, inspect, inspect_clear, inspect_outline};
pub use lens::{LensError, StatedLens};
pub use measured_glass::{MeasuredGlass, RANGES};
pub use portrait::{Gather, Pair, Portrait, Recent};
pub use rest::Rest;
pub use survey::{Blind, StatedPlace, Survey};
