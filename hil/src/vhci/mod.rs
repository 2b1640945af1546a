//! The simulated camera under a real kernel: USB/IP to the kernel's virtual host controller (vhci-hcd),
//! over one end of a socket pair, with no other tool.
//!
//! ```text
//! usbfs, libusb, rusb -- usbcore -- vhci-hcd --socket--> Bus (urbs wait here) --> device::Device
//!                                       ^--- attach: the socket's number, into sysfs
//! ```
//!
//! [`Plugged`] keeps a camera at a port for as long as it lives: unplugging is closing the socket, and what
//! comes back comes back at the same port. Root and the module vhci-hcd are needed.

mod bus;
mod plug;
mod port;
mod wire;

pub use bus::{Sent, Witness};
pub use plug::Plugged;
pub use port::PortError;
