//! The simulated camera behind QEMU's host controller: usbredir, over a socket, from outside of the guest.
//!
//! ```text
//! usbfs, libusb, rusb -- usbcore -- xhci-hcd -- (QEMU) qemu-xhci, usb-redir --socket--> Redirected --> device::Device
//! ```
//!
//! Beyond what [`crate::vhci`] shows, the kernel's driver of a real controller is at work: transfer rings, the halt
//! of an endpoint, cancelled transfers, the reset of a port. Time is the machine's own, so nothing of it is a measure.

mod port;
mod shape;
mod wire;

pub use port::{Counts, Redirected, Request, read};
