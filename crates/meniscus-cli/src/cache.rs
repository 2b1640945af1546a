//! Folder of what can be made again: `$XDG_CACHE_HOME/meniscus`, or `~/.cache/meniscus`.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Keeps settled glasses of the simulator from one call of the program to the next.
pub(crate) fn keep_settled() {
    if let Some(folder) = folder(std::env::var_os("XDG_CACHE_HOME"), std::env::var_os("HOME")) {
        meniscus_sph::keep_settled_in(&folder.join("settled"));
    }
}

/// The folder under these two variables; a relative path in them is none (XDG Base Directory Specification 0.8).
fn folder(caches: Option<OsString>, home: Option<OsString>) -> Option<PathBuf> {
    let absolute = |path: OsString| Path::new(&path).is_absolute().then(|| PathBuf::from(path));
    let caches = caches.and_then(absolute).or_else(|| Some(home.and_then(absolute)?.join(".cache")))?;
    Some(caches.join("meniscus"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_folder_is_none() {
        let folder = |caches: &str, home: &str| {
            folder(Some(caches.into()), Some(home.into())).map(|path| path.display().to_string())
        };
        assert_eq!(folder("/var/caches", "/home/me").as_deref(), Some("/var/caches/meniscus"));
        assert_eq!(folder("caches", "/home/me").as_deref(), Some("/home/me/.cache/meniscus"));
        assert_eq!(folder("", "me"), None);
    }
}
