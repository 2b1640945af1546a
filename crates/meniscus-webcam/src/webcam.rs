//! The camera that a session has agreed with.

use crate::mode::Mode;
use crate::video::RatePriority;

/// A webcam that is open and agreed on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Webcam {
    /// Path of the device.
    pub path: String,
    /// Name by its driver.
    pub name: String,
    /// Mode of the stream.
    pub mode: Mode,
    /// Whether the rate holds in the dark.
    pub rate: RatePriority,
}

impl Webcam {
    /// Returns the remedy of a rate that is lower than the agreed one.
    #[must_use]
    pub fn remedy_of_a_low_rate(&self) -> String {
        let path = &self.path;
        match self.rate {
            RatePriority::MayFall => format!(
                "the camera lowers its rate in the dark and does not let that be switched off here: v4l2-ctl -d {path} -c \
                 exposure_dynamic_framerate=0 (exposure_auto_priority=0 on kernels before 5.19), or more light"
            ),
            RatePriority::Held | RatePriority::Unknown => "more light, or a port of its own".into(),
        }
    }

    /// Returns the camera in one line.
    #[must_use]
    pub fn line(&self) -> String {
        let Self { path, name, mode, .. } = self;
        format!("{name} at {path}: {mode}")
    }
}
