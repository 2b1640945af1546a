//! The depth table of the advanced mode: how many micrometres one unit of the depth image is.
//!
//! | offset | field |
//! |---|---|
//! | 0 | u32 depth unit, micrometres |
//! | 4, 8 | i32 clamp, least and most |
//! | 12, 16 | i32 disparity mode and shift |
//!
//! The camera's default is 1 mm; at 0.4 m the sensor's own step is 0.26 mm, so 0.1 mm is requested.

use super::monitor::{Command, MonitorError, opcode};
use crate::usb::uvc::bytes::put;

/// The unit of a camera whose advanced mode is off.
pub const DEFAULT_DEPTH_UNIT_UM: u32 = 1000;

/// Number of the group.
const GROUP: u32 = 9;

/// The table.
///
/// ```
/// use meniscus::usb::d4xx::{DepthTable, MESSAGE, MonitorError};
///
/// let mut answer = [0; MESSAGE];
/// answer[0] = 0x2c;
/// answer[4..8].copy_from_slice(&1000_u32.to_le_bytes());
/// answer[MESSAGE - 4] = 20;
/// let table = DepthTable::read(&answer)?;
/// assert_eq!(table.unit_um(), 1000);
/// // Asks for 0.1 mm and leaves the rest as it is.
/// assert_eq!(table.with_unit_um(100).set().data[..4], [100, 0, 0, 0]);
/// # Ok::<(), MonitorError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthTable {
    bytes: [u8; 20],
}

impl DepthTable {
    /// The command that asks for it.
    pub const COMMAND: Command<'static> = Command::new(opcode::GET_ADV, [GROUP, 0, 0, 0]);
    /// The command that asks whether the advanced mode is on: a byte that is not 0.
    pub const ADVANCED: Command<'static> = Command::new(opcode::UAMG, [0; 4]);

    /// Reads the answer.
    ///
    /// # Errors
    /// [`MonitorError`].
    pub fn read(message: &[u8]) -> Result<Self, MonitorError> {
        let payload = Self::COMMAND.answer(message, 20)?;
        let bytes = payload.first_chunk().ok_or(MonitorError::Payload { got: payload.len(), needed: 20 })?;
        Ok(Self { bytes: *bytes })
    }

    /// Micrometres in one unit of the depth image.
    #[must_use]
    pub fn unit_um(&self) -> u32 {
        let [a, b, c, d, ..] = self.bytes;
        u32::from_le_bytes([a, b, c, d])
    }

    /// The same table with another unit.
    #[must_use]
    pub fn with_unit_um(mut self, unit_um: u32) -> Self {
        put(&mut self.bytes, 0, &unit_um.to_le_bytes());
        self
    }

    /// The command that sets it.
    #[must_use]
    pub fn set(&self) -> Command<'_> {
        Command { data: &self.bytes, ..Command::new(opcode::SET_ADV, [GROUP, 0, 0, 0]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_changes_and_the_rest_stays() {
        let mut message = [0; 1024];
        message[0] = 0x2c;
        message[4..8].copy_from_slice(&1000_u32.to_le_bytes());
        message[8..24].copy_from_slice(&[9; 16]);
        message[1020] = 20;
        let table = DepthTable::read(&message).expect("whole").with_unit_um(100);
        assert_eq!((table.unit_um(), &table.set().data[4..]), (100, &[9; 16][..]));
        message[1020] = 19;
        assert_eq!(DepthTable::read(&message), Err(MonitorError::Payload { got: 19, needed: 20 }));
    }
}
