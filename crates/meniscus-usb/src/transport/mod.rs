//! The bus, as the camera needs it: one trait, so that a simulated camera plugs in below it.
//!
//! ```text
//! camera session --Transport--> Machine (rusb; transfers.rs has the queued transfers)   a real bus
//!                          '--> offline::usb::SimulatedBus                              the simulated camera
//! ```
//!
//! The transport is also the session's clock, so that tests run in virtual time. Every call is bounded.

mod error;
mod libusb;
mod machine;
mod transfers;

use crate::buffer::Buffer;
pub use error::{Status, UsbError};
pub use machine::Machine;
use meniscus::usb::uvc::request::Setup;
use std::time::Duration;

/// Link speed of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Speed {
    /// Not known to the system.
    Unknown,
    /// USB 1.
    Full,
    /// USB 2, 480 Mbit/s.
    High,
    /// USB 3, 5 Gbit/s or more.
    Super,
}

impl std::fmt::Display for Speed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Unknown => "unknown speed",
            Self::Full => "USB 1",
            Self::High => "USB 2, 480 Mbit/s",
            Self::Super => "USB 3, 5 Gbit/s or more",
        })
    }
}

/// A device on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listed {
    /// Bus and port path, as in `2-1.4`.
    pub port: String,
    /// idVendor.
    pub vendor: u16,
    /// idProduct.
    pub product: u16,
    /// Serial number that USB shows, where it can be read without opening.
    pub serial: Option<String>,
    /// Link speed.
    pub speed: Speed,
}

/// Kinds of queued transfers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pipe {
    /// Images.
    Bulk,
    /// Status packets.
    Interrupt,
}

/// A transfer that has ended.
#[derive(Debug)]
pub struct Completion {
    /// Its endpoint.
    pub endpoint: u8,
    /// End of the transfer.
    pub status: Status,
    /// Its buffer, with what arrived.
    pub buffer: Buffer,
}

/// A transfer that could not be queued, with its buffer.
#[derive(Debug)]
pub struct NotQueued {
    /// Why.
    pub error: UsbError,
    /// The buffer, unused.
    pub buffer: Buffer,
}

/// A bus with at most one device open.
pub trait Transport {
    /// Monotonic time.
    fn now(&mut self) -> Duration;

    /// Lets time pass.
    fn pause(&mut self, time: Duration);

    /// Every device on the bus.
    ///
    /// # Errors
    /// [`UsbError`] when the bus itself cannot be read.
    fn list(&mut self) -> Result<Vec<Listed>, UsbError>;

    /// Opens the device at a port; one that was open is closed first.
    ///
    /// # Errors
    /// [`UsbError`].
    fn open(&mut self, device: &Listed) -> Result<(), UsbError>;

    /// Closes the device; transfers in flight are cancelled and waited for, for a second at most.
    fn close(&mut self);

    /// Reads by a control request; the number of bytes that came.
    ///
    /// # Errors
    /// [`UsbError`].
    fn control_in(&mut self, setup: Setup, into: &mut [u8], timeout: Duration) -> Result<usize, UsbError>;

    /// Writes by a control request.
    ///
    /// # Errors
    /// [`UsbError`].
    fn control_out(&mut self, setup: Setup, bytes: &[u8], timeout: Duration) -> Result<(), UsbError>;

    /// Claims an interface, taking it from the kernel's driver.
    ///
    /// # Errors
    /// [`UsbError::Busy`] when another program holds it.
    fn claim(&mut self, interface: u8) -> Result<(), UsbError>;

    /// Clears an endpoint's halt; no transfer may be in flight on it.
    ///
    /// # Errors
    /// [`UsbError`].
    fn clear_halt(&mut self, endpoint: u8) -> Result<(), UsbError>;

    /// Queues a read of the buffer's whole room.
    ///
    /// # Errors
    /// [`NotQueued`] gives the buffer back.
    fn submit(&mut self, pipe: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), NotQueued>;

    /// The next transfer that has ended, in the order of their ends; waits at most `wait`.
    fn reap(&mut self, wait: Duration) -> Option<Completion>;

    /// Asks every transfer in flight to end; they come back through [`reap`](Self::reap).
    fn cancel(&mut self);

    /// Transfers that have not come back.
    fn in_flight(&self) -> usize;

    /// Resets the device's port.
    ///
    /// # Errors
    /// [`UsbError`].
    fn reset(&mut self) -> Result<(), UsbError>;
}
