//! The command `meniscus` as clap defines it: verbs, flags and help texts at 80 columns.
//!
//! The definition comes from the program `meniscus-help-texts` (`tests/support/help_texts.rs`). xtask does not link the
//! command itself: an edit of any crate would rebuild it before each `cargo xtask quick`.

use crate::{built, process};
use anyhow::{Context, Result};
use serde_json::Value;
use std::path::Path;

/// A verb, or the program itself.
#[derive(Clone, Debug, Default)]
pub(super) struct Verb {
    /// Name and aliases.
    pub(super) names: Vec<String>,
    /// Flags with their dashes.
    pub(super) flags: Vec<String>,
    /// Long help text, 80 columns wide.
    pub(super) help: String,
    pub(super) verbs: Vec<Verb>,
}

impl Verb {
    /// The verb of a name below this one.
    pub(super) fn below(&self, name: &str) -> Option<&Self> {
        self.verbs.iter().find(|verb| verb.names.iter().any(|own| own == name))
    }
}

/// Builds the program of the definition in a profile of cargo and reads its output.
pub(super) fn read(root: &Path, profile: &str) -> Result<Verb> {
    let program = built::program(root, profile, "meniscus-help-texts")?;
    let text = process::output(root, [program.to_string_lossy().as_ref()])?;
    let value: Value = serde_json::from_str(&text).context("meniscus-help-texts printed no JSON")?;
    verb(&value)
}

fn verb(value: &Value) -> Result<Verb> {
    let name = value["name"].as_str().context("a verb without name")?;
    let help = value["help"].as_str().with_context(|| format!("{name}: no help text"))?;
    let strings = |key: &str| {
        let list = value[key].as_array().with_context(|| format!("{name}: no `{key}`"))?;
        Ok::<_, anyhow::Error>(list.iter().filter_map(Value::as_str).map(str::to_owned).collect::<Vec<_>>())
    };
    let below = value["verbs"].as_array().with_context(|| format!("{name}: no `verbs`"))?;
    Ok(Verb {
        names: std::iter::once(name.to_owned()).chain(strings("aliases")?).collect(),
        flags: strings("flags")?,
        help: help.to_owned(),
        verbs: below.iter().map(verb).collect::<Result<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_definition_is_read_with_its_aliases() {
        let inner = json!({"name": "insert", "aliases": ["adopt"], "flags": ["--effect"], "help": "Insert.", "verbs": []});
        let value =
            json!({"name": "meniscus", "aliases": [], "flags": [], "help": "Help.", "verbs": [inner]});
        let program = verb(&value).unwrap();
        assert_eq!(program.below("adopt").unwrap().flags, ["--effect"]);
        assert!(program.below("inserts").is_none());
    }

    #[test]
    fn an_incomplete_definition_is_an_error() {
        let error = verb(&json!({"name": "run", "help": "", "aliases": []})).unwrap_err().to_string();
        assert_eq!(error, "run: no `verbs`");
    }
}
