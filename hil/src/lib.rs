//! The simulated USB depth camera: it packs images into UVC payloads byte for byte like a D435, and
//! damages them on request. It shares no code with the reader that it tests.
//!
//! ```text
//! images, time --Camera--> payloads --FaultInjector--> payloads, some late, torn, doubled or gone
//! ```
//!
//! [`device`] puts descriptors, control requests and troubles of a whole USB device around it; [`vhci`] plugs
//! that device into a real kernel.
//!
//! [`FaultInjector`] wraps any [`Source`] and is a [`Source`] itself, so injectors stack.

mod camera;
pub mod device;
mod fault_list;
mod faults;
mod payload;
#[cfg(target_os = "linux")]
mod standard_requests;
#[cfg(target_os = "linux")]
pub mod usbredir;
#[cfg(target_os = "linux")]
pub mod vhci;

pub use camera::{Camera, CameraSettings, Payload, Shot, Source, Stream};
pub use fault_list::{FaultKind, FaultList, ParseFaultError, When};
pub use faults::FaultInjector;
pub use payload::{HEADER_LENGTH, Image, Stamp, pack};
