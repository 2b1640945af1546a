//! Output files: checked before the work, and replaced with `--force` alone.

use anyhow::ensure;
use meniscus_platform::files::check_writable;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Folders that the checks below have made, inner ones first: a refused command leaves none of them behind.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

// No documentation here: clap would take it for that of the verb.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub(super) struct Force {
    /// Replace output files that exist.
    #[arg(long, help_heading = "Output")]
    force: bool,
}

impl Force {
    /// Refuses `path` where a file exists, or where none can be written.
    pub(super) fn check(self, path: &Path) -> anyhow::Result<()> {
        self.check_absent(path)?;
        note_folders(path);
        Ok(check_writable(path)?)
    }

    /// Refuses `path` where something exists that would be replaced: a file, or a folder that is not empty.
    pub(super) fn check_absent(self, path: &Path) -> anyhow::Result<()> {
        let full = path.read_dir().is_ok_and(|mut entries| entries.next().is_some());
        ensure!(
            self.force || !(path.is_file() || full),
            "{} exists already: choose another name, or replace it with --force",
            path.display()
        );
        Ok(())
    }
}

/// Refuses a folder in which no file can be written; it is made if it is not there.
#[cfg(any(all(feature = "bags", feature = "desk"), test))]
pub(super) fn check_folder(folder: &Path) -> anyhow::Result<()> {
    let file = folder.join("meniscus");
    note_folders(&file);
    Ok(check_writable(&file)?)
}

/// Notes the folders above `path` that are not there yet and will be made.
pub(super) fn note_folders(path: &Path) {
    let missing =
        path.ancestors().skip(1).take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists());
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    made.extend(missing.map(Path::to_path_buf));
}

/// Removes the noted folders that are still empty, inner ones first. Others stay.
pub(super) fn remove_empty() {
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    for folder in std::mem::take(&mut *made) {
        // A folder with files is not removed, and what cannot be removed does no harm.
        let _kept = std::fs::remove_dir(folder);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_force_replaces_a_file() {
        let folder = std::env::temp_dir().join(format!("meniscus-outputs-{}", std::process::id()));
        let file = folder.join("old");
        let (plain, force) = (Force::default(), Force { force: true });
        plain.check(&file).expect("nothing is there");
        std::fs::write(&file, "old").expect("written");
        let why = plain.check(&file).expect_err("refused").to_string();
        assert!(why.contains("exists already") && why.contains("--force"), "{why}");
        force.check(&file).expect("forced");
        assert!(plain.check_absent(&folder).is_err() && force.check_absent(&folder).is_ok());
        check_folder(&folder).expect("writable");
        let why = check_folder(&file).expect_err("a file is no folder").to_string();
        assert!(why.contains("cannot make the folder of"), "{why}");
        assert_eq!(std::fs::read(&file).expect("kept"), b"old");
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
