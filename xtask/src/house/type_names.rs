//! Public types of one crate that share a name.

use super::sources::{Source, Tree, is_test, place};
use crate::report::Check;
use std::collections::BTreeMap;
use std::path::Path;
use syn::{Item, Visibility};

/// Names that more than one public type of a library or program has. `pub` counts, `pub(crate)` does not.
pub(super) fn check(root: &Path, trees: &[Tree<'_>]) -> Check {
    let offenders = trees.iter().flat_map(|tree| duplicates(root, tree)).collect();
    Check::count("duplicate_public_type_names_in_a_crate", "", 0.0, offenders)
}

fn duplicates(root: &Path, tree: &Tree<'_>) -> Vec<String> {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for source in tree.modules.values() {
        collect(root, source, &source.syntax.items, &mut places);
    }
    let shared = places.into_iter().filter(|(_, places)| places.len() > 1);
    shared.map(|(name, places)| format!("{}: `{name}`: {}", tree.package, places.join(", "))).collect()
}

fn collect(root: &Path, source: &Source, items: &[Item], places: &mut BTreeMap<String, Vec<String>>) {
    for item in items {
        let (visibility, name, attributes) = match item {
            Item::Struct(it) => (&it.vis, &it.ident, &it.attrs),
            Item::Enum(it) => (&it.vis, &it.ident, &it.attrs),
            Item::Union(it) => (&it.vis, &it.ident, &it.attrs),
            Item::Trait(it) => (&it.vis, &it.ident, &it.attrs),
            Item::Type(it) => (&it.vis, &it.ident, &it.attrs),
            Item::Mod(it) => {
                if let (Some((_, inner)), false) = (&it.content, is_test(&it.attrs)) {
                    collect(root, source, inner, places);
                }
                continue;
            }
            _ => continue,
        };
        if matches!(visibility, Visibility::Public(_)) && !is_test(attributes) {
            places.entry(name.to_string()).or_default().push(place(root, source, name.span()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::sources::fixture;
    use super::*;

    #[test]
    fn one_name_for_two_public_types_is_reported() {
        let sources = fixture::sources(&[
            ("a.rs", "pub struct State;\npub(crate) struct Hidden;\n"),
            ("b.rs", "\npub enum State {}\nstruct Hidden;\n#[cfg(test)] mod tests { pub struct State; }\n"),
        ]);
        let check = check(Path::new("/w"), &[fixture::tree(&sources)]);
        assert_eq!(check.offenders, ["sample: `State`: src/a.rs:1, src/b.rs:2"]);
        assert!(!check.ok());
    }
}
