//! Licences and refused crates, by the rules of `deny.toml`.
//!
//! `cargo deny` takes minutes to install, so that it runs in nights alone. This is the part of it that a new dependency
//! breaks most easily: licences that are not allowed, crates that are refused, and sources other than the registry.

use crate::process;
use crate::report::Check;
use anyhow::{Context, Result};
use spdx::{Expression, ParseMode};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Rules of `deny.toml`.
#[derive(Debug, Default)]
struct Rules {
    /// Licences, with their exceptions: `Apache-2.0 WITH LLVM-exception`.
    allowed: BTreeSet<String>,
    /// Crates whose manifest does not say its licence.
    stated: BTreeMap<String, String>,
    /// Crates that are refused.
    refused: BTreeSet<String>,
    /// Systems that are built.
    systems: Vec<String>,
}

/// Returns the number of dependencies that break a rule.
pub(super) fn check(root: &Path) -> Result<Check> {
    let text = std::fs::read_to_string(root.join("deny.toml")).context("deny.toml")?;
    let rules = Rules::read(&text)?;
    let cargo = process::cargo();
    let mut packages = BTreeSet::new();
    for system in &rules.systems {
        // Unlike the graph of `cargo metadata`, the tree leaves out what no feature switches on.
        let words =
            ["tree", "--workspace", "--all-features", "--locked", "--prefix", "none", "--format", "{p}|{l}"];
        let listed =
            process::output(root, [cargo.as_str()].into_iter().chain(words).chain(["--target", system]))?;
        // Empty lines stand between the members, and `(*)` behind what is listed before.
        let lines = listed.lines().filter(|line| !line.is_empty());
        packages.extend(lines.map(|line| line.trim_end_matches(" (*)").to_owned()));
    }
    let broken = packages.iter().flat_map(|line| rules.of_package(line)).collect();
    Ok(Check::count("licences_and_bans", "findings", 0.0, broken))
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
            systems: words("graph", "targets"),
        };
        anyhow::ensure!(
            !rules.allowed.is_empty() && !rules.systems.is_empty(),
            "deny.toml allows no licence, or names no system"
        );
        Ok(rules)
    }

    /// Returns what is broken by a package of `cargo tree`, one line each: `NAME vVERSION (FOLDER or ADDRESS)|LICENCE`, without
    /// parentheses for those of the registry.
    fn of_package(&self, line: &str) -> Vec<String> {
        let (package, licence) = line.split_once('|').unwrap_or((line, ""));
        let name = package.split(' ').next().unwrap_or_default();
        let mut out = Vec::new();
        if self.refused.contains(name) {
            out.push(format!("{package}: refused by deny.toml"));
        }
        if package.contains("://") {
            out.push(format!("{package}: not from the registry"));
        }
        let licence = self.stated.get(name).map_or(licence, String::as_str);
        match Expression::parse_mode(licence, ParseMode::LAX) {
            Err(_) => out.push(format!("{package}: no licence in its manifest, or '{licence}'")),
            Ok(expression) => {
                let allowed = |needed: &spdx::LicenseReq| self.allowed.contains(&needed.to_string());
                if !expression.evaluate(allowed) {
                    out.push(format!("{package}: {licence} is not allowed by deny.toml"));
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
"#;

    #[test]
    fn each_broken_rule_is_found() {
        let lines = [
            "free v1.0.0|MIT OR GPL-3.0-only",
            "old-style v1.0.0 (proc-macro)|MIT/Apache-2.0",
            "excepted v1.0.0|Apache-2.0 WITH LLVM-exception",
            "member v0.1.0 (/home/somebody/member)|MIT",
            "unsaid v1.0.0|",
            "both v1.0.0|MIT AND ISC",
            "silent v1.0.0|",
            "openssl-sys v1.0.0|MIT",
            "elsewhere v1.0.0 (https://example.org/x#1234)|MIT",
        ];
        let rules = Rules::read(RULES).unwrap();
        let broken: Vec<String> = lines.iter().flat_map(|line| rules.of_package(line)).collect();
        let of: Vec<&str> = broken.iter().filter_map(|line| line.split(' ').next()).collect();
        assert_eq!(of, ["both", "silent", "openssl-sys", "elsewhere"], "{broken:?}");
    }

    #[test]
    fn rules_that_allow_nothing_are_an_error() {
        assert!(Rules::read("[licenses]\nallow = []\n").is_err());
    }
}
