//! The page's one library, as committed, is the package's own file and licence, byte for byte.

#[path = "support/optional.rs"]
mod optional;

use optional::skip;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The committed folder: package.json and its lock, which holds the package's checksum.
const VENDOR: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/meniscus-ui/src/page/assets/vendor");

/// Committed files and where the package has them.
const FILES: [(&str, &str); 2] =
    [("twgl-full.module.js", "dist/7.x/twgl-full.module.js"), ("LICENSE.md", "LICENSE.md")];

#[test]
fn the_committed_library_is_the_packages_own() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("vendored");
    let _old = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    for name in ["package.json", "package-lock.json"] {
        fs::copy(Path::new(VENDOR).join(name), folder.join(name)).expect("copied");
    }
    // npm holds what it fetches against the lock's checksum.
    let fetched = Command::new("npm").args(["ci", "--ignore-scripts"]).current_dir(&folder).output();
    match fetched {
        Err(error) => skip(&format!("npm cannot be run here ({error})")),
        Ok(output) if !output.status.success() => {
            let words = String::from_utf8_lossy(&output.stderr);
            assert!(!words.contains("EINTEGRITY"), "the package is not the one of the lock: {words}");
            skip(&format!("npm cannot fetch the package here: {words}"));
        }
        Ok(_) => {
            for (committed, packaged) in FILES {
                let own =
                    fs::read(folder.join("node_modules/twgl.js").join(packaged)).expect("in the package");
                let ours = fs::read(Path::new(VENDOR).join(committed)).expect("committed");
                assert!(own == ours, "{committed} is not the package's {packaged}");
            }
        }
    }
}
