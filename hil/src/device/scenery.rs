//! What stands before the simulated camera.

/// Gives the images of a shot.
pub trait Scenery: Send {
    /// Z16 and Y8 pixels of a shot of this size.
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]);
}

/// A test card: every pair of bytes of a shot is its number, little-endian.
#[derive(Clone, Debug, Default)]
pub struct TestCard {
    depth: Vec<u8>,
    infrared: Vec<u8>,
}

impl Scenery for TestCard {
    fn look(&mut self, shot: u64, (width, height): (u16, u16)) -> (&[u8], &[u8]) {
        let pixels = usize::from(width) * usize::from(height);
        let number = (shot as u16).to_le_bytes();
        for (image, bytes) in [(&mut self.depth, 2 * pixels), (&mut self.infrared, pixels)] {
            image.resize(bytes, 0);
            image.chunks_exact_mut(2).for_each(|pair| pair.copy_from_slice(&number));
        }
        (&self.depth, &self.infrared)
    }
}
