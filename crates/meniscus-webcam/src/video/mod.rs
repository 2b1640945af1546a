//! A video device: the kernel's, or one that a test makes.

mod layout;
mod machine;
mod offers;
mod uapi;

use crate::mode::Mode;
pub use machine::Machine;
use std::time::Duration;

/// A call that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VideoError {
    /// There is no such device.
    NotThere,
    /// The device takes no images.
    NotCapture,
    /// This user may not open it.
    NoAccess,
    /// Another program streams from it.
    Busy,
    /// The bus has no room for the stream.
    NoBandwidth,
    /// It was unplugged.
    Gone,
    /// It has no more images, and will have none.
    Ended,
    /// Anything else.
    System {
        /// Operation that failed.
        doing: &'static str,
        /// Number of the system's error.
        code: i32,
    },
}

impl std::fmt::Display for VideoError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotThere => write!(f, "there is no such device"),
            Self::NotCapture => write!(f, "it takes no images"),
            Self::NoAccess => write!(f, "permission denied"),
            Self::Busy => write!(f, "another program streams from it"),
            Self::NoBandwidth => write!(f, "the bus has no room for the stream"),
            Self::Gone => write!(f, "it was unplugged"),
            Self::Ended => write!(f, "it has no more images"),
            Self::System { doing, code } => {
                write!(f, "cannot {doing}: {}", std::io::Error::from_raw_os_error(*code))
            }
        }
    }
}

impl std::error::Error for VideoError {}

/// Formats and modes that a device offers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Offers {
    /// Codes of all formats.
    pub formats: Vec<[u8; 4]>,
    /// Modes of the formats that can be read.
    pub modes: Vec<Mode>,
}

/// Whether a camera may lower its rate in the dark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RatePriority {
    /// The rate holds: the control was there and is off now.
    Held,
    /// The control is there and cannot be switched off.
    MayFall,
    /// The camera has no such control.
    Unknown,
}

/// A frame in the device's memory.
#[derive(Clone, Copy, Debug)]
pub struct VideoFrame<'f> {
    /// Its bytes.
    pub bytes: &'f [u8],
    /// Bytes from row to row; of YUYV.
    pub bytes_per_row: usize,
    /// Time of the driver, microseconds.
    pub captured_us: u64,
    /// Number of the driver; a gap is a lost frame.
    pub sequence: u32,
    /// Whether the driver calls it damaged.
    pub damaged: bool,
}

/// A video device.
pub trait Video {
    /// Opens it; returns the camera's name.
    ///
    /// # Errors
    /// [`VideoError`].
    fn open(&mut self) -> Result<String, VideoError>;
    /// Returns what the open device offers.
    ///
    /// # Errors
    /// [`VideoError`].
    fn offers(&mut self) -> Result<Offers, VideoError>;
    /// Sets a mode; returns the one that the device has then, or the code of another format.
    ///
    /// # Errors
    /// [`VideoError`].
    fn set(&mut self, mode: Mode) -> Result<Result<Mode, [u8; 4]>, VideoError>;
    /// Tells the camera to hold its rate in the dark.
    fn hold_rate(&mut self) -> RatePriority;
    /// Starts the stream.
    ///
    /// # Errors
    /// [`VideoError`].
    fn start(&mut self) -> Result<(), VideoError>;
    /// Waits for the next frame, at most for `limit`. Its memory goes back to the driver with the next call.
    ///
    /// # Errors
    /// [`VideoError`].
    fn next(&mut self, limit: Duration) -> Result<Option<VideoFrame<'_>>, VideoError>;
    /// Ends the stream.
    fn stop(&mut self);
    /// Closes the device.
    fn close(&mut self);
    /// Time since some start.
    fn now(&self) -> Duration;
    /// Waits.
    fn pause(&mut self, time: Duration);
}
