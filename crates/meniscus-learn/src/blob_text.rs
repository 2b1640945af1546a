//! Text of bounded length for the header of a blob.

/// Returns as much of `text` as fits into `N` bytes.
pub(crate) fn fitting<const N: usize>(text: &str) -> heapless::String<N> {
    let mut short = heapless::String::new();
    // The first character that does not fit ends it.
    let _ = text.chars().try_for_each(|c| short.push(c));
    short
}
