//! The hardware monitor's messages: a command of 1024 bytes out, an answer of 1024 bytes in.
//!
//! | command | bytes | answer | bytes |
//! |---|---|---|---|
//! | length: 20 + data | 0..2 | echo of the opcode, or an error below 0 | 0..4 |
//! | magic 0xcdab | 2..4 | payload | 4..4 + n |
//! | opcode | 4..8 | n | 1020..1024 |
//! | four parameters | 8..24 | | |
//! | data | 24.. | | |
//!
//! Command and answer are a pair: nobody else may use the control between the two.

use crate::usb::uvc::bytes::{put, u32_at};

/// Bytes of a message, either way.
pub const MESSAGE: usize = 1024;
/// Most bytes of an answer's payload: between the echo and the length.
const PAYLOAD_MAX: usize = MESSAGE - 8;
/// Most bytes of a command's data.
const DATA_MAX: usize = MESSAGE - 24;

/// Opcodes.
pub mod opcode {
    /// Device information.
    pub const GVD: u32 = 0x10;
    /// Calibration table by its id.
    pub const GETINTCAL: u32 = 0x15;
    /// Restart; no answer, the camera leaves the bus and comes back.
    pub const HWRST: u32 = 0x20;
    /// Sets an advanced-mode group.
    pub const SET_ADV: u32 = 0x2b;
    /// Reads an advanced-mode group: group, then 0 for its value.
    pub const GET_ADV: u32 = 0x2c;
    /// State of the advanced mode: 0 is off.
    pub const UAMG: u32 = 0x30;
    /// Intrinsics of every resolution.
    pub const RECPARAMSGET: u32 = 0x7e;
}

/// A command.
///
/// ```
/// use meniscus::usb::d4xx::{Command, MESSAGE, MonitorError, opcode};
///
/// let command = Command::new(opcode::GVD, [0; 4]);
/// let mut message = [0; MESSAGE];
/// command.write(&mut message);
/// assert_eq!(message[..8], [20, 0, 0xab, 0xcd, 0x10, 0, 0, 0]);
///
/// // The answer echoes the opcode; its last four bytes are the length of the payload.
/// let mut answer = [5; MESSAGE];
/// answer[..4].copy_from_slice(&opcode::GVD.to_le_bytes());
/// answer[MESSAGE - 4..].copy_from_slice(&3_u32.to_le_bytes());
/// assert_eq!(command.answer(&answer, 3), Ok(&[5, 5, 5][..]));
/// assert_eq!(command.answer(&answer, 4), Err(MonitorError::Payload { got: 3, needed: 4 }));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command<'a> {
    /// Operation, one of [`opcode`].
    pub opcode: u32,
    /// Four parameters of the operation.
    pub parameters: [u32; 4],
    /// At most 1000 bytes.
    pub data: &'a [u8],
}

/// Fault of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MonitorError {
    /// The message has not the 1024 bytes of every message.
    MessageLength(usize),
    /// The payload's length is beyond what a message holds.
    PayloadLength(u32),
    /// The payload is shorter or longer than what this command answers.
    Payload {
        /// Length of the payload.
        got: usize,
        /// The least that is needed.
        needed: usize,
    },
    /// The answer belongs to another command.
    Opcode {
        /// The echo.
        got: u32,
        /// The command's.
        wanted: u32,
    },
    /// The camera refuses, by its error number.
    Refused(i32),
}

impl MonitorError {
    /// The camera may answer if it is asked again: it is busy or not ready.
    #[must_use]
    pub fn passes(&self) -> bool {
        matches!(self, Self::Refused(-7 | -32 | -41))
    }
}

impl core::fmt::Display for MonitorError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::MessageLength(got) => {
                write!(f, "the hardware monitor's answer has {got} bytes instead of {MESSAGE}")
            }
            Self::PayloadLength(got) => {
                write!(f, "the hardware monitor announces {got} bytes, more than a message holds")
            }
            Self::Payload { got, needed } => {
                write!(f, "the hardware monitor's answer carries {got} bytes where {needed} are needed")
            }
            Self::Opcode { got, wanted } => {
                write!(f, "the hardware monitor answers command {got:#x} instead of {wanted:#x}")
            }
            Self::Refused(number) => {
                write!(f, "the hardware monitor refuses with {number} ({})", refusal(*number))
            }
        }
    }
}

impl core::error::Error for MonitorError {}

/// Meaning of a refusal. Source of the numbers: `hw-monitor.h` of librealsense 2.55.
fn refusal(number: i32) -> &'static str {
    match number {
        -1 => "wrong command",
        -2 => "the start is after the end of the addresses",
        -3 => "the address is not aligned",
        -4 => "the address space is too small",
        -5 => "read only",
        -6 => "wrong parameter",
        -7 => "not ready",
        -8 => "the I2C bus failed",
        -9 => "an action of the user was expected",
        -10 => "the integrity check failed",
        -11 => "an empty string",
        -12 => "no such GPIO pin",
        -13 => "wrong direction of the GPIO pin",
        -14 => "wrong address",
        -15 => "wrong size",
        -16 => "the table of parameters is not valid",
        -17 => "no such table of parameters",
        -18 => "wrong table size",
        -19 => "bad CRC",
        -20 => "the flash memory may not be written",
        -21 => "no data",
        -22 => "the flash memory could not be read",
        -23 => "the flash memory could not be written",
        -24 => "the flash memory could not be erased",
        -25 => "the table is empty",
        -26 => "the I2C sequence took too long",
        -27 => "locked",
        -28 => "wrong calibration table",
        -29 => "a value is out of range",
        -30 => "wrong depth format",
        -31 => "the depth flow failed",
        -32 => "timeout",
        -33 => "the safety check failed",
        -34 => "a region of the flash memory is locked",
        -35 => "timeout of several events",
        -36 => "the stored data are corrupt",
        -37 => "the stored data could not be verified",
        -38 => "wrong state of the hardware",
        -39 => "the USB bridge is not loaded",
        -40 => "waking up is not supported",
        -41 => "busy",
        -43 => "pulse-width modulation is not supported",
        -44 => "the stereo module is not connected to its modulator",
        -45 => "wrong request of a stream",
        -46 => "wrong manual exposure",
        -47 => "wrong manual gain",
        -48 => "the eye-safety data failed",
        -49 => "the projector's test failed",
        -50 => "a thread could not be changed",
        -51 => "the laser is hot, its power was reduced",
        -52 => "the laser is too hot, it was turned off",
        -53 => "the laser was turned off by flag B",
        -54 => "the state did not change",
        -55 => "the EEPROM is locked",
        -56 => "wrong maker's number",
        -57 => "the USB bridge was not updated",
        -58 => "the function is not supported",
        -59 => "the image processor does not implement it",
        -60 => "the image processor does not support it",
        -61 => "the image processor does not permit it",
        -62 => "the image processor has no such thing",
        -63 => "the image processor failed",
        -64 => "unknown to the camera itself",
        _ => "no known name",
    }
}

impl<'a> Command<'a> {
    /// A command without data.
    #[must_use]
    pub const fn new(opcode: u32, parameters: [u32; 4]) -> Self {
        Self { opcode, parameters, data: &[] }
    }

    /// Writes the message, zeros behind its end. Data beyond 1000 bytes is left out and its length says so.
    pub fn write(&self, message: &mut [u8; MESSAGE]) {
        message.fill(0);
        let data = self.data.get(..DATA_MAX).unwrap_or(self.data);
        // total - 4, and at most 1020: fits 16 bits.
        let length = (20_usize.saturating_add(data.len())).min(MESSAGE) as u16;
        put(message, 0, &length.to_le_bytes());
        put(message, 2, &0xcdab_u16.to_le_bytes());
        put(message, 4, &self.opcode.to_le_bytes());
        for (k, parameter) in self.parameters.iter().enumerate() {
            put(message, 8 + 4 * k, &parameter.to_le_bytes());
        }
        put(message, 24, data);
    }

    /// The payload of this command's answer, at least `needed` bytes.
    ///
    /// # Errors
    /// [`MonitorError`] when the message is damaged, belongs to another command or is a refusal.
    pub fn answer<'m>(&self, message: &'m [u8], needed: usize) -> Result<&'m [u8], MonitorError> {
        let echo = u32_at(message, 0).filter(|_| message.len() == MESSAGE);
        let echo = echo.ok_or(MonitorError::MessageLength(message.len()))?;
        if echo != self.opcode {
            let number = echo.cast_signed();
            let refused = (-128..0).contains(&number);
            return Err(if refused {
                MonitorError::Refused(number)
            } else {
                MonitorError::Opcode { got: echo, wanted: self.opcode }
            });
        }
        let length = u32_at(message, MESSAGE - 4).unwrap_or(0);
        let payload = usize::try_from(length).ok().filter(|length| *length <= PAYLOAD_MAX);
        let payload = payload.and_then(|length| message.get(4..4 + length));
        let payload = payload.ok_or(MonitorError::PayloadLength(length))?;
        if payload.len() < needed {
            return Err(MonitorError::Payload { got: payload.len(), needed });
        }
        Ok(payload)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GVD: Command<'_> = Command::new(opcode::GVD, [0; 4]);

    #[test]
    fn commands_are_the_known_bytes() {
        let mut message = [0xff; MESSAGE];
        GVD.write(&mut message);
        assert_eq!(message[..8], [0x14, 0, 0xab, 0xcd, 0x10, 0, 0, 0]);
        assert_eq!(message[8..], [0; MESSAGE - 8]);
        Command::new(opcode::GETINTCAL, [25, 0, 0, 0]).write(&mut message);
        assert_eq!(message[..12], [0x14, 0, 0xab, 0xcd, 0x15, 0, 0, 0, 0x19, 0, 0, 0]);
        let set = Command { data: &[7; 20], ..Command::new(opcode::SET_ADV, [9, 0, 0, 0]) };
        set.write(&mut message);
        assert_eq!((message[0], message[24], message[43], message[44]), (40, 7, 7, 0));
    }

    fn answer(echo: u32, length: u32) -> [u8; MESSAGE] {
        let mut message = [5; MESSAGE];
        message[..4].copy_from_slice(&echo.to_le_bytes());
        message[MESSAGE - 4..].copy_from_slice(&length.to_le_bytes());
        message
    }

    #[test]
    fn each_bad_answer_has_its_name() {
        assert_eq!(GVD.answer(&answer(0x10, 3), 3), Ok(&[5, 5, 5][..]));
        let wrong = |message: &[u8]| GVD.answer(message, 4).expect_err("damaged");
        assert_eq!(wrong(&answer(0x10, 3)), MonitorError::Payload { got: 3, needed: 4 });
        assert_eq!(wrong(&answer(0x10, 1017)), MonitorError::PayloadLength(1017));
        assert_eq!(wrong(&answer(0x15, 8)), MonitorError::Opcode { got: 0x15, wanted: 0x10 });
        assert_eq!(wrong(&answer(0xffff_fff9, 8)), MonitorError::Refused(-7));
        assert_eq!(wrong(&answer(0x10, 8)[..1000]), MonitorError::MessageLength(1000));
        assert_eq!(wrong(&[]), MonitorError::MessageLength(0));
        assert!(MonitorError::Refused(-7).passes() && !MonitorError::Refused(-6).passes());
    }
}
