//! Choice of topics by a person.

use crate::Calibration;

/// Topics and numbers that a person gives where a recording of another program does not say them, or says too many.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosChoice {
    /// Topic of the depth images.
    pub depth_topic: Option<String>,
    /// Topic of the images in which the outline is traced.
    pub outline_topic: Option<String>,
    /// Topic of the depth camera's numbers.
    pub info_topic: Option<String>,
    /// Metres in one unit of integer depth images; 1 mm unless given, by REP 118.
    pub depth_unit_m: Option<f32>,
    /// The camera, in place of a topic.
    pub camera: Option<Calibration>,
}
