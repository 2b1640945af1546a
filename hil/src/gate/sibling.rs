//! A model that is not the shipped one: one weight's last bit differs, and the checksum says so.

use super::Failure;

/// Where the checksum of what follows it lies (firmware-config/SPEC.md).
const CHECKSUM: std::ops::Range<usize> = 20..24;

/// Reads a blob and writes its sibling.
pub(crate) fn write(blob: &str, out: &str) -> Result<bool, Failure> {
    let blob = std::fs::read(blob).map_err(|error| format!("{blob}: {error}"))?;
    let sibling = of(&blob).ok_or("the blob is shorter than its header")?;
    std::fs::write(out, sibling).map_err(|error| format!("{out}: {error}"))?;
    Ok(true)
}

fn of(blob: &[u8]) -> Option<Vec<u8>> {
    let mut sibling = blob.to_vec();
    let last = sibling.len().checked_sub(4).filter(|last| *last > CHECKSUM.end)?;
    *sibling.get_mut(last)? ^= 1;
    let sum = crc32(sibling.get(CHECKSUM.end..)?);
    sibling.get_mut(CHECKSUM)?.copy_from_slice(&sum.to_le_bytes());
    Some(sibling)
}

/// CRC-32 of IEEE 802.3: reflected polynomial 0xedb88320, initial value and final exclusive-or of ones.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, _| (sum >> 1) ^ (0xedb8_8320 * (sum & 1));
    !bytes.iter().fold(u32::MAX, |sum, byte| (0..8).fold(sum ^ u32::from(*byte), step))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_is_that_of_the_standard_and_one_bit_differs_behind_it() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926, "the check value of CRC-32/ISO-HDLC");
        let blob: Vec<u8> = (0..64).collect();
        let sibling = of(&blob).expect("long enough");
        assert_eq!(sibling[20..24], crc32(&sibling[24..]).to_le_bytes());
        let differ = |at: &usize| blob[*at] != sibling[*at];
        assert_eq!((24..64).filter(differ).collect::<Vec<_>>(), [60]);
        assert_eq!(of(&blob[..24]), None);
    }
}
