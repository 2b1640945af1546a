//! The depth extension unit's controls, and the errors that its error control tells.

/// GUID c9606ccb-594c-4d25-af47-ccc496435995 as its bytes stand on the wire.
pub const UNIT_GUID: [u8; 16] =
    [0xcb, 0x6c, 0x60, 0xc9, 0x4c, 0x59, 0x25, 0x4d, 0xaf, 0x47, 0xcc, 0xc4, 0x96, 0x43, 0x59, 0x95];

/// Selector of the hardware monitor, 1024 bytes.
pub const HARDWARE_MONITOR: u8 = 0x01;
/// Selector of the exposure, `u32` microseconds; to be written with the automatic exposure off.
pub const EXPOSURE: u8 = 0x03;
/// Selector of the laser's power, `u16` milliwatts from 0 to 360 in steps of 30; writing it turns the laser on.
pub const LASER_POWER: u8 = 0x04;
/// Selector of the error, one byte; reading clears it.
pub const ERROR: u8 = 0x07;
/// Selector of the automatic exposure, one byte, 0 or 1.
pub const AUTO_EXPOSURE: u8 = 0x0b;

/// An error of the error control. Source: librealsense 2.56.5, `d400-private.h`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DeviceError(pub u8);

impl DeviceError {
    /// A stream could not be started: asking again, from the negotiation on, is worth a try.
    #[must_use]
    pub fn start_failed(self) -> bool {
        matches!(self.0, 22..=24)
    }

    /// Returns its meaning in words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self.0 {
            0 => "no error",
            1 => "the laser is hot, its power was reduced",
            2 => "the laser is too hot, it was turned off",
            3 => "the laser was turned off by flag B",
            4 => "the stereo module is missing",
            5 => "the EEPROM is corrupt",
            6 => "the calibration is corrupt",
            7 => "the motion module's update failed",
            8 => "the image processor's update failed",
            9 => "the motion module was paused",
            10 => "the motion module failed",
            11..=13 => "a USB buffer of the camera overflowed",
            14..=17 => "an imager's MIPI link failed",
            18..=21 => "an imager could not be configured",
            22 => "the depth stream could not be started",
            23 => "the infrared stream could not be started",
            24 => "a camera stream could not be started",
            25 => "the recorder failed",
            26 => "the USB 2 link limits the camera",
            27 => "the laser is too cold",
            28 => "no temperature is known, the laser was turned off",
            29 => "the image processor's boot data could not be read",
            _ => "an error without a known name",
        }
    }
}

impl core::fmt::Display for DeviceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "camera error {}: {}", self.0, self.meaning())
    }
}
