//! Why there is no webcam, in words, each with what to do about it.

use crate::mode::Mode;
use crate::video::VideoError;

/// Why a session cannot begin, or had to end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WebcamError {
    /// There is no such device.
    NotThere(String),
    /// The device takes no images.
    NotCapture(String),
    /// This user may not open the device.
    NoAccess(String),
    /// Another program streams from the device.
    Busy(String),
    /// The device has neither YUYV nor MJPG.
    NoFormat {
        /// The device.
        path: String,
        /// Codes of the formats that it has.
        offered: Vec<String>,
    },
    /// No mode has the size and the rate that are taken.
    NoMode {
        /// The device.
        path: String,
        /// The fastest one.
        fastest: Mode,
    },
    /// The device does not stay with a mode that it offers.
    NoAgreement {
        /// The device.
        path: String,
        /// Requested mode.
        wanted: Mode,
        /// Its answer.
        got: String,
    },
    /// Another camera is where the first one was.
    OtherCamera {
        /// The device.
        path: String,
        /// Name of the first camera.
        was: String,
        /// Name of this one.
        is: String,
    },
    /// The USB bus has no room for the stream.
    NoBandwidth(String),
    /// A call failed.
    System {
        /// The device.
        path: String,
        /// Operation that failed.
        error: VideoError,
    },
    /// Frames did not come back in time.
    GaveUp {
        /// For how long it was tried.
        seconds: u64,
        /// Error of the last try.
        last: String,
    },
}

impl WebcamError {
    /// Names the device of an error of the kernel.
    pub(crate) fn of(path: &str, error: VideoError) -> Self {
        let path = path.to_owned();
        match error {
            VideoError::NotThere => Self::NotThere(path),
            VideoError::NotCapture => Self::NotCapture(path),
            VideoError::NoAccess => Self::NoAccess(path),
            VideoError::Busy => Self::Busy(path),
            VideoError::NoBandwidth => Self::NoBandwidth(path),
            error @ (VideoError::Gone | VideoError::Ended | VideoError::System { .. }) => {
                Self::System { path, error }
            }
        }
    }

    /// Returns the remedy for a person.
    #[must_use]
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NotThere(_) => {
                "plug the camera in, and take its path of `ls /dev/v4l/by-id/`: that one stays the same at every plug"
            }
            Self::NotCapture(_) => {
                "a webcam has a second device for its metadata: take the other one, as a rule the one with the lower number"
            }
            Self::NoAccess(_) => "join the group video (sudo usermod -aG video $USER) and log in again",
            Self::Busy(_) => {
                "end the program that uses the camera (a browser, a call, a second meniscus): fuser -v shows it"
            }
            Self::NoFormat { .. } => "take a webcam with YUYV or MJPG; nearly all have one of them",
            Self::NoMode { .. } => {
                "take a webcam, or images, of 30 Hz or more; behind a hub a camera may offer less"
            }
            Self::NoAgreement { .. } => "plug the camera in again; if it stays so, take another one",
            Self::OtherCamera { .. } => "name the camera by its path in /dev/v4l/by-id/",
            Self::NoBandwidth(_) => {
                "plug the camera into a port of another controller, away from other cameras"
            }
            Self::System { .. } => "plug the camera in again, into another port or with another cable",
            Self::GaveUp { .. } => "plug the camera in again and start anew",
        }
    }
}

impl std::fmt::Display for WebcamError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NotThere(path) => write!(f, "there is no {path}"),
            Self::NotCapture(path) => write!(f, "{path} is no camera: it takes no images"),
            Self::NoAccess(path) => write!(f, "this user may not open {path}"),
            Self::Busy(path) => write!(f, "another program streams from {path}"),
            Self::NoFormat { path, offered } => {
                let offered = if offered.is_empty() { "none".to_owned() } else { offered.join(", ") };
                write!(f, "{path} has neither YUYV nor MJPG images; its formats: {offered}")
            }
            Self::NoMode { path, fastest } => write!(
                f,
                "{path} has no mode of 480 to 1920 pixels a row at 24 to 62 Hz; its fastest is {fastest}"
            ),
            Self::NoAgreement { path, wanted, got } => {
                write!(f, "{path} offers {wanted} and answers {got}")
            }
            Self::OtherCamera { path, was, is } => write!(f, "{path} is now a {is}, and was a {was}"),
            Self::NoBandwidth(path) => write!(f, "the USB bus has no room left for the images of {path}"),
            Self::System { path, error } => write!(f, "{path}: {error}"),
            Self::GaveUp { seconds, last } => {
                write!(f, "no frames for {seconds} s in spite of every remedy; the last try: {last}")
            }
        }?;
        write!(f, ". What to do: {}", self.remedy())
    }
}

impl std::error::Error for WebcamError {}
