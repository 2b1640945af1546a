//! Intel RealSense D400 cameras: who they are, their extension unit, their hardware monitor, their calibration.
//!
//! ```text
//! extension unit 3 --selector 1--> hardware monitor: 1024 bytes out, 1024 bytes in
//!        |                             '--> identity, calibration tables, intrinsics, depth unit, restart
//!        '--other selectors--> exposure, laser, error codes
//! ```
//!
//! What stands here was read from a restatement of librealsense 2.56.5 and from public logs. **None
//! of it has met a physical camera yet**; `meniscus dump` writes down what a real one answers. Not
//! known: whether every error is pushed on the interrupt endpoint, whether the coefficients reply has
//! 512 or 576 bytes (both are taken), the sign of the stored baseline (its size is used).

mod colour;
mod control;
mod depth_unit;
mod identity;
mod intrinsics;
mod monitor;
mod product;
mod table;

pub use colour::{COLOUR, Colour, EXPOSURE_BY_CAMERA, EXPOSURE_MODE, EXPOSURE_PRIORITY, colour};
pub use control::{AUTO_EXPOSURE, DeviceError, ERROR, EXPOSURE, HARDWARE_MONITOR, LASER_POWER, UNIT_GUID};
pub use depth_unit::{DEFAULT_DEPTH_UNIT_UM, DepthTable};
pub use identity::{Firmware, Identity, Serial};
pub use intrinsics::{CalibrationError, baseline_mm, coefficients, recommended};
pub use monitor::{Command, MESSAGE, MonitorError, opcode};
pub use product::{Product, Trial, VENDOR};
pub use table::{COEFFICIENTS, Table, TableError};
