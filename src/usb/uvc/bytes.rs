//! Little-endian numbers at a place, `None` where the bytes end before.

/// Two bytes from `at` on.
pub(crate) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|b| u16::from_le_bytes(*b))
}

/// Four bytes from `at` on.
pub(crate) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|b| u32::from_le_bytes(*b))
}

/// A single-precision number from `at` on.
pub(crate) fn f32_at(bytes: &[u8], at: usize) -> Option<f32> {
    u32_at(bytes, at).map(f32::from_bits)
}

/// Writes `from` at `at`, as far as there is room.
pub(crate) fn put(into: &mut [u8], at: usize, from: &[u8]) {
    into.iter_mut().skip(at).zip(from).for_each(|(to, from)| *to = *from);
}
