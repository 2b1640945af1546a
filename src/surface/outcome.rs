//! Outcome of an extraction: the reason for a missing profile, and counters of the stages.

use serde::{Deserialize, Serialize};

/// Reason for a pair of images without a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExtractionError {
    /// An image has not the size or the number of bytes of the configuration.
    WrongSize,
    /// The expected glass lies outside of the image.
    RegionEmpty,
    /// Liquid and background differ too little.
    NoContrast,
    /// No body of liquid as wide as the glass was found, or its edges disagree.
    GlassNotFound,
    /// Too few columns show the liquid's edge.
    TooFewColumns,
    /// The depth image is empty along the edge.
    NoDepth,
    /// The liquid's wall is more than 15 mm from where the settings put it.
    WallElsewhere,
}

impl core::fmt::Display for ExtractionError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::WrongSize => "an image has not the configured size",
            Self::RegionEmpty => "the expected glass lies outside of the image",
            Self::NoContrast => "liquid and background differ too little",
            Self::GlassNotFound => "no body of liquid as wide as the glass was found",
            Self::TooFewColumns => "too few columns show the liquid's edge",
            Self::NoDepth => "the depth image is empty along the liquid's edge",
            Self::WallElsewhere => "the liquid is not where the settings say: check the camera's distance",
        })
    }
}

impl core::error::Error for ExtractionError {}

/// Counters of the stages over all frames. They saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Profiles that came out.
    pub profiles: u32,
    /// Pairs of images without a profile.
    pub not_seen: u32,
    /// Edge points whose depth was a hole.
    pub holes: u32,
    /// Edge points dropped because their depth is not that of the wall facing the camera.
    pub not_the_wall: u32,
    /// Edge points dropped because something nearer than the glass stands above them.
    pub covered: u32,
    /// Edge points dropped because no surface that sloshes is there: a finger, or the edge of something else.
    #[serde(default)]
    pub apart: u32,
    /// Edge points moved down because the depth image shows liquid behind the contact line below them.
    pub behind: u32,
    /// Profiles whose edge lies beside saturated pixels: the camera's exposure is too long.
    pub saturated: u32,
}
