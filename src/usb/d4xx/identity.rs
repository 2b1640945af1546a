//! Identity of the camera: the device information that the command GVD answers.
//!
//! | offset | field |
//! |---|---|
//! | 12 | firmware: build, patch, minor, major |
//! | 48 | serial number of the optical module, 6 bytes, printed as 12 hexadecimal digits |
//! | 64 | serial number of the ASIC, 6 bytes: the one that USB shows |

use super::monitor::{Command, MonitorError, opcode};

/// A firmware version.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Firmware(pub [u8; 4]);

impl Firmware {
    /// Frame counter and exposure stand in the header from this version on, and the depth unit can be set.
    pub const OLDEST: Self = Self([5, 8, 0, 0]);
}

impl core::fmt::Display for Firmware {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [major, minor, patch, build] = self.0;
        write!(f, "{major}.{minor}.{patch}.{build}")
    }
}

/// A serial number, printed as twelve digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Serial(pub [u8; 6]);

impl core::fmt::Display for Serial {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// The device information.
///
/// ```
/// use meniscus::usb::d4xx::{Firmware, Identity, MESSAGE, MonitorError};
///
/// let mut answer = [0; MESSAGE];
/// answer[0] = 0x10;
/// // Behind the echo, the firmware lies backwards.
/// answer[4 + 12..4 + 16].copy_from_slice(&[100, 0, 16, 5]);
/// answer[MESSAGE - 4] = 240;
/// let identity = Identity::read(&answer)?;
/// assert_eq!(identity.firmware, Firmware([5, 16, 0, 100]));
/// assert!(identity.firmware > Firmware::OLDEST);
/// # Ok::<(), MonitorError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Version of the firmware.
    pub firmware: Firmware,
    /// Serial number of the optical module.
    pub serial: Serial,
    /// Serial number of the ASIC.
    pub asic: Serial,
}

impl Identity {
    /// The command that asks for it.
    pub const COMMAND: Command<'static> = Command::new(opcode::GVD, [0; 4]);

    /// Bytes of the answer up to the last field that is read.
    const NEEDED: usize = 70;

    /// Reads the answer.
    ///
    /// # Errors
    /// [`MonitorError`].
    pub fn read(message: &[u8]) -> Result<Self, MonitorError> {
        let payload = Self::COMMAND.answer(message, Self::NEEDED)?;
        let missing = MonitorError::Payload { got: payload.len(), needed: Self::NEEDED };
        let mut firmware = *payload.get(12..).and_then(<[u8]>::first_chunk::<4>).ok_or(missing)?;
        firmware.reverse();
        let serial = payload.get(48..).and_then(<[u8]>::first_chunk).ok_or(missing)?;
        let asic = payload.get(64..).and_then(<[u8]>::first_chunk).ok_or(missing)?;
        Ok(Self { firmware: Firmware(firmware), serial: Serial(*serial), asic: Serial(*asic) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_firmware_is_stored_backwards() {
        let mut message = [0; 1024];
        message[0] = 0x10;
        message[4 + 12..4 + 16].copy_from_slice(&[100, 0, 16, 5]);
        message[4 + 48..4 + 54].copy_from_slice(&[0x84, 0x31, 0x12, 0x07, 0x10, 0x99]);
        message[1020] = 240;
        let identity = Identity::read(&message).expect("whole");
        assert_eq!(identity.firmware, Firmware([5, 16, 0, 100]));
        assert!(identity.firmware > Firmware::OLDEST && Firmware([5, 7, 9, 9]) < Firmware::OLDEST);
        assert_eq!(identity.serial, Serial([0x84, 0x31, 0x12, 0x07, 0x10, 0x99]));
        message[1020] = 60;
        assert_eq!(Identity::read(&message), Err(MonitorError::Payload { got: 60, needed: 70 }));
    }
}
