//! Errors of the bus, and ends of queued transfers.

/// A call that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UsbError {
    /// The device has left the bus.
    NoDevice,
    /// This user may not open the device.
    Access,
    /// Another program holds the device.
    Busy,
    /// The device refuses the request (a stall).
    Stall,
    /// No answer in time.
    Timeout,
    /// The device sent more bytes than requested.
    Overflow,
    /// The transfer was damaged on the wire.
    Io,
    /// There is no such device, interface or endpoint.
    NotFound,
    /// The system has no memory for the transfer (usbfs has a limit of its own).
    NoMemory,
    /// Anything else, by libusb's number.
    Other(i32),
}

impl std::fmt::Display for UsbError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoDevice => write!(f, "the device has left the bus"),
            Self::Access => write!(f, "permission denied"),
            Self::Busy => write!(f, "another program holds the device"),
            Self::Stall => write!(f, "the device refuses the request"),
            Self::Timeout => write!(f, "no answer in time"),
            Self::Overflow => write!(f, "the device sent more than was requested"),
            Self::Io => write!(f, "damaged on the wire"),
            Self::NotFound => write!(f, "there is no such device, interface or endpoint"),
            Self::NoMemory => write!(f, "no memory for the transfer"),
            Self::Other(number) => write!(f, "libusb error {number}"),
        }
    }
}

impl std::error::Error for UsbError {}

/// End of a queued transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// It brought bytes.
    Completed,
    /// Damaged on the wire.
    Error,
    /// It has a time limit and missed it.
    TimedOut,
    /// It was cancelled.
    Cancelled,
    /// The endpoint is halted.
    Stall,
    /// The device has left the bus.
    NoDevice,
    /// The device sent more than the buffer holds.
    Overflow,
}
