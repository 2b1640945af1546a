//! Status packets of the interrupt endpoint: the camera pushes an error instead of being polled for it.
//!
//! | byte | field | value seen on a D400 |
//! |---|---|---|
//! | 0 | bStatusType, low four bits | 1: video control |
//! | 1 | bOriginator | 3: the extension unit |
//! | 2 | bEvent | 0: control change |
//! | 3 | bSelector | 7: the error control |
//! | 4 | bAttribute | 0: the value changed |
//! | 5 | bValue | the error |
//!
//! Source: USB Video Class 1.5, section 2.4.2.2.

/// A control's value changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ControlChange {
    /// Unit or terminal.
    pub originator: u8,
    /// Control of that unit.
    pub selector: u8,
    /// First byte of the new value.
    pub value: u8,
}

impl ControlChange {
    /// Reads a status packet; `None` for anything but the change of a control's value.
    ///
    /// ```
    /// use meniscus::usb::uvc::ControlChange;
    ///
    /// let change = ControlChange::read(&[1, 3, 0, 7, 0, 23]).unwrap();
    /// assert_eq!((change.originator, change.selector, change.value), (3, 7, 23));
    /// assert_eq!(ControlChange::read(&[2, 1, 0, 1, 0, 0]), None);
    /// ```
    #[must_use]
    pub fn read(packet: &[u8]) -> Option<Self> {
        match *packet {
            [kind, originator, 0, selector, 0, value, ..] if kind & 0x0f == 1 => {
                Some(Self { originator, selector, value })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_push_reads_and_nothing_else_does() {
        let pushed = ControlChange { originator: 3, selector: 7, value: 23 };
        assert_eq!(ControlChange::read(&[1, 3, 0, 7, 0, 23]), Some(pushed));
        assert_eq!(ControlChange::read(&[2, 1, 0, 1, 0, 23]), None, "a streaming interface's button");
        assert_eq!(ControlChange::read(&[1, 3, 0, 7, 1, 23]), None, "an attribute without a value");
        assert_eq!(ControlChange::read(&[1, 3, 0, 7, 0]), None);
        assert_eq!(ControlChange::read(&[]), None);
    }
}
