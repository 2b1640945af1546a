//! Public entry points of the core: every `pub fn`, and every `pub struct` or `pub enum` with a constructor, that a
//! public module declares or re-exports (`meniscus::MODULE::NAME`, the module at any depth).
//!
//! A constructor is a `pub fn` without `self` that returns `Self` or the type, alone or inside another type.

use super::imports::{Definition, Module, Resolver, leaves};
use super::sources::{Source, Tree, is_test};
use std::collections::BTreeSet;
use syn::{Attribute, FnArg, ImplItem, ImplItemFn, Item, ReturnType, Type, Visibility};

/// An entry point with the doc comments in which an example may stand: its own and those of its public methods.
pub(super) struct EntryPoint<'a> {
    pub(super) source: &'a Source,
    pub(super) span: proc_macro2::Span,
    pub(super) name: String,
    pub(super) docs: Vec<&'a [Attribute]>,
}

/// The entry points of a library.
pub(super) fn of<'a>(tree: &Tree<'a>) -> Vec<EntryPoint<'a>> {
    let resolver = Resolver::new(tree);
    let mut exported = BTreeSet::new();
    collect(tree, &resolver, &Vec::new(), &mut exported);
    exported.iter().filter_map(|definition| entry_point(tree, definition)).collect()
}

/// Collects what a public module exports, and what the public modules below it do.
fn collect(tree: &Tree<'_>, resolver: &Resolver<'_>, module: &Module, exported: &mut BTreeSet<Definition>) {
    let Some(source) = tree.modules.get(module) else { return };
    let joined = |names: &[String]| module.iter().chain(names).cloned().collect::<Vec<_>>();
    for item in &source.syntax.items {
        let (visibility, names) = match item {
            Item::Fn(it) => (&it.vis, vec![vec![it.sig.ident.to_string()]]),
            Item::Struct(it) => (&it.vis, vec![vec![it.ident.to_string()]]),
            Item::Enum(it) => (&it.vis, vec![vec![it.ident.to_string()]]),
            // Not the path behind it: the alias is followed by the resolver.
            Item::Use(it) => {
                (&it.vis, leaves(&it.tree).into_iter().filter_map(|l| Some(vec![l.name?])).collect())
            }
            Item::Mod(it) if matches!(it.vis, Visibility::Public(_)) && !is_test(&it.attrs) => {
                collect(tree, resolver, &joined(&[it.ident.to_string()]), exported);
                continue;
            }
            _ => continue,
        };
        if matches!(visibility, Visibility::Public(_)) {
            exported.extend(names.iter().filter_map(|name| resolver.definition(&joined(name))));
        }
    }
}

fn entry_point<'a>(tree: &Tree<'a>, definition: &Definition) -> Option<EntryPoint<'a>> {
    let source: &'a Source = tree.modules.get(&definition.module).copied()?;
    let name = definition.item.as_ref()?;
    let of = |ident: &syn::Ident| ident == name;
    source.syntax.items.iter().find_map(|item| {
        let (ident, attributes, is_type) = match item {
            Item::Fn(it) if of(&it.sig.ident) => (&it.sig.ident, &it.attrs, false),
            Item::Struct(it) if of(&it.ident) => (&it.ident, &it.attrs, true),
            Item::Enum(it) if of(&it.ident) => (&it.ident, &it.attrs, true),
            _ => return None,
        };
        let mut docs = vec![attributes.as_slice()];
        if is_type {
            let methods = methods(tree, &definition.module, name);
            methods.iter().find(|method| constructs(method, name))?;
            docs.extend(methods.iter().map(|method| method.attrs.as_slice()));
        }
        Some(EntryPoint { source, span: ident.span(), name: path(&definition.module, name), docs })
    })
}

fn path(module: &Module, name: &str) -> String {
    module.iter().map(String::as_str).chain([name]).collect::<Vec<_>>().join("::")
}

/// Public methods of a type, in its own file and in those of its folder.
fn methods<'a>(tree: &Tree<'a>, module: &Module, name: &str) -> Vec<&'a ImplItemFn> {
    let folder = module.split_last().map_or(&[][..], |(_, folder)| folder);
    let files = tree.modules.iter().filter(|(other, _)| *other == module || other.starts_with(folder));
    let items = files.flat_map(|(_, source)| &source.syntax.items);
    let own = items.filter_map(|item| match item {
        Item::Impl(it) if it.trait_.is_none() && is_named(&it.self_ty, name) => Some(&it.items),
        _ => None,
    });
    let public = own.flatten().filter_map(|item| match item {
        ImplItem::Fn(it) if matches!(it.vis, Visibility::Public(_)) => Some(it),
        _ => None,
    });
    public.collect()
}

fn is_named(kind: &Type, name: &str) -> bool {
    matches!(kind, Type::Path(it) if it.path.segments.last().is_some_and(|last| last.ident == name))
}

/// Whether a method makes a value of the type from nothing of the type.
fn constructs(method: &ImplItemFn, name: &str) -> bool {
    struct Mentions<'a>(&'a str, bool);
    impl<'ast> syn::visit::Visit<'ast> for Mentions<'_> {
        fn visit_ident(&mut self, ident: &'ast syn::Ident) {
            self.1 |= ident == self.0 || ident == "Self";
        }
    }
    let ReturnType::Type(_, result) = &method.sig.output else { return false };
    let mut mentions = Mentions(name, false);
    syn::visit::visit_type(&mut mentions, result);
    mentions.1 && !method.sig.inputs.iter().any(|input| matches!(input, FnArg::Receiver(_)))
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    #[test]
    fn what_a_public_module_exports_is_an_entry_point() {
        let sources = fixture::sources(&[
            ("lib.rs", "pub mod a; mod hidden;"),
            ("a/mod.rs", "mod file; pub use file::{Made, Plain, act as perform}; pub mod deep;"),
            (
                "a/file.rs",
                "pub struct Made(u8); impl Made { pub fn new() -> Option<Self> { None } pub fn get(&self) {} }
                 pub struct Plain { pub x: u8 } impl Plain { pub fn twice(&self) -> Self { Self { x: 2 * self.x } } }
                 pub fn act() {} pub fn unexported() {}",
            ),
            ("a/deep.rs", "pub fn below() {} fn private() {} #[cfg(test)] mod tests { pub fn t() {} }"),
            ("hidden.rs", "pub fn no() {}"),
        ]);
        let tree = fixture::tree(&sources);
        let names: Vec<String> = of(&tree).into_iter().map(|entry| entry.name).collect();
        assert_eq!(names, ["a::deep::below", "a::file::Made", "a::file::act"]);
    }
}
