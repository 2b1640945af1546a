//! A RealSense D400 over plain libusb, without librealsense.
//!
//! ```text
//! transport (libusb, one trait) --> camera (connect, negotiate, session, recovery) --> link --> worker
//! ```

pub mod buffer;
pub mod camera;
pub mod link;
pub mod transport;
