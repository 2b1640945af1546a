//! Files: written beside and renamed, read into memory that weights can be read in place from.

use crate::large_pages::{LARGE_PAGE, ask_for};
use std::fmt;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};

/// Held for reading by every write, for writing by the end of a program that is interrupted.
static WRITES: RwLock<()> = RwLock::new(());

/// A file could not be read or written.
#[derive(Debug)]
pub struct FileError {
    /// Which.
    pub path: PathBuf,
    /// Operation that failed.
    pub doing: &'static str,
    /// Error of the system.
    pub cause: io::Error,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot {} {}: {}", self.doing, self.path.display(), self.cause)
    }
}

// What the system said stands in the message, so it is no source beside it.
impl std::error::Error for FileError {}

/// Writes `bytes` to `path` so that there is the old file or the new one, never a part: into a file
/// beside it, synced, then renamed. The folder is made if it is not there.
///
/// # Errors
/// [`FileError`]; the file beside is removed then.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let failed = |doing, cause| FileError { path: path.into(), doing, cause };
    let _writing = WRITES.read().unwrap_or_else(PoisonError::into_inner);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    if let Some(folder) = folder {
        fs::create_dir_all(folder).map_err(|cause| failed("make the folder of", cause))?;
    }
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let written = fs::File::create(&beside).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&beside, path)
    });
    written.map_err(|cause| {
        // What is left of it helps nobody; that it cannot be removed either adds nothing.
        let _left = fs::remove_file(&beside);
        failed("write", cause)
    })
}

/// Waits until every [`write_whole`] under way has ended, and holds back all later ones: for a program that is about to end.
pub fn finish_writes() {
    std::mem::forget(WRITES.write().unwrap_or_else(PoisonError::into_inner));
}

/// Checks before the work that [`write_whole`] will be able to write `path`: makes its folder, and a file beside it that is
/// removed again. What lies at `path` stays.
///
/// # Errors
/// [`FileError`]: the folder cannot be made or written to, or `path` is a folder.
pub fn check_writable(path: &Path) -> Result<(), FileError> {
    if path.is_dir() {
        let cause = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; name a file in it");
        return Err(FileError { path: path.into(), doing: "write", cause });
    }
    let mut beside = path.as_os_str().to_owned();
    beside.push(".trial");
    let beside = PathBuf::from(beside);
    write_whole(&beside, b"").map_err(|error| FileError { path: path.into(), ..error })?;
    fs::remove_file(&beside).map_err(|cause| FileError { path: beside, doing: "remove", cause })
}

/// The bytes of a file, starting on a 64-byte boundary, as a blob has to; many of them on one of large pages.
#[derive(Debug)]
pub struct AlignedBytes {
    room: Vec<u8>,
    start: usize,
}

impl AlignedBytes {
    /// Boundary on which few bytes start.
    const BOUNDARY: usize = 64;

    /// Reads a whole file.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let bytes = fs::read(path).map_err(|cause| FileError { path: path.into(), doing: "read", cause })?;
        Ok(Self::copy(&bytes))
    }

    /// Copies `bytes` to such a place.
    #[must_use]
    pub fn copy(bytes: &[u8]) -> Self {
        let boundary = if bytes.len() < LARGE_PAGE { Self::BOUNDARY } else { LARGE_PAGE };
        // So many zeros are mapped when they are first written to: before that they take no memory, unless all is locked.
        let mut room = vec![0; bytes.len() + boundary];
        let start = room.as_ptr().align_offset(boundary).min(boundary);
        ask_for(&mut room[start..]);
        room[start..start + bytes.len()].copy_from_slice(bytes);
        room.truncate(start + bytes.len());
        Self { room, start }
    }
}

impl std::ops::Deref for AlignedBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.room[self.start..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("meniscus-files-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).expect("a temporary folder");
        folder
    }

    #[test]
    fn bytes_come_back_aligned() {
        let path = folder("aligned").join("deep/er/file");
        for (length, boundary) in [(1000, 64), (LARGE_PAGE + 5, LARGE_PAGE)] {
            let written: Vec<u8> = (0..length).map(|k| (k % 251) as u8).collect();
            write_whole(&path, &written).expect("writable");
            let bytes = AlignedBytes::read(&path).expect("readable");
            assert!(*bytes == *written);
            assert_eq!(bytes.as_ptr().align_offset(boundary), 0);
        }
        assert_eq!(fs::read_dir(path.parent().expect("a folder")).expect("listed").count(), 1);
    }

    #[test]
    fn a_path_is_checked_without_touching_what_is_there() {
        let there = folder("checked").join("there");
        write_whole(&there, b"old").expect("writable");
        check_writable(&there).expect("it can be replaced");
        check_writable(&folder("checked").join("new/file")).expect("its folder can be made");
        assert_eq!(fs::read(&there).expect("still there"), b"old");
        assert_eq!(
            fs::read_dir(folder("checked")).expect("listed").count(),
            2,
            "the file and the folder `new`"
        );
        let why = check_writable(&folder("checked")).expect_err("a folder").to_string();
        assert!(why.contains("name a file in it"), "{why}");
        let why = check_writable(&there.join("below")).expect_err("below a file").to_string();
        assert!(why.starts_with("cannot make the folder of"), "{why}");
    }

    #[test]
    fn a_folder_in_the_way_is_reported_and_kept() {
        let path = folder("blocked").join("taken");
        fs::create_dir_all(path.join("inside")).expect("a folder in the way");
        let error = write_whole(&path, b"new").expect_err("a folder cannot be replaced");
        assert!(error.to_string().contains("taken"), "{error}");
        assert!(path.join("inside").exists());
        assert!(!path.with_extension("part").exists());
    }
}
