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
    /// D415: a rolling shutter, lenses 55 mm apart.
    D415,
    /// D455: lenses 95 mm apart, a motion sensor.
    D455,
    /// D400 with old firmware on a USB 2 link.
    OldUsb2,
    /// A D400 whose firmware did not start: only an update helps it.
    Recovery,
}

/// Trial of a product by this program. None has been tried on hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trial {
    /// A simulated device of its descriptors, tables and faults.
    Simulated,
    /// None.
    Never,
}

/// Facts of a product before it is opened. Modes, calibration and lenses it tells itself.
struct Known {
    product: Product,
    /// Product number of USB.
    number: u16,
    name: &'static str,
    trial: Trial,
}

/// The products.
///
/// Source of the numbers: `d400-private.h` of librealsense 2.50 to 2.57. There a D415 and a D455 have the extension unit, the
/// hardware monitor, the tables and the formats Z16, Y8 and YUY2 of a D435; a D405 has no projector and no colour lens of its own,
/// and is not here.
const KNOWN: [Known; 7] = [
    Known { product: Product::D435, number: 0x0b07, name: "D435", trial: Trial::Simulated },
    Known { product: Product::D435i, number: 0x0b3a, name: "D435i", trial: Trial::Simulated },
    Known { product: Product::D415, number: 0x0ad3, name: "D415", trial: Trial::Never },
    Known { product: Product::D455, number: 0x0b5c, name: "D455", trial: Trial::Never },
    Known {
        product: Product::OldUsb2,
        number: 0x0ad6,
        name: "D400 on USB 2 with old firmware",
        trial: Trial::Simulated,
    },
    Known { product: Product::Recovery, number: 0x0adb, name: "D400 in recovery", trial: Trial::Simulated },
    Known { product: Product::Recovery, number: 0x0adc, name: "D400 in recovery", trial: Trial::Simulated },
];

impl Product {
    /// By vendor and product number.
    ///
    /// ```
    /// use meniscus::usb::d4xx::{Product, Trial, VENDOR};
    ///
    /// assert_eq!(Product::of(VENDOR, 0x0b07), Some(Product::D435));
    /// assert_eq!(Product::of(VENDOR, 0x1234), None);
    /// let found = Product::of(VENDOR, 0x0b5c).map(|product| (product.name(), product.trial()));
    /// assert_eq!(found, Some(("D455", Trial::Never)));
    /// ```
    #[must_use]
    pub fn of(vendor: u16, product: u16) -> Option<Self> {
        let known = KNOWN.iter().find(|known| known.number == product && vendor == VENDOR);
        known.map(|known| known.product)
    }

    /// Returns the name of a RealSense camera that this program does not support, by vendor and product number.
    ///
    /// Source: `d400-private.h`, `l500-private.h`, `sr300.h` and `tm-device.h` of librealsense 2.50 to 2.57.
    ///
    /// ```
    /// use meniscus::usb::d4xx::{Product, VENDOR};
    ///
    /// assert_eq!(Product::unsupported(VENDOR, 0x0b64), Some("L515"));
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
            (VENDOR, 0x0ad4 | 0x0ad5 | 0x0b01) => "D430",
            (VENDOR, 0x0af2) => "D400 with a motion sensor",
            (VENDOR, 0x0af6 | 0x0afe) => "D420",
            (VENDOR, 0x0b03) => "D460",
            (VENDOR, 0x0b0c | 0x0b5b) => "D405",
            (VENDOR, 0x0b49 | 0x0b52) => "F416",
            (VENDOR, 0x0b4b) => "D430i",
            (VENDOR, 0x0b4d) => "D465",
            (VENDOR, 0xabcd) => "D457",
            (VENDOR, 0x0b6a | 0x0b6b) => "D585",
            (VENDOR, 0x0aa5 | 0x0b48) => "SR300",
            (VENDOR, 0x0b3d | 0x0b64) => "L515",
            (INTEL, 0x0b37) | (MOVIDIUS, 0x2150) => "T265",
            _ => return None,
        })
    }

    fn known(self) -> Option<&'static Known> {
        KNOWN.iter().find(|known| known.product == self)
    }

    /// As it is printed.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.known().map_or("", |known| known.name)
    }

    /// Returns its trial by this program.
    #[must_use]
    pub fn trial(self) -> Trial {
        self.known().map_or(Trial::Never, |known| known.trial)
    }
}
