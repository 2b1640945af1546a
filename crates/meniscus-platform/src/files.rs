//! Files: written beside and renamed, read into memory that weights can be read in place from.

use crate::large_pages::{LARGE_PAGE, ask_for};
use rustix::fs::OFlags;
use std::fmt;
use std::fs;
use std::io::{self, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
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
    let written = create_anew(&beside).and_then(|mut file| {
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

/// Makes a file that is not there, in place of what has its name: the rest of a write that was killed, or a link that somebody
/// has put there. The file behind such a link stays as it is.
///
/// # Errors
/// The error of the operating system. Where two processes make the same file at once, one of them gets
/// [`AlreadyExists`](io::ErrorKind::AlreadyExists).
pub fn create_anew(path: &Path) -> io::Result<fs::File> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    // Exclusive creation follows no link; the flag says so once more.
    let flags = OFlags::NOFOLLOW.bits().cast_signed();
    fs::OpenOptions::new().write(true).create_new(true).custom_flags(flags).open(path)
}

/// Whether a link at the end of a path is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Links {
    /// It is: a person has named the path.
    Followed,
    /// It is an error: the folder belongs to somebody else.
    Refused,
}

/// Opens a file for reading, and nothing that only looks like one: neither a device, which never ends, nor a pipe, at which the
/// program would wait.
///
/// # Errors
/// The error of the operating system, and [`InvalidInput`](io::ErrorKind::InvalidInput) for what is no file.
pub fn open_regular(path: &Path, links: Links) -> io::Result<fs::File> {
    let mut flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    if links == Links::Refused {
        flags |= OFlags::NOFOLLOW;
    }
    let file = fs::OpenOptions::new().read(true).custom_flags(flags.bits().cast_signed()).open(path)?;
    let kind = file.metadata()?.file_type();
    if !kind.is_file() {
        let what =
            if kind.is_dir() { "it is a folder" } else { "it is a device, a pipe or a socket, and no file" };
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    Ok(file)
}

/// Reads a whole file of at most `longest` bytes; devices and pipes are refused.
///
/// # Errors
/// As [`open_regular`], and [`FileTooLarge`](io::ErrorKind::FileTooLarge).
pub fn read_regular(path: &Path, longest: u64, links: Links) -> io::Result<Vec<u8>> {
    let mut file = open_regular(path, links)?;
    let length = file.metadata()?.len();
    let too_large = || {
        let what = format!("it is longer than {} MiB, which no such file is", longest >> 20);
        io::Error::new(io::ErrorKind::FileTooLarge, what)
    };
    if length > longest {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // A file may grow while it is read.
    let read = (&mut file).take(longest + 1).read_to_end(&mut bytes)?;
    if read as u64 > longest { Err(too_large()) } else { Ok(bytes) }
}

/// Longest text that is read, bytes.
const LONGEST_TEXT: u64 = 64 << 20;

/// Reads a text of at most 64 MiB. It may come from a pipe; a device that never ends is refused at that length.
///
/// # Errors
/// The error of the operating system, [`FileTooLarge`](io::ErrorKind::FileTooLarge), and
/// [`InvalidData`](io::ErrorKind::InvalidData) for what is no UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = String::new();
    let mut bytes = fs::File::open(path)?.take(LONGEST_TEXT + 1);
    let read = bytes.read_to_string(&mut text);
    // A cut at the limit may have split a letter: the length is what is wrong then.
    if bytes.limit() == 0 {
        let what = format!("it is longer than {} MiB, which no such text is", LONGEST_TEXT >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, what));
    }
    read.map(|_| text)
}

/// A folder that one run of the program writes into; dropping it lets the next one in.
///
/// A folder that was made for the lock and is still empty goes with it.
#[derive(Debug)]
pub struct FolderLock {
    _folder: fs::File,
    made: Option<PathBuf>,
}

impl FolderLock {
    /// Locks the folder at `path`, which is made if it is not there.
    ///
    /// # Errors
    /// [`FileError`]; its cause is [`ResourceBusy`](io::ErrorKind::ResourceBusy) while another run has it.
    pub fn take(path: &Path) -> Result<Self, FileError> {
        let failed = |doing, cause| FileError { path: path.into(), doing, cause };
        let made = (!path.exists()).then(|| path.to_path_buf());
        fs::create_dir_all(path).map_err(|cause| failed("make the folder", cause))?;
        let folder = fs::File::open(path).map_err(|cause| failed("open the folder", cause))?;
        match folder.try_lock() {
            // Some file systems of a network know no locks: there nothing can be kept out.
            Ok(()) | Err(fs::TryLockError::Error(_)) => Ok(Self { _folder: folder, made }),
            Err(fs::TryLockError::WouldBlock) => {
                let why = "another run writes there; wait for its end, or name another folder with --out";
                Err(failed("use the folder", io::Error::new(io::ErrorKind::ResourceBusy, why)))
            }
        }
    }
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // A folder with files is not removed.
        let _kept = self.made.take().map(fs::remove_dir);
    }
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

    /// Longest file: a model of the largest size has a tenth of it.
    pub const LONGEST: u64 = 128 << 20;

    /// Reads a whole file of at most [`Self::LONGEST`] bytes.
    ///
    /// # Errors
    /// [`FileError`].
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let bytes = read_regular(path, Self::LONGEST, Links::Followed);
        let bytes = bytes.map_err(|cause| FileError { path: path.into(), doing: "read", cause })?;
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
    fn a_planted_link_is_replaced_and_its_file_kept() {
        let folder = folder("planted");
        let (victim, path) = (folder.join("victim"), folder.join("file"));
        fs::write(&victim, b"kept").expect("written");
        let _old = fs::remove_file(folder.join("file.part"));
        std::os::unix::fs::symlink(&victim, folder.join("file.part")).expect("a link");
        write_whole(&path, b"new").expect("written");
        assert_eq!(fs::read(&victim).expect("readable"), b"kept");
        assert!(fs::symlink_metadata(&path).expect("there").is_file(), "no link took the file's place");
        std::os::unix::fs::symlink(&victim, folder.join("link")).expect("a link");
        assert_eq!(read_regular(&folder.join("link"), 10, Links::Followed).expect("followed"), b"kept");
        assert!(read_regular(&folder.join("link"), 10, Links::Refused).is_err());
        fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn devices_and_long_files_are_not_read() {
        let why =
            |path: &str| read_regular(Path::new(path), 1 << 20, Links::Followed).expect_err(path).to_string();
        assert!(why("/dev/zero").contains("a device, a pipe or a socket"), "{}", why("/dev/zero"));
        assert!(why("/").contains("it is a folder"));
        let error = read_text(Path::new("/dev/zero")).expect_err("it never ends");
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
        let path = folder("long").join("file");
        fs::write(&path, [0; 100]).expect("written");
        assert_eq!(read_regular(&path, 100, Links::Followed).expect("read").len(), 100);
        let error = read_regular(&path, 99, Links::Followed).expect_err("too long");
        assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
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
