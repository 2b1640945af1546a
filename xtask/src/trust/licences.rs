//! Licences and refused crates, by the rules of `deny.toml`.
//!
//! `cargo deny` takes minutes to install, so that it runs in nights alone. This is the part of it that a new dependency
//! breaks most easily: licences that are not allowed, crates that are refused, and sources other than the registry.

use crate::process;
use crate::report::Check;
use anyhow::{Context, Result};
use serde_json::Value;
use spdx::{Expression, ParseMode};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What `deny.toml` says.
#[derive(Debug, Default)]
struct Rules {
    /// Licences, with their exceptions: `Apache-2.0 WITH LLVM-exception`.
    allowed: BTreeSet<String>,
    /// Crates whose manifest does not say its licence.
    stated: BTreeMap<String, String>,
    /// Crates that are refused.
    refused: BTreeSet<String>,
    /// Registries.
    registries: BTreeSet<String>,
    /// Systems that are built.
    systems: Vec<String>,
}

/// Returns the number of dependencies that break a rule.
pub(super) fn check(root: &Path) -> Result<Check> {
    let text = std::fs::read_to_string(root.join("deny.toml")).context("deny.toml")?;
    let rules = Rules::read(&text)?;
    let cargo = process::cargo();
    let mut words = vec![cargo.as_str(), "metadata", "--locked", "--all-features", "--format-version", "1"];
    words.extend(rules.systems.iter().flat_map(|system| ["--filter-platform", system]));
    let metadata: Value = serde_json::from_str(&process::output(root, words)?)?;
    Ok(Check::count("licences_and_bans", "findings", 0.0, rules.broken(&metadata)))
}

impl Rules {
    fn read(text: &str) -> Result<Self> {
        let file: toml::Table = toml::from_str(text).context("deny.toml")?;
        let list = |section: &str, key: &str| -> Vec<toml::Value> {
            let value = file.get(section).and_then(|section| section.get(key));
            value.and_then(toml::Value::as_array).cloned().unwrap_or_default()
        };
        let words = |section: &str, key: &str| -> Vec<String> {
            list(section, key).iter().filter_map(|value| value.as_str().map(str::to_owned)).collect()
        };
        let field = |value: &toml::Value, key: &str| Some(value.get(key)?.as_str()?.to_owned());
        let clarified = list("licenses", "clarify");
        let rules = Self {
            allowed: words("licenses", "allow").into_iter().collect(),
            stated: clarified
                .iter()
                .filter_map(|value| Some((field(value, "crate")?, field(value, "expression")?)))
                .collect(),
            refused: list("bans", "deny").iter().filter_map(|value| field(value, "crate")).collect(),
            registries: words("sources", "allow-registry").into_iter().collect(),
            systems: words("graph", "targets"),
        };
        anyhow::ensure!(
            !rules.allowed.is_empty() && !rules.registries.is_empty() && !rules.systems.is_empty(),
            "deny.toml allows no licence or no registry, or names no system"
        );
        Ok(rules)
    }

    /// Returns what is broken, one line each.
    fn broken(&self, metadata: &Value) -> Vec<String> {
        let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let used: BTreeSet<String> = list(&metadata["resolve"]["nodes"])
            .iter()
            .filter_map(|node| node["id"].as_str().map(str::to_owned))
            .collect();
        let packages = list(&metadata["packages"]);
        let used =
            packages.iter().filter(|package| package["id"].as_str().is_some_and(|id| used.contains(id)));
        used.flat_map(|package| self.of_package(package)).collect()
    }

    fn of_package(&self, package: &Value) -> Vec<String> {
        let text = |key: &str| package[key].as_str().unwrap_or_default();
        let named = format!("{} {}", text("name"), text("version"));
        let mut out = Vec::new();
        if self.refused.contains(text("name")) {
            out.push(format!("{named}: refused by deny.toml"));
        }
        // A member of the workspace has no source.
        if let Some(source) = package["source"].as_str()
            && !self.registries.iter().any(|registry| source == format!("registry+{registry}"))
        {
            out.push(format!("{named}: comes from {source}"));
        }
        let licence = self.stated.get(text("name")).map_or(text("license"), String::as_str);
        match Expression::parse_mode(licence, ParseMode::LAX) {
            Err(_) => out.push(format!("{named}: no licence in its manifest, or '{licence}'")),
            Ok(expression) => {
                let allowed = |needed: &spdx::LicenseReq| self.allowed.contains(&needed.to_string());
                if !expression.evaluate(allowed) {
                    out.push(format!("{named}: {licence} is not allowed by deny.toml"));
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const RULES: &str = r#"
[graph]
targets = ["x86_64-unknown-linux-gnu"]
[licenses]
allow = ["MIT", "Apache-2.0 WITH LLVM-exception"]
[[licenses.clarify]]
crate = "unsaid"
expression = "MIT"
[bans]
deny = [{ crate = "openssl-sys", reason = "a system library" }]
[sources]
allow-registry = ["https://github.com/rust-lang/crates.io-index"]
"#;

    #[test]
    fn each_broken_rule_is_found_and_unused_packages_are_not() {
        let registry = "registry+https://github.com/rust-lang/crates.io-index";
        let package = |name: &str, licence: &str, source: &str| json!({"id": name, "name": name, "version": "1.0.0", "license": licence, "source": source});
        let packages = [
            package("free", "MIT OR GPL-3.0-only", registry),
            package("old-style", "MIT/Apache-2.0", registry),
            package("excepted", "Apache-2.0 WITH LLVM-exception", registry),
            package("both", "MIT AND ISC", registry),
            package("unsaid", "", registry),
            package("silent", "", registry),
            package("openssl-sys", "MIT", registry),
            package("elsewhere", "MIT", "git+https://example.org/x"),
            package("unused", "GPL-3.0-only", registry),
        ];
        let nodes: Vec<Value> = packages[..8].iter().map(|package| json!({"id": package["id"]})).collect();
        let metadata = json!({"packages": packages, "resolve": {"nodes": nodes}});
        let broken = Rules::read(RULES).unwrap().broken(&metadata);
        let of: Vec<&str> = broken.iter().filter_map(|line| line.split(' ').next()).collect();
        assert_eq!(of, ["both", "silent", "openssl-sys", "elsewhere"], "{broken:?}");
    }

    #[test]
    fn rules_that_allow_nothing_are_an_error() {
        assert!(Rules::read("[licenses]\nallow = []\n").is_err());
    }
}
