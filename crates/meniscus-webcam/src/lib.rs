//! A plain colour webcam over Video4Linux: its frames as payloads, and how it comes back.
//!
//! ```text
//! open -> capture device? -> modes (YUYV, MJPG) -> set -> rate fixed -> buffers -> frames to the Sink as payloads
//!              ^--------------------- the ladder of meniscus-usb ---------------------'
//! ```
//!
//! A frame keeps the driver's time and number: it goes on as a payload with a UVC header, so that the reader books what
//! is missing, damaged or short as it does of a D435. MJPG is decoded to its luma here.
//!
//! A folder of images with their times ([`Pictures`]) stands in the place of a camera.
//!
//! The kernel's interface is called through `rustix`: the crate `v4l` needs libclang to be built, and `linuxvideo` 0.3
//! hands on neither time nor number of a frame.
//!
//! **No physical webcam has been tried.**

mod choice;
mod error;
mod mode;
mod pack;
mod pictures;
mod rate;
mod session;
mod video;
mod webcam;

pub use error::WebcamError;
pub use mode::{Mode, PixelFormat};
pub use pictures::{Pictures, PicturesError, holds_pictures};
pub use session::Session;
pub use video::{Machine, Offers, RatePriority, Video, VideoError, VideoFrame};
pub use webcam::Webcam;
