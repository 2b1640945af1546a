//! Scenes in front of the simulated camera.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Gives the images of a shot.
pub trait Scenery: Send {
    /// Z16 and Y8 pixels of a shot of this size.
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]);

    /// Z16 and YUY2 pixels of a shot of 640x480; `None` where nothing is known of its colours, and the device shows
    /// an even grey.
    fn look_in_colour(&mut self, _shot: u64) -> Option<(&[u8], &[u8])> {
        None
    }
}

/// A test card: every pair of bytes of a shot is its number, little-endian.
#[derive(Clone, Debug, Default)]
pub struct TestCard {
    /// Of two bytes a pixel; depth is all of it, infrared a half.
    card: Vec<u8>,
}

impl Scenery for TestCard {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        let pixels = usize::from(size.0) * usize::from(size.1);
        self.card.clear();
        self.card.resize(2 * pixels, 0);
        let number = (shot as u16).to_le_bytes();
        self.card.chunks_exact_mut(2).for_each(|pair| pair.copy_from_slice(&number));
        (&self.card, &self.card[..pixels])
    }

    fn look_in_colour(&mut self, shot: u64) -> Option<(&[u8], &[u8])> {
        let (depth, _) = self.look(shot, (640, 480));
        Some((depth, depth))
    }
}

/// Images from a file: those of 640x480, shot after shot, depth then infrared, and nothing between them.
/// Behind the last one it goes back to the first; other sizes are cut out of the middle.
#[derive(Debug)]
pub struct Film {
    file: File,
    shots: u64,
    whole: Vec<u8>,
    cut: Vec<u8>,
}

/// Pixels in a row, rows of a film.
const FILM: (usize, usize) = (640, 480);
/// Bytes of a shot on film.
const SHOT_BYTES: usize = FILM.0 * FILM.1 * 3;

impl Film {
    /// Opens a film.
    ///
    /// # Errors
    /// The system's error, and [`io::ErrorKind::InvalidData`] when the file does not hold whole shots.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let bytes = file.metadata()?.len();
        let shots = bytes / SHOT_BYTES as u64;
        if shots == 0 || shots * SHOT_BYTES as u64 != bytes {
            let why = format!("{bytes} bytes are not a whole number of shots of {SHOT_BYTES}");
            return Err(io::Error::new(io::ErrorKind::InvalidData, why));
        }
        Ok(Self { file, shots, whole: vec![0; SHOT_BYTES], cut: Vec::new() })
    }

    /// There and back again, so that a motion never jumps and never rests: 0 1 2 1 0 1 ...
    fn place(&self, shot: u64) -> u64 {
        let last = self.shots - 1;
        let on_the_way = shot % (2 * last).max(1);
        on_the_way.min(2 * last - on_the_way.min(2 * last))
    }

    fn read(&mut self, shot: u64) {
        let at = self.place(shot) * SHOT_BYTES as u64;
        // A file that cannot be read any more leaves the last image: the reader sees a frozen liquid.
        let _read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(&mut self.whole));
    }

    /// The middle of the images.
    fn crop(&mut self, size: (usize, usize)) {
        let (width, height) = size;
        let (left, top) = ((FILM.0 - width) / 2, (FILM.1 - height) / 2);
        self.cut.clear();
        for (start, bytes) in [(0, 2), (FILM.0 * FILM.1 * 2, 1)] {
            for row in top..top + height {
                let at = start + (row * FILM.0 + left) * bytes;
                self.cut.extend_from_slice(&self.whole[at..at + width * bytes]);
            }
        }
    }
}

impl Scenery for Film {
    fn look(&mut self, shot: u64, size: (u16, u16)) -> (&[u8], &[u8]) {
        self.read(shot);
        let size = (usize::from(size.0).min(FILM.0), usize::from(size.1).min(FILM.1));
        if size == FILM {
            return self.whole.split_at(FILM.0 * FILM.1 * 2);
        }
        self.crop(size);
        self.cut.split_at(size.0 * size.1 * 2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_goes_there_and_back() {
        let path = std::env::temp_dir().join(format!("meniscus-film-{}", std::process::id()));
        let shots: Vec<u8> = [1, 2, 3].into_iter().flat_map(|shot: u8| vec![shot; SHOT_BYTES]).collect();
        std::fs::write(&path, &shots).expect("written");
        let mut film = Film::open(&path).expect("three shots");
        for (shot, byte) in [(0, 1), (1, 2), (2, 3), (3, 2), (4, 1), (7, 2)] {
            let (depth, infrared) = film.look(shot, (640, 480));
            assert_eq!((depth.len(), infrared.len()), (614_400, 307_200));
            assert!(depth.iter().chain(infrared).all(|b| *b == byte), "shot {shot}");
        }
        let (depth, infrared) = film.look(0, (480, 270));
        assert_eq!((depth.len(), infrared.len()), (480 * 270 * 2, 480 * 270));
        std::fs::write(&path, [0; 10]).expect("written");
        assert!(Film::open(&path).is_err(), "no whole shot");
        std::fs::remove_file(&path).expect("removed");
    }
}
