//! The buffer of one payload: allocated once, filled by the bus in place, handed on without a copy.

/// Bytes on the heap, whose place never changes, and how many of them are filled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Buffer {
    room: Box<[u8]>,
    filled: usize,
}

impl Buffer {
    /// A buffer with room for `size` bytes.
    #[must_use]
    pub fn new(size: usize) -> Self {
        Self { room: vec![0; size].into_boxed_slice(), filled: 0 }
    }

    /// All of its room, to be filled.
    pub fn room(&mut self) -> &mut [u8] {
        &mut self.room
    }

    /// Says how many bytes were filled; more than there is room for counts as all of it.
    pub fn set_filled(&mut self, filled: usize) {
        self.filled = filled.min(self.room.len());
    }

    /// Bytes it has room for.
    #[must_use]
    pub fn size(&self) -> usize {
        self.room.len()
    }

    /// An empty buffer of bytes that are already there.
    #[must_use]
    pub fn from_room(room: Box<[u8]>) -> Self {
        Self { room, filled: 0 }
    }

    /// Its bytes, filled or not.
    #[must_use]
    pub fn into_room(self) -> Box<[u8]> {
        self.room
    }

    /// Copies `bytes` in; `false` when they do not fit, and the buffer is empty then.
    pub fn fill_from(&mut self, bytes: &[u8]) -> bool {
        self.filled = 0;
        let Some(place) = self.room.get_mut(..bytes.len()) else { return false };
        place.copy_from_slice(bytes);
        self.filled = bytes.len();
        true
    }
}

impl std::ops::Deref for Buffer {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.room[..self.filled]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_not_taken() {
        let mut buffer = Buffer::new(4);
        assert!(buffer.fill_from(&[1, 2, 3]) && *buffer == [1, 2, 3]);
        assert!(!buffer.fill_from(&[0; 5]) && buffer.is_empty());
        buffer.set_filled(9);
        assert_eq!(buffer.len(), 4);
    }
}
