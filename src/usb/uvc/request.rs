//! Requests on the control pipe: the setup packet without its length, which is that of the data.
//!
//! | request | bmRequestType | bRequest |
//! |---|---|---|
//! | SET_CUR | 0x21 | 0x01 |
//! | GET_CUR, GET_MAX | 0xa1 | 0x81, 0x83 |
//! | GET_DESCRIPTOR | 0x80 | 0x06 |
//!
//! Source: USB Video Class 1.5, section 4; USB 3.2, section 9.4.

/// A setup packet.
///
/// ```
/// use meniscus::usb::uvc::request::{PROBE, Setup};
///
/// // Selector 1 of extension unit 3 at interface 0: the hardware monitor of a D400.
/// let setup = Setup::set_cur(1, 3, 0);
/// assert_eq!((setup.request_type, setup.value, setup.index), (0x21, 0x0100, 0x0300));
/// assert_eq!(Setup::get_max(PROBE, 0, 1).request, 0x83);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// bmRequestType: direction, kind, recipient.
    pub request_type: u8,
    /// bRequest.
    pub request: u8,
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
}

/// Probe of a streaming interface.
pub const PROBE: u8 = 1;
/// Commit of a streaming interface.
pub const COMMIT: u8 = 2;

impl Setup {
    /// The configuration descriptor, whole, as it goes over the wire.
    pub const CONFIGURATION: Self = Self { request_type: 0x80, request: 0x06, value: 0x0200, index: 0 };

    /// Sets a control of `entity` (0: the interface itself).
    #[must_use]
    pub const fn set_cur(selector: u8, entity: u8, interface: u8) -> Self {
        Self::class(0x21, 0x01, selector, entity, interface)
    }

    /// Reads a control.
    #[must_use]
    pub const fn get_cur(selector: u8, entity: u8, interface: u8) -> Self {
        Self::class(0xa1, 0x81, selector, entity, interface)
    }

    /// Reads the largest value of a control.
    #[must_use]
    pub const fn get_max(selector: u8, entity: u8, interface: u8) -> Self {
        Self::class(0xa1, 0x83, selector, entity, interface)
    }

    const fn class(request_type: u8, request: u8, selector: u8, entity: u8, interface: u8) -> Self {
        // The selector stands in the high byte of wValue, the entity in that of wIndex.
        let value = u16::from_le_bytes([0, selector]);
        let index = u16::from_le_bytes([interface, entity]);
        Self { request_type, request, value, index }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hardware_monitor_lies_at_index_768() {
        let setup = Setup::set_cur(1, 3, 0);
        assert_eq!((setup.value, setup.index), (0x0100, 768));
        assert_eq!((Setup::get_cur(PROBE, 0, 1).value, Setup::get_cur(PROBE, 0, 1).index), (0x0100, 1));
    }
}
