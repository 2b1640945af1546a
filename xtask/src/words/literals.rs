//! Strings inside of clap attributes: examples, value names and descriptions that are no doc comments.

use crate::workspace::{self, shown};
use anyhow::{Context, Result};
use proc_macro2::{TokenStream, TokenTree};
use std::path::Path;
use syn::visit::Visit;
use syn::{Attribute, Meta};

/// Attributes that clap reads.
const ATTRIBUTES: [&str; 4] = ["command", "arg", "value", "group"];

/// Folder of the command, from the root of the repository.
const FOLDER: &str = "crates/meniscus-cli/src/";

/// String of an attribute.
pub(super) struct Literal {
    /// `FILE:LINE`.
    pub(super) place: String,
    pub(super) text: String,
}

/// Reads the literals of the command.
pub(super) fn read(root: &Path) -> Result<Vec<Literal>> {
    let mut all = Vec::new();
    for path in workspace::files(root, ".rs")? {
        let name = shown(root, &path);
        if name.starts_with(FOLDER) {
            let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {name}"))?;
            all.extend(literals(&name, &text)?);
        }
    }
    Ok(all)
}

fn literals(path: &str, text: &str) -> Result<Vec<Literal>> {
    let file = syn::parse_file(text).with_context(|| format!("{path} is no Rust"))?;
    let mut found = Found { path, literals: Vec::new() };
    found.visit_file(&file);
    Ok(found.literals)
}

struct Found<'a> {
    path: &'a str,
    literals: Vec<Literal>,
}

impl Found<'_> {
    fn tokens(&mut self, tokens: TokenStream) {
        for token in tokens {
            match token {
                TokenTree::Group(group) => self.tokens(group.stream()),
                TokenTree::Literal(literal) => {
                    let place = format!("{}:{}", self.path, literal.span().start().line);
                    if let syn::Lit::Str(text) = syn::Lit::new(literal) {
                        self.literals.push(Literal { place, text: text.value() });
                    }
                }
                _ => {}
            }
        }
    }
}

impl<'ast> Visit<'ast> for Found<'_> {
    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let Meta::List(list) = &attribute.meta
            && ATTRIBUTES.iter().any(|name| list.path.is_ident(name))
        {
            self.tokens(list.tokens.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_of_clap_attributes_are_read_and_others_are_not() {
        let code = "#[derive(Args)]\n#[command(after_help = concat!(\"one\", \"two\"))]\n#[doc = \"no\"]\nstruct A {\n\
                    #[arg(long, default_value = \"three\", num_args = 1)]\nb: u8,\n}\nconst C: &str = \"no\";\n";
        let all = literals("a.rs", code).unwrap();
        let texts: Vec<&str> = all.iter().map(|literal| literal.text.as_str()).collect();
        assert_eq!(texts, ["one", "two", "three"]);
        assert_eq!(all[2].place, "a.rs:5");
        assert!(literals("a.rs", "struct").is_err());
    }
}
