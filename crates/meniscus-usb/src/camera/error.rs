//! Why there is no camera, in words, each with what to do about it.

use crate::transport::UsbError;
use meniscus::usb::d4xx::{CalibrationError, Firmware, MonitorError, TableError};
use meniscus::usb::uvc::ProbeError;
use meniscus::usb::uvc::descriptor::DescriptorError;

/// Why a session cannot begin, or had to end.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraError {
    /// libusb cannot open any bus.
    NoBus(UsbError),
    /// No camera of this kind, or none with this serial number.
    NoCamera(Option<String>),
    /// A RealSense camera of another kind, and no D435.
    OtherCamera {
        /// Its name.
        name: &'static str,
        /// Its USB port.
        port: String,
    },
    /// The device at this port may not be opened.
    NoAccess(String),
    /// Another program holds the device at this port.
    Busy(String),
    /// The camera's firmware did not start.
    Recovery(String),
    /// The firmware is older than what this program understands.
    OldFirmware(Firmware),
    /// The link is USB 2 and stepping down is not wanted, or impossible.
    SlowLink(String),
    /// The link is USB 2, and the outline is wanted in colour, which has no mode there that goes with the depth.
    SlowColour(String),
    /// The configuration descriptor is damaged.
    Descriptors(DescriptorError),
    /// The descriptors lack something.
    Missing(&'static str),
    /// The camera shows no infrared images, but colour images that would do.
    NoInfrared(String),
    /// The named stream has no such mode.
    NoMode {
        /// Depth, infrared or colour.
        stream: &'static str,
        /// Pixels in a row, rows.
        size: (u16, u16),
    },
    /// The hardware monitor's answer is refused.
    Monitor {
        /// Quantity that was requested.
        asked: &'static str,
        /// Fault of the answer.
        error: MonitorError,
    },
    /// The calibration table is damaged.
    Table(TableError),
    /// The calibration holds nonsense.
    Calibration(CalibrationError),
    /// The camera does not agree to a mode.
    Probe {
        /// Depth, infrared or colour.
        stream: &'static str,
        /// Field that differs.
        error: ProbeError,
    },
    /// A call on the bus failed.
    Usb {
        /// Operation that failed.
        doing: &'static str,
        /// Error of the bus.
        error: UsbError,
    },
    /// The frames did not come back in time.
    GaveUp {
        /// For how long it was tried.
        seconds: u64,
        /// Error of the last try.
        last: String,
    },
}

impl CameraError {
    /// Whether another try, a little later, may find things changed.
    pub(super) fn passes(&self) -> bool {
        match self {
            Self::Usb { error, .. } => *error != UsbError::NoMemory,
            Self::Busy(_) | Self::Probe { .. } => true,
            Self::Monitor { error, .. } => error.passes(),
            _ => false,
        }
    }

    /// Whether the camera is not there, or not given to this user, as long before the system has seen to it.
    pub(super) fn may_arrive(&self) -> bool {
        matches!(self, Self::NoCamera(_) | Self::NoAccess(_))
    }

    /// Returns the remedy for a person.
    #[must_use]
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NoBus(_) => "use a machine with USB; a container has to be given /dev/bus/usb",
            Self::NoCamera(None) => {
                "plug a D435 or D435i into a USB 3 port, directly; `meniscus run` without --source needs none"
            }
            Self::OtherCamera { .. } => {
                "use a D435 or D435i, or a D415 or D455, which were never tried: modes and calibration of other cameras are not known to this \
                 program"
            }
            Self::NoInfrared(_) => {
                "use --outline colour, with a setup made so (`meniscus setup --outline colour`); plug the camera in again, or \
                 update its firmware, to have infrared back"
            }
            Self::NoCamera(Some(_)) => {
                "plug it in; the number is the one that USB shows, and without it the first camera is taken"
            }
            Self::NoAccess(_) => {
                "install the udev rule (sudo cp firmware-config/udev/60-meniscus-d435.rules /etc/udev/rules.d/ && \
                 sudo udevadm control --reload && sudo udevadm trigger), then plug the camera in again"
            }
            Self::Busy(_) => {
                "end the program that uses the camera (realsense-viewer, a ROS node, a second meniscus)"
            }
            Self::Recovery(_) => {
                "write a firmware with Intel's rs-fw-update -r, then plug the camera in again"
            }
            Self::OldFirmware(_) => "update the firmware with Intel's rs-fw-update to 5.12 or newer",
            Self::SlowLink(_) | Self::SlowColour(_) => {
                "plug the cable in again, quickly and all the way, flip its USB-C end, use a USB 3 port and cable"
            }
            Self::Descriptors(_) | Self::Missing(_) | Self::NoMode { .. } => {
                "plug the camera in again; if it stays so, send the file of `meniscus dump`"
            }
            Self::Monitor { .. } => "plug the camera in again; if it stays so, update its firmware",
            Self::Table(_) | Self::Calibration(_) => {
                "calibrate the camera again with Intel's calibration tool; without calibration nothing is measured"
            }
            Self::Probe { .. } => {
                "plug the camera in again; if it stays so, send the file of `meniscus dump`"
            }
            Self::Usb { error: UsbError::NoMemory, .. } => {
                "allow more memory for USB: echo 64 | sudo tee /sys/module/usbcore/parameters/usbfs_memory_mb"
            }
            Self::Usb { .. } => "plug the camera in again, into another port or with another cable",
            Self::GaveUp { .. } => "plug the camera in again and start anew",
        }
    }
}

impl std::fmt::Display for CameraError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoBus(error) => write!(f, "this machine has no USB bus that can be opened ({error})"),
            Self::NoCamera(None) => write!(f, "no depth camera is connected"),
            Self::NoCamera(Some(serial)) => {
                write!(f, "no depth camera with serial number {serial} is connected")
            }
            Self::OtherCamera { name, port } => {
                write!(f, "the camera at USB port {port} is a RealSense {name}, and no D435 is connected")
            }
            Self::NoInfrared(port) => {
                write!(f, "the camera at USB port {port} shows no infrared images of 640x480 at 60 Hz")
            }
            Self::NoAccess(port) => write!(f, "this user may not open the camera at USB port {port}"),
            Self::Busy(port) => write!(f, "another program holds the camera at USB port {port}"),
            Self::Recovery(port) => {
                write!(f, "the camera at USB port {port} is in recovery: its firmware did not start")
            }
            Self::OldFirmware(found) => {
                write!(f, "the camera's firmware {found} is older than {}", Firmware::OLDEST)
            }
            Self::SlowLink(port) => {
                write!(
                    f,
                    "the camera at USB port {port} is connected at USB 2, which has no 640x480 at 60 Hz"
                )
            }
            Self::SlowColour(port) => {
                write!(
                    f,
                    "the camera at USB port {port} is connected at USB 2, too slow for depth and colour"
                )
            }
            Self::Descriptors(error) => write!(f, "the camera's descriptors are damaged: {error}"),
            Self::Missing(what) => write!(f, "the camera's descriptors have no {what}"),
            Self::NoMode { stream, size: (width, height) } => {
                write!(f, "the camera has no {stream} images of {width}x{height} at 60 Hz")
            }
            Self::Monitor { asked, error } => write!(f, "the camera does not tell its {asked}: {error}"),
            Self::Table(error) => write!(f, "{error}"),
            Self::Calibration(error) => write!(f, "{error}"),
            Self::Probe { stream, error } => write!(f, "no agreement on the {stream} stream: {error}"),
            Self::Usb { doing, error } => write!(f, "cannot {doing}: {error}"),
            Self::GaveUp { seconds, last } => {
                write!(f, "no frames for {seconds} s in spite of every remedy; the last try: {last}")
            }
        }?;
        write!(f, ". What to do: {}", self.remedy())
    }
}

impl std::error::Error for CameraError {}
