//! Requested settings of the camera.

use std::time::Duration;

/// Image rate, Hz.
pub(super) const RATE_HZ: u32 = 60;

/// The image size on USB 3.
pub(super) const SIZE: (u16, u16) = (640, 480);

/// The only 60 Hz depth mode on USB 2.
pub(super) const SIZE_USB2: (u16, u16) = (480, 270);

/// The image in which the liquid's outline is traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OutlineImage {
    /// The left infrared one: of the depth image's own lens and instant, lit by the camera itself.
    #[default]
    Infrared,
    /// The colour one, in the light of the room: for liquids that are opaque there and clear in the near infrared,
    /// as many food dyes are. A lens of its own, a shutter that rolls, and never at quite the depth image's instant.
    Colour,
}

impl std::fmt::Display for OutlineImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Infrared => "infrared",
            Self::Colour => "colour",
        })
    }
}

impl std::str::FromStr for OutlineImage {
    type Err = &'static str;

    /// As it is written, or the other way that English spells colour.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "infrared" => Ok(Self::Infrared),
            "colour" | "color" => Ok(Self::Colour),
            _ => Err("there are infrared and colour"),
        }
    }
}

/// Settings of a session; [`Settings::default`] is what the turn was built for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Only the camera with this serial number (the one that USB shows); `None` for the first one.
    pub serial: Option<String>,
    /// Which image is streamed beside the depth image.
    pub outline: OutlineImage,
    /// Whether a USB 2 link is refused instead of stepped down to 480x270.
    pub refuse_usb2: bool,
    /// Micrometres in one unit of the depth image, written where the advanced mode allows it.
    pub depth_unit_um: Option<u32>,
    /// Fixed exposure, microseconds: below the frame interval, or the rate sags in the dark. `None`
    /// leaves the camera's automatic exposure on.
    pub exposure_us: Option<u32>,
    /// Power of the laser, milliwatts, 0 to 360; `None` leaves it.
    pub laser_mw: Option<u16>,
    /// Whether a camera is waited for that is not there yet, or that this user may not open yet. A service at boot starts before the
    /// system has given the rights; a person wants to read at once what is missing.
    pub waits_for_arrival: bool,
    /// Time that the session tries to get frames back before it gives up.
    pub patience: Duration,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            serial: None,
            outline: OutlineImage::Infrared,
            refuse_usb2: false,
            depth_unit_um: Some(100),
            exposure_us: Some(8_500),
            laser_mw: Some(150),
            waits_for_arrival: false,
            patience: Duration::from_secs(60),
        }
    }
}
