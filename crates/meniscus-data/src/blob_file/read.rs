//! A weight blob taken apart again: the way back from [`crate::blob_file::write`].

use crate::blob_file::write::Part;
use meniscus::blob::{Header, LoadError, Model, Section};
use meniscus::latent::nn::{Weights, section_len};

/// The header of `blob` and all of its tensors, unpacked, in blob order.
///
/// # Errors
/// [`LoadError`], when the camera side would refuse the blob. It must lie as in flash, on a boundary
/// of 64 bytes.
pub fn parts(blob: &[u8]) -> Result<(Header, Vec<Part>), LoadError> {
    let header = Model::load(blob)?.header;
    let parts = header.sections.iter().map(|section| unpack(blob, section)).collect();
    Ok((header, parts))
}

/// One tensor of a blob that has been checked, as the numbers that its weights stand for.
fn unpack(blob: &[u8], section: &Section) -> Part {
    let (rows, columns) = (section.rows as usize, section.columns as usize);
    let offset = section.offset as usize;
    let length = section_len(section.element, rows, columns).unwrap_or(0);
    let bytes = blob.get(offset..offset + length).unwrap_or_default();
    let weights = Weights::new(section.element, bytes, rows, columns);
    let number = |k: usize| weights.map_or(f32::NAN, |weights| weights.at(k / columns, k % columns));
    Part { tensor: section.tensor, rows, columns, values: (0..rows * columns).map(number).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_platform::files::AlignedBytes;

    #[test]
    fn the_shipped_blob_comes_back_bit_for_bit() {
        let shipped = meniscus_shipped::MODEL;
        let blob = AlignedBytes::copy(shipped);
        let (header, parts) = parts(&blob).expect("the shipped blob is good");
        let again = crate::blob_file::write::blob(header, &parts).expect("its tensors are good");
        assert!(again == shipped, "{} bytes for {}", again.len(), shipped.len());
    }
}
