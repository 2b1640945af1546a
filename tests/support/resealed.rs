//! Weight blobs that were altered on purpose.

use meniscus::blob::{CRC, PREFIX_LEN};

/// Returns `blob` with its length and checksum right again, as somebody who alters it on purpose writes them.
pub(crate) fn resealed(mut blob: Vec<u8>) -> Vec<u8> {
    if blob.len() >= PREFIX_LEN {
        let length = blob.len() as u32;
        blob[16..20].copy_from_slice(&length.to_le_bytes());
        let crc = CRC.checksum(&blob[PREFIX_LEN..]).to_le_bytes();
        blob[20..24].copy_from_slice(&crc);
    }
    blob
}
