//! Bytes that a crate embeds by `include_bytes!` and `include_str!`.

use super::sources::Source;
use crate::report::{Check, Target};
use crate::workspace::shown;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};
use syn::visit::{self, Visit};

/// The crate that embeds data for everyone.
const CRATE: &str = "meniscus-shipped";
/// A registry takes archives of 10 MB; data hardly shrink.
const MOST: f64 = 8.0e6;

/// Sum of the files that [`CRATE`] embeds.
pub(super) fn check(root: &Path, all: &[Source]) -> Result<Check> {
    let mut sizes = Vec::new();
    for source in all.iter().filter(|source| source.package.as_deref() == Some(CRATE)) {
        for file in embedded(source) {
            let size = std::fs::metadata(&file)
                .with_context(|| format!("{} embeds {}", source.path.display(), file.display()))?
                .len();
            sizes.push((size, shown(root, &file)));
        }
    }
    Ok(of_sizes(sizes))
}

fn of_sizes(mut sizes: Vec<(u64, String)>) -> Check {
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    Check {
        name: "largest_embedded_bytes",
        value: sizes.iter().map(|(size, _)| *size as f64).sum(),
        unit: "bytes",
        target: Target::AtMost(MOST),
        offenders: sizes.into_iter().map(|(size, path)| format!("{path}: {size} bytes")).collect(),
    }
}

/// Files that a source embeds.
fn embedded(source: &Source) -> Vec<PathBuf> {
    struct Found(Vec<String>);
    impl<'a> Visit<'a> for Found {
        fn visit_macro(&mut self, it: &'a syn::Macro) {
            let named = |name| it.path.segments.last().is_some_and(|segment| segment.ident == name);
            if (named("include_bytes") || named("include_str"))
                && let Ok(path) = it.parse_body::<syn::LitStr>()
            {
                self.0.push(path.value());
            } else {
                // Lists of them stand inside other macros only in tests.
                visit::visit_macro(self, it);
            }
        }
    }
    let mut found = Found(Vec::new());
    found.visit_file(&source.syntax);
    let folder = source.path.parent().unwrap_or(Path::new(""));
    found.0.into_iter().map(|path| folder.join(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    #[test]
    fn embedded_files_are_found_and_too_many_bytes_reported() {
        let code = r#"pub const A: &[u8] = include_bytes!("../a.blob");
                      pub const B: [(&str, &str); 1] = [("b", include_str!("b.json"))];"#;
        let sources = fixture::sources(&[("lib.rs", code)]);
        let found = embedded(&sources[0]);
        assert_eq!(found, [PathBuf::from("/w/src/../a.blob"), PathBuf::from("/w/src/b.json")]);
        let check = of_sizes(vec![(1, "small".to_owned()), (8_000_000, "large".to_owned())]);
        assert!(!check.ok());
        assert_eq!(check.offenders[0], "large: 8000000 bytes");
    }
}
