//! Promises, read from the attack tests: the first line of a test's documentation, and how it is attacked behind it.

use anyhow::{Context, Result, ensure};
use std::path::Path;
use syn::{Attribute, Expr, Item, Lit, Meta};

/// Folder of the tests.
const FOLDER: &str = "tests/attacks";

/// One promise and the test that attacks it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Promise {
    /// File of the test, without its ending.
    pub(super) class: String,
    /// Function of the test.
    pub(super) name: String,
    /// The promise.
    pub(super) promise: String,
    /// Attack on it.
    pub(super) attack: String,
}

impl Promise {
    /// Name of the test as the test runner prints it.
    pub(super) fn test(&self) -> String {
        format!("{}::{}", self.class, self.name)
    }
}

/// Returns the promises of all attack tests, by class.
pub(super) fn read(root: &Path) -> Result<Vec<Promise>> {
    let mut files: Vec<_> = std::fs::read_dir(root.join(FOLDER))?.flatten().map(|file| file.path()).collect();
    files.sort();
    let mut promises = Vec::new();
    for path in files.iter().filter(|path| path.extension().is_some_and(|ending| ending == "rs")) {
        let class = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let text = std::fs::read_to_string(path)?;
        promises.extend(of_file(&class, &text).with_context(|| path.display().to_string())?);
    }
    Ok(promises)
}

/// Returns the promises of one file.
fn of_file(class: &str, text: &str) -> Result<Vec<Promise>> {
    let mut promises = Vec::new();
    for item in syn::parse_file(text)?.items {
        let Item::Fn(function) = item else { continue };
        if !function.attrs.iter().any(|attribute| attribute.path().is_ident("test")) {
            continue;
        }
        let name = function.sig.ident.to_string();
        let doc: Vec<String> = function.attrs.iter().filter_map(line).collect();
        let (promise, attack) = (doc.first().cloned().unwrap_or_default(), doc.get(1..).unwrap_or_default());
        let attack = attack.join(" ").trim().to_owned();
        ensure!(
            !promise.is_empty() && !attack.is_empty(),
            "{name} documents no promise, or not how it is attacked"
        );
        promises.push(Promise { class: class.into(), name, promise, attack });
    }
    Ok(promises)
}

/// Returns the text of a line of documentation.
fn line(attribute: &Attribute) -> Option<String> {
    let Meta::NameValue(pair) = &attribute.meta else { return None };
    let Expr::Lit(literal) = &pair.value else { return None };
    let Lit::Str(text) = &literal.lit else { return None };
    pair.path.is_ident("doc").then(|| text.value().trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_test_gives_its_promise_and_its_attack() {
        let text =
            "/// Nobody gets in.\n///\n/// A knock\n/// at night.\n#[test]\nfn knock() {}\nfn helper() {}\n";
        let found = of_file("servers", text).expect("parsed");
        assert_eq!(found.len(), 1);
        assert_eq!(
            (found[0].test().as_str(), found[0].promise.as_str()),
            ("servers::knock", "Nobody gets in.")
        );
        assert_eq!(found[0].attack, "A knock at night.");
        assert!(of_file("servers", "#[test]\nfn silent() {}\n").is_err());
    }
}
