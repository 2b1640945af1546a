//! The few things that flashing does to a disk, one by one, so that the power can be cut between any two.

use meniscus_platform::files::{AlignedBytes, Links, create_anew, open_regular, read_regular};
use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Files that a flash which was killed may have left.
const PARTS: [&str; 5] =
    ["slot-a.blob.part", "slot-a.sig.part", "slot-b.blob.part", "slot-b.sig.part", "active.part"];

/// A folder on a disk.
pub trait Disk {
    /// Keeps every other flash out of the folder until the value is dropped, and removes what one that was killed has left.
    ///
    /// # Errors
    /// The error of the operating system; [`ResourceBusy`](io::ErrorKind::ResourceBusy) while another flash is under way.
    fn begin(&mut self) -> io::Result<Option<File>> {
        Ok(None)
    }

    /// Removes a file; one that is not there is as good.
    ///
    /// # Errors
    /// The error of the operating system.
    fn remove(&mut self, file: &str) -> io::Result<()>;

    /// Everything in a file.
    ///
    /// # Errors
    /// The error of the operating system.
    fn read(&self, file: &str) -> io::Result<Vec<u8>>;

    /// Makes or replaces a file; a power cut may leave any part of it.
    ///
    /// # Errors
    /// The error of the operating system.
    fn write(&mut self, file: &str, bytes: &[u8]) -> io::Result<()>;

    /// Behind this call the file's bytes survive a power cut.
    ///
    /// # Errors
    /// The error of the operating system.
    fn sync(&mut self, file: &str) -> io::Result<()>;

    /// Gives a file another name, replacing what has it.
    ///
    /// # Errors
    /// The error of the operating system.
    fn rename(&mut self, from: &str, to: &str) -> io::Result<()>;

    /// Behind this call the names survive a power cut.
    ///
    /// # Errors
    /// The error of the operating system.
    fn sync_folder(&mut self) -> io::Result<()>;
}

/// A folder of this machine.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder, made if it is not there.
    ///
    /// # Errors
    /// The error of the operating system.
    pub fn create(path: &Path) -> io::Result<Self> {
        fs::create_dir_all(path)?;
        Ok(Self(path.into()))
    }

    /// The folder, as it is.
    #[must_use]
    pub fn at(path: &Path) -> Self {
        Self(path.into())
    }
}

// The folder may belong to somebody else than the user of the flash, who may be root: no link in it is followed.
impl Disk for Folder {
    fn begin(&mut self) -> io::Result<Option<File>> {
        // The lock of the folder itself needs no file in it.
        let folder = File::open(&self.0)?;
        match folder.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(io::Error::new(io::ErrorKind::ResourceBusy, "another flash is under way there"));
            }
            Err(TryLockError::Error(error)) => return Err(error),
        }
        PARTS.iter().try_for_each(|file| self.remove(file))?;
        Ok(Some(folder))
    }

    fn remove(&mut self, file: &str) -> io::Result<()> {
        match fs::remove_file(self.0.join(file)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    fn read(&self, file: &str) -> io::Result<Vec<u8>> {
        read_regular(&self.0.join(file), AlignedBytes::LONGEST, Links::Refused)
    }

    fn write(&mut self, file: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.0.join(file);
        let written = create_anew(&path)?.write_all(bytes);
        if written.is_err() {
            // A part keeps a full disk full; that it cannot be removed either adds nothing.
            let _left = fs::remove_file(&path);
        }
        written
    }

    fn sync(&mut self, file: &str) -> io::Result<()> {
        open_regular(&self.0.join(file), Links::Refused)?.sync_all()
    }

    fn rename(&mut self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.0.join(from), self.0.join(to))
    }

    fn sync_folder(&mut self) -> io::Result<()> {
        File::open(&self.0)?.sync_all()
    }
}
