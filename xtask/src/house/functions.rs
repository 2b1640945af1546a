//! Long functions, and tuple patterns that hide how many parameters a function has.

use super::sources::Source;
use crate::report::{Check, Target};
use crate::workspace;
use crate::workspace::shown;
use std::path::Path;
use syn::visit::{self, Visit};
use syn::{Block, FnArg, Pat, Signature};

/// Lines of code that the body of a function may have, as `clippy::too_many_lines` counts them.
const MOST_LINES: usize = 80;

/// Tuple parameters and long functions of all files, tests included.
pub(super) fn checks(all: &[Source]) -> [Check; 2] {
    let root = workspace::root().unwrap_or_default();
    let lines: usize = all.iter().map(|source| source.text.lines().count()).sum();
    let mut tuples = Vec::new();
    let mut long = Vec::new();
    for source in all {
        let mut found = Found { root: &root, source, tuples: &mut tuples, long: &mut long };
        found.visit_file(&source.syntax);
    }
    let per_10k = tuples.len() as f64 * 1e4 / lines.max(1) as f64;
    [
        Check {
            name: "tuple_parameters_per_10k",
            value: per_10k,
            unit: "per 10,000 lines",
            target: Target::AtMost(1.0),
            offenders: tuples,
        },
        Check::count("functions_over_80_lines", "", 0.0, long),
    ]
}

struct Found<'a> {
    root: &'a Path,
    source: &'a Source,
    tuples: &'a mut Vec<String>,
    long: &'a mut Vec<String>,
}

impl Found<'_> {
    fn function(&mut self, signature: &Signature, body: Option<&Block>) {
        let at = format!("{}:{}", shown(self.root, &self.source.path), signature.ident.span().start().line);
        let typed = signature.inputs.iter().filter_map(|input| match input {
            FnArg::Typed(typed) => Some(&*typed.pat),
            FnArg::Receiver(_) => None,
        });
        self.tuples.extend(typed.filter(|pat| is_tuple(pat)).map(|_| format!("{at}: {}", signature.ident)));
        let lines = body.map_or(0, |body| code_lines(&self.source.text, body));
        if lines > MOST_LINES {
            self.long.push(format!("{at}: {} has {lines} lines", signature.ident));
        }
    }
}

impl<'ast> Visit<'ast> for Found<'_> {
    fn visit_item_fn(&mut self, it: &'ast syn::ItemFn) {
        self.function(&it.sig, Some(&it.block));
        visit::visit_item_fn(self, it);
    }

    fn visit_impl_item_fn(&mut self, it: &'ast syn::ImplItemFn) {
        self.function(&it.sig, Some(&it.block));
        visit::visit_impl_item_fn(self, it);
    }

    fn visit_trait_item_fn(&mut self, it: &'ast syn::TraitItemFn) {
        self.function(&it.sig, it.default.as_ref());
        visit::visit_trait_item_fn(self, it);
    }
}

/// Whether a pattern takes a tuple apart, behind references and brackets, too.
fn is_tuple(pattern: &Pat) -> bool {
    match pattern {
        Pat::Tuple(_) => true,
        Pat::Reference(inner) => is_tuple(&inner.pat),
        Pat::Paren(inner) => is_tuple(&inner.pat),
        _ => false,
    }
}

/// Lines between the braces of a body that hold more than blanks and comments.
fn code_lines(text: &str, body: &Block) -> usize {
    let (open, close) = (body.brace_token.span.open().end(), body.brace_token.span.close().start());
    let mut in_comment = false;
    let mut count = 0;
    for (number, line) in (1..).zip(text.lines()).skip(open.line - 1).take(close.line + 1 - open.line) {
        // Columns of proc-macro2 count characters.
        let begin = if number == open.line { open.column } else { 0 };
        let end = if number == close.line { close.column } else { usize::MAX };
        let part: String = line.chars().take(end).skip(begin).collect();
        count += usize::from(has_code(&part, &mut in_comment));
    }
    count
}

/// Whether a line holds code outside comments; `in_comment` is the state of a block comment from line to line. Comment
/// marks inside of strings are taken for comments, as Clippy takes them.
fn has_code(line: &str, in_comment: &mut bool) -> bool {
    let mut rest = line.trim_start();
    let mut code = false;
    loop {
        if *in_comment {
            let Some(end) = rest.find("*/") else { return code };
            *in_comment = false;
            rest = rest[end + 2..].trim_start();
        }
        if rest.is_empty() {
            return code;
        }
        let (line_mark, block_mark) = (rest.find("//"), rest.find("/*"));
        match (line_mark, block_mark) {
            (Some(at), block) if block.is_none_or(|block| at < block) => return code || at > 0,
            (_, Some(at)) => {
                code |= at > 0;
                *in_comment = true;
                rest = &rest[at + 2..];
            }
            _ => return true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    fn function(lines: usize) -> String {
        let body =
            "    let _ = 1; // why\n\n    // only a comment\n    /* and\n    another */\n".repeat(lines);
        format!("fn long() {{\n{body}}}\n")
    }

    #[test]
    fn a_function_over_80_lines_is_reported_and_one_of_80_is_not() {
        let sources = fixture::sources(&[("a.rs", &function(80)), ("b.rs", &function(81))]);
        let [_, long] = checks(&sources);
        assert_eq!(long.value, 1.0, "{:?}", long.offenders);
        assert!(long.offenders[0].ends_with("src/b.rs:1: long has 81 lines"), "{:?}", long.offenders);
    }

    #[test]
    fn tuple_parameters_are_reported_in_functions_methods_and_traits() {
        let code = "fn one((a, b): (u8, u8)) {}\n\
                    struct S;\n\
                    impl S { fn two(&self, &(a, b): &(u8, u8), c: u8) {} fn fine(&self, c: (u8, u8)) {} }\n\
                    trait T { fn three((a, b): (u8, u8)) {} }\n\
                    fn closures() { let _ = |(a, b): (u8, u8)| a + b; }\n";
        let sources = fixture::sources(&[("a.rs", code)]);
        let [tuples, _] = checks(&sources);
        assert_eq!(tuples.offenders.len(), 3, "{:?}", tuples.offenders);
        assert!(!tuples.ok());
        assert!(tuples.offenders[1].ends_with("src/a.rs:3: two"));
    }

    #[test]
    fn comments_are_distinguished_from_code() {
        let mut inside = false;
        assert!(!has_code("  // x", &mut inside));
        assert!(has_code("x(); /* begins", &mut inside));
        assert!(inside);
        assert!(!has_code("still", &mut inside));
        assert!(has_code("ends */ y();", &mut inside));
        assert!(!inside);
        assert!(has_code("\"http://a\"", &mut inside));
    }
}
