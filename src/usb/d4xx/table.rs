//! Calibration tables: sixteen bytes of header, then what its CRC-32 covers.
//!
//! | offset | size | field |
//! |---|---|---|
//! | 0 | 2 | version, big-endian |
//! | 2 | 2 | type: the id of the table |
//! | 4 | 4 | bytes behind the header |
//! | 8 | 4 | parameter |
//! | 12 | 4 | CRC-32 (IEEE 802.3) of all bytes behind the header |

use super::monitor::{Command, opcode};
use crate::usb::uvc::bytes::{u16_at, u32_at};

/// Id of the depth coefficients.
pub const COEFFICIENTS: u16 = 25;

const HEADER: usize = 16;
const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// Fault of a calibration table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableError {
    /// Fewer bytes than the header, or than the header says.
    Length {
        /// Bytes of the payload.
        got: usize,
        /// Bytes that are needed.
        needed: usize,
    },
    /// Another table.
    Id {
        /// Id of the table.
        got: u16,
        /// Id in the request.
        wanted: u16,
    },
    /// The CRC does not fit.
    Crc {
        /// As it stands in the header.
        stored: u32,
        /// Of the bytes that came.
        computed: u32,
    },
}

impl core::fmt::Display for TableError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { got, needed } => {
                write!(f, "the calibration table has {got} bytes, {needed} are needed")
            }
            Self::Id { got, wanted } => write!(f, "calibration table {got} came instead of {wanted}"),
            Self::Crc { stored, computed } => write!(
                f,
                "the calibration table is damaged: its CRC-32 is {stored:#010x}, that of its bytes {computed:#010x}"
            ),
        }
    }
}

impl core::error::Error for TableError {}

/// A table whose CRC fits.
///
/// ```
/// use meniscus::usb::d4xx::{COEFFICIENTS, Table, TableError};
///
/// // Table 25 over the bytes "123456789", whose CRC-32 is 0xcbf43926.
/// let mut payload = [0; 25];
/// payload[..8].copy_from_slice(&[1, 0, 25, 0, 9, 0, 0, 0]);
/// payload[12..16].copy_from_slice(&0xcbf4_3926_u32.to_le_bytes());
/// payload[16..].copy_from_slice(b"123456789");
/// assert!(Table::read(&payload, COEFFICIENTS).is_ok());
///
/// payload[20] ^= 1;
/// assert!(matches!(Table::read(&payload, COEFFICIENTS), Err(TableError::Crc { .. })));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Table<'a> {
    /// All of it, the header included: offsets count from its start.
    pub bytes: &'a [u8],
}

impl<'a> Table<'a> {
    /// The command that asks for table `id`.
    #[must_use]
    pub const fn command(id: u16) -> Command<'static> {
        Command::new(opcode::GETINTCAL, [id as u32, 0, 0, 0])
    }

    /// Checks the payload of the answer.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn read(payload: &'a [u8], id: u16) -> Result<Self, TableError> {
        let short = |needed| TableError::Length { got: payload.len(), needed };
        let (got, size) = u16_at(payload, 2).zip(u32_at(payload, 4)).ok_or(short(HEADER))?;
        if got != id {
            return Err(TableError::Id { got, wanted: id });
        }
        let needed = usize::try_from(size).unwrap_or(usize::MAX).saturating_add(HEADER);
        if payload.len() < needed {
            return Err(short(needed));
        }
        let stored = u32_at(payload, 12).ok_or(short(HEADER))?;
        let computed = CRC.checksum(payload.get(HEADER..).ok_or(short(HEADER))?);
        if stored != computed {
            return Err(TableError::Crc { stored, computed });
        }
        Ok(Self { bytes: payload })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_one_of_the_check_value() {
        // Check value of CRC-32/ISO-HDLC over "123456789".
        let mut table = [0; 25];
        table[..8].copy_from_slice(&[1, 0, 25, 0, 9, 0, 0, 0]);
        table[12..16].copy_from_slice(&0xcbf4_3926_u32.to_le_bytes());
        table[16..].copy_from_slice(b"123456789");
        assert!(Table::read(&table, 25).is_ok());
        assert_eq!(Table::read(&table, 32), Err(TableError::Id { got: 25, wanted: 32 }));
        assert_eq!(Table::read(&table[..24], 25), Err(TableError::Length { got: 24, needed: 25 }));
        assert_eq!(Table::read(&table[..3], 25), Err(TableError::Length { got: 3, needed: 16 }));
        table[20] ^= 1;
        assert!(matches!(Table::read(&table, 25), Err(TableError::Crc { stored: 0xcbf4_3926, .. })));
    }
}
