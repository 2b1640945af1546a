//! Cache of fits on disk: each is a small file named after a digest of all its inputs.
//!
//! A file holds the fitted numbers as little-endian doubles; residuals and derivatives are computed again from them. The
//! digest covers the recordings, their whitening, the start of the fit and the version of the rules.

use crc::{CRC_64_ECMA_182, Crc, Digest};
use meniscus_platform::files::write_whole;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Version of the fits, raised when the same inputs give another result.
const VERSION: f64 = 2.0;

static CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_ECMA_182);

/// Digest of the inputs of a fit.
pub struct CacheKey(Digest<'static, u64>);

impl CacheKey {
    /// Starts a digest that holds the version.
    #[must_use]
    pub fn new() -> Self {
        let mut key = Self(CRC.digest());
        key.add([VERSION]);
        key
    }

    /// Adds numbers.
    pub fn add<T: std::borrow::Borrow<f64>>(&mut self, values: impl IntoIterator<Item = T>) {
        values.into_iter().for_each(|value| self.0.update(&value.borrow().to_le_bytes()));
    }

    /// Adds a word.
    pub fn add_word(&mut self, word: &str) {
        self.0.update(word.as_bytes());
        self.0.update(&[0]);
    }

    /// Returns the digest.
    #[must_use]
    pub fn finish(self) -> u64 {
        self.0.finalize()
    }
}

impl Default for CacheKey {
    fn default() -> Self {
        Self::new()
    }
}

/// Use of a cache so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FitCounts {
    /// Fits that were read from the cache.
    pub reused: usize,
    /// Fits that were computed.
    pub computed: usize,
    /// Computed fits that could not be written.
    pub unwritten: usize,
}

/// Folder of fits.
#[derive(Debug)]
pub struct FitCache {
    folder: PathBuf,
    reused: AtomicUsize,
    computed: AtomicUsize,
    unwritten: AtomicUsize,
}

impl FitCache {
    /// Opens the cache in `folder`, which is created with the first fit.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        let zero = || AtomicUsize::new(0);
        Self { folder: folder.into(), reused: zero(), computed: zero(), unwritten: zero() }
    }

    /// Returns the folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, key: u64) -> PathBuf {
        self.folder.join(format!("{key:016x}.fit"))
    }

    /// Returns the `count` numbers under `key`; none where the file is missing or incomplete.
    #[must_use]
    pub fn get(&self, key: u64, count: usize) -> Option<Vec<f64>> {
        let bytes = std::fs::read(self.path(key)).ok()?;
        let values: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect();
        let whole = bytes.len() == 8 * count && values.iter().all(|v| v.is_finite());
        self.reused.fetch_add(usize::from(whole), Ordering::Relaxed);
        whole.then_some(values)
    }

    /// Writes `values` under `key`. A fit that cannot be written is counted, and computed again the next time.
    pub fn put(&self, key: u64, values: &[f64]) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let unwritten = write_whole(&self.path(key), &bytes).is_err();
        self.computed.fetch_add(1, Ordering::Relaxed);
        self.unwritten.fetch_add(usize::from(unwritten), Ordering::Relaxed);
    }

    /// Returns how the cache was used so far.
    #[must_use]
    pub fn counts(&self) -> FitCounts {
        let [reused, computed, unwritten] =
            [&self.reused, &self.computed, &self.unwritten].map(|count| count.load(Ordering::Relaxed));
        FitCounts { reused, computed, unwritten }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_is_found_again_and_one_that_was_cut_short_is_not() {
        let folder = std::env::temp_dir().join(format!("meniscus-fit-cache-{}", std::process::id()));
        let cache = FitCache::new(&folder);
        assert_eq!(cache.get(7, 2), None);
        cache.put(7, &[1.5, -2.0]);
        assert_eq!(cache.get(7, 2), Some(vec![1.5, -2.0]));
        assert_eq!(cache.get(7, 3), None, "another count");
        std::fs::write(cache.path(7), [0; 5]).expect("written");
        assert_eq!(cache.get(7, 2), None, "cut short");
        assert_eq!(cache.counts(), FitCounts { reused: 1, computed: 1, unwritten: 0 });
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn words_and_numbers_change_the_key() {
        let key = |word: &str, number: f64| {
            let mut key = CacheKey::new();
            key.add_word(word);
            key.add([number]);
            key.finish()
        };
        assert_eq!(key("foam", 1.0), key("foam", 1.0));
        assert_ne!(key("foam", 1.0), key("fill", 1.0));
        assert_ne!(key("foam", 1.0), key("foam", 1.5));
    }
}
