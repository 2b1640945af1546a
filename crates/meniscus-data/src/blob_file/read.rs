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

    /// The shipped blob may have an older format; what is written from it has the newest, and comes back to the byte.
    #[test]
    fn the_shipped_blob_comes_back_bit_for_bit() {
        let shipped = AlignedBytes::copy(meniscus_shipped::MODEL);
        let (header, tensors) = parts(&shipped).expect("the shipped blob is good");
        let written = crate::blob_file::write::blob(header.clone(), &tensors).expect("its tensors are good");
        let (again, _) = parts(&AlignedBytes::copy(&written)).expect("what was written is good");
        assert_eq!(again.extension(), header.extension());
        for (new, old) in again.sections.iter().zip(&header.sections) {
            let bytes = |blob: &[u8], section: &Section| {
                let length = section_len(section.element, section.rows as usize, section.columns as usize);
                blob[section.offset as usize..][..length.expect("small")].to_vec()
            };
            assert_eq!(new.tensor, old.tensor);
            assert!(bytes(&written, new) == bytes(&shipped, old), "{:?}", new.tensor);
        }
        let (header, tensors) = parts(&AlignedBytes::copy(&written)).expect("what was written is good");
        let twice = crate::blob_file::write::blob(header, &tensors).expect("its tensors are good");
        assert!(twice == written, "{} bytes for {}", twice.len(), written.len());
    }
}
