//! Fits that were made are not made again: each is a small file named after everything that went into it.
//!
//! A file holds the fitted numbers as little-endian doubles; what follows from them (residuals,
//! derivatives) is computed anew. Its name is a digest of the recordings, of what they are weighed with, of
//! where the fit starts and of the version of the rules.

use crc::{CRC_64_ECMA_182, Crc, Digest};
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Raised when a fit comes out otherwise than it did.
const VERSION: f64 = 1.0;

static CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// A digest in the making.
pub struct Name(Digest<'static, u64>);

impl Name {
    /// One that holds the version.
    #[must_use]
    pub fn new() -> Self {
        let mut name = Self(CRC.digest());
        name.add([VERSION]);
        name
    }

    /// Adds numbers.
    pub fn add<T: std::borrow::Borrow<f64>>(&mut self, values: impl IntoIterator<Item = T>) {
        values.into_iter().for_each(|value| self.0.update(&value.borrow().to_le_bytes()));
    }

    /// Adds a word.
    pub fn say(&mut self, word: &str) {
        self.0.update(word.as_bytes());
        self.0.update(&[0]);
    }

    /// The digest.
    #[must_use]
    pub fn done(self) -> u64 {
        self.0.finalize()
    }
}

impl Default for Name {
    fn default() -> Self {
        Self::new()
    }
}

/// A folder of fits.
#[derive(Debug)]
pub struct Kept {
    folder: PathBuf,
    taken: AtomicUsize,
    made: AtomicUsize,
    lost: AtomicUsize,
}

impl Kept {
    /// Fits in `folder`, which is made with the first of them.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        let zero = || AtomicUsize::new(0);
        Self { folder: folder.into(), taken: zero(), made: zero(), lost: zero() }
    }

    fn path(&self, name: u64) -> PathBuf {
        self.folder.join(format!("{name:016x}.fit"))
    }

    /// The `count` numbers under `name`; none where they are not there or not whole.
    #[must_use]
    pub fn take(&self, name: u64, count: usize) -> Option<Vec<f64>> {
        let bytes = std::fs::read(self.path(name)).ok()?;
        let values: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        let whole = bytes.len() == 8 * count && values.iter().all(|v| v.is_finite());
        self.taken.fetch_add(usize::from(whole), Ordering::Relaxed);
        whole.then_some(values)
    }

    /// Keeps `values` under `name`. One that cannot be written is counted and costs a fit the next time.
    pub fn keep(&self, name: u64, values: &[f64]) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let lost = write_whole(&self.path(name), &bytes).is_err();
        self.made.fetch_add(1, Ordering::Relaxed);
        self.lost.fetch_add(usize::from(lost), Ordering::Relaxed);
    }

    /// How many fits were taken from the folder, made, and could not be written.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        [&self.taken, &self.made, &self.lost].map(|count| count.load(Ordering::Relaxed))
    }
}
