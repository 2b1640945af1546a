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
