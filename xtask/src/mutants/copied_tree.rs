//! Copy of the workspace's files, in which one text at a time is replaced.

use super::mutations::Mutation;
use crate::process;
use anyhow::{Context, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// Copy of the tracked and the new files.
pub(super) struct CopiedTree {
    root: PathBuf,
}

impl CopiedTree {
    /// Brings the copy at `to` up to date. A file that has not changed keeps its time, so that it is not compiled again.
    pub(super) fn of(from: &Path, to: &Path) -> Result<Self> {
        let listed =
            process::output(from, ["git", "ls-files", "--cached", "--others", "--exclude-standard"])?;
        for path in listed.lines() {
            // A file that was deleted and not committed is still listed.
            if let Ok(about) = from.join(path).symlink_metadata() {
                renew(&from.join(path), &to.join(path), about.is_symlink())
                    .with_context(|| format!("{path} cannot be copied"))?;
            }
        }
        Ok(Self { root: to.to_owned() })
    }

    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Applies a mutation until the result is dropped; `None` if its text does not stand in the file exactly once.
    pub(super) fn mutated(&self, mutation: &Mutation) -> Result<Option<Mutated>> {
        let path = self.root.join(mutation.file);
        let original = fs::read_to_string(&path).with_context(|| format!("{} is absent", path.display()))?;
        if original.matches(mutation.old).count() != 1 {
            return Ok(None);
        }
        fs::write(&path, original.replacen(mutation.old, mutation.new, 1))?;
        Ok(Some(Mutated { path, original }))
    }
}

/// Mutation that is taken back when this is dropped.
pub(super) struct Mutated {
    path: PathBuf,
    original: String,
}

impl Drop for Mutated {
    fn drop(&mut self) {
        // The next run brings the copy up to date whatever is left here.
        let _ = fs::write(&self.path, &self.original);
    }
}

/// Copies a file, or a link as such, unless the same is there.
fn renew(from: &Path, to: &Path, link: bool) -> std::io::Result<()> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    if link {
        let leads_to = fs::read_link(from)?;
        if fs::read_link(to).is_ok_and(|there| there == leads_to) {
            return Ok(());
        }
        let _absent = fs::remove_file(to);
        return std::os::unix::fs::symlink(leads_to, to);
    }
    let bytes = fs::read(from)?;
    if fs::read(to).is_ok_and(|there| there == bytes) { Ok(()) } else { fs::write(to, bytes) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutants::mutations::Tests;

    #[test]
    fn a_mutation_is_taken_back_and_one_that_does_not_fit_is_refused() {
        let root = std::env::temp_dir().join(format!("meniscus-mutants-{}", std::process::id()));
        fs::create_dir_all(&root).unwrap();
        fs::write(root.join("a.rs"), "x + y; z; z").unwrap();
        let copy = CopiedTree { root: root.clone() };
        let of = |old| Mutation { file: "a.rs", old, new: "-", mistake: "", tests: Tests::Unit };
        let text = || fs::read_to_string(root.join("a.rs")).unwrap();
        let mutated = copy.mutated(&of("+")).unwrap().expect("it fits");
        assert_eq!(text(), "x - y; z; z");
        drop(mutated);
        assert_eq!(text(), "x + y; z; z");
        assert!(copy.mutated(&of("z")).unwrap().is_none() && copy.mutated(&of("q")).unwrap().is_none());
        fs::remove_dir_all(&root).unwrap();
    }
}
