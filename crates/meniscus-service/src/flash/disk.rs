//! The few things that flashing does to a disk, one by one, so that the power can be cut between any two.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A folder on a disk.
pub trait Disk {
    /// Everything in a file.
    ///
    /// # Errors
    /// What the system says.
    fn read(&self, file: &str) -> io::Result<Vec<u8>>;

    /// Makes or replaces a file; a power cut may leave any part of it.
    ///
    /// # Errors
    /// What the system says.
    fn write(&mut self, file: &str, bytes: &[u8]) -> io::Result<()>;

    /// Behind this call the file's bytes survive a power cut.
    ///
    /// # Errors
    /// What the system says.
    fn sync(&mut self, file: &str) -> io::Result<()>;

    /// Gives a file another name, replacing what has it.
    ///
    /// # Errors
    /// What the system says.
    fn rename(&mut self, from: &str, to: &str) -> io::Result<()>;

    /// Behind this call the names survive a power cut.
    ///
    /// # Errors
    /// What the system says.
    fn sync_folder(&mut self) -> io::Result<()>;
}

/// A folder of this machine.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// The folder, made if it is not there.
    ///
    /// # Errors
    /// What the system says.
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

impl Disk for Folder {
    fn read(&self, file: &str) -> io::Result<Vec<u8>> {
        fs::read(self.0.join(file))
    }

    fn write(&mut self, file: &str, bytes: &[u8]) -> io::Result<()> {
        let path = self.0.join(file);
        let written = File::create(&path)?.write_all(bytes);
        if written.is_err() {
            // A part keeps a full disk full; that it cannot be removed either adds nothing.
            let _left = fs::remove_file(&path);
        }
        written
    }

    fn sync(&mut self, file: &str) -> io::Result<()> {
        File::open(self.0.join(file))?.sync_all()
    }

    fn rename(&mut self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.0.join(from), self.0.join(to))
    }

    fn sync_folder(&mut self) -> io::Result<()> {
        File::open(&self.0)?.sync_all()
    }
}
