//! Cameras by vendor and product number.

/// Intel's vendor number.
pub const VENDOR: u16 = 0x8086;

/// A product that this program knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Product {
    /// D435.
    D435,
    /// D435i: the same with a motion sensor.
    D435i,
    /// D400 with old firmware on a USB 2 link.
    OldUsb2,
    /// A D400 whose firmware did not start: only an update helps it.
    Recovery,
}

impl Product {
    /// By vendor and product number.
    ///
    /// ```
    /// use meniscus::usb::d4xx::{Product, VENDOR};
    ///
    /// assert_eq!(Product::of(VENDOR, 0x0b07), Some(Product::D435));
    /// assert_eq!(Product::of(VENDOR, 0x1234), None);
    /// ```
    #[must_use]
    pub fn of(vendor: u16, product: u16) -> Option<Self> {
        match (vendor, product) {
            (VENDOR, 0x0b07) => Some(Self::D435),
            (VENDOR, 0x0b3a) => Some(Self::D435i),
            (VENDOR, 0x0ad6) => Some(Self::OldUsb2),
            (VENDOR, 0x0adb | 0x0adc) => Some(Self::Recovery),
            _ => None,
        }
    }

    /// Returns the name of a RealSense camera that this program does not support, by vendor and product number.
    ///
    /// Source: `d400-private.h`, `l500-private.h`, `sr300.h` and `tm-device.h` of librealsense 2.50 to 2.57.
    ///
    /// ```
    /// use meniscus::usb::d4xx::{Product, VENDOR};
    ///
    /// assert_eq!(Product::unsupported(VENDOR, 0x0b5c), Some("D455"));
    /// assert_eq!(Product::unsupported(VENDOR, 0x0b07), None, "a D435 is supported");
    /// ```
    #[must_use]
    pub fn unsupported(vendor: u16, product: u16) -> Option<&'static str> {
        /// Maker of the motion processor in a T265.
        const MOVIDIUS: u16 = 0x03e7;
        /// Intel's second vendor number.
        const INTEL: u16 = 0x8087;
        Some(match (vendor, product) {
            (VENDOR, 0x0ad1 | 0x0b00) => "D400",
            (VENDOR, 0x0ad2 | 0x0aff) => "D410",
            (VENDOR, 0x0ad3) => "D415",
            (VENDOR, 0x0ad4 | 0x0ad5 | 0x0b01) => "D430",
            (VENDOR, 0x0af2) => "D400 with a motion sensor",
            (VENDOR, 0x0af6 | 0x0afe) => "D420",
            (VENDOR, 0x0b03) => "D460",
            (VENDOR, 0x0b0c | 0x0b5b) => "D405",
            (VENDOR, 0x0b49 | 0x0b52) => "F416",
            (VENDOR, 0x0b4b) => "D430i",
            (VENDOR, 0x0b4d) => "D465",
            (VENDOR, 0x0b5c) => "D455",
            (VENDOR, 0xabcd) => "D457",
            (VENDOR, 0x0b6a | 0x0b6b) => "D585",
            (VENDOR, 0x0aa5 | 0x0b48) => "SR300",
            (VENDOR, 0x0b3d | 0x0b64) => "L515",
            (INTEL, 0x0b37) | (MOVIDIUS, 0x2150) => "T265",
            _ => return None,
        })
    }

    /// As it is printed.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::D435 => "D435",
            Self::D435i => "D435i",
            Self::OldUsb2 => "D400 on USB 2 with old firmware",
            Self::Recovery => "D400 in recovery",
        }
    }
}
