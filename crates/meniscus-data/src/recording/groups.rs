//! Names of the field groups in files.

use super::GROUP_NAMES;
use meniscus::blob::{FieldGroup, KnownGroups};

/// Returns the name of each group, in the order of [`FieldGroup::ALL`].
fn named() -> impl Iterator<Item = (FieldGroup, &'static str)> {
    FieldGroup::ALL.into_iter().zip(GROUP_NAMES.into_iter().chain(["surface"]))
}

/// Returns the names of `known` in files and reports: `q`, `v`, `e`, `sigma`, `tau`, `surface`.
#[must_use]
pub fn names(known: KnownGroups) -> Vec<&'static str> {
    named().filter(|(group, _)| known.contains(*group)).map(|(_, name)| name).collect()
}

/// Returns the groups of a JSON list of names.
pub(super) fn groups(list: &str) -> Result<KnownGroups, String> {
    let list: Vec<String> = serde_json::from_str(list).map_err(|e| format!("known: {e}"))?;
    list.iter().try_fold(KnownGroups::NONE, |known, name| {
        let found = named().find(|(_, group)| group == name);
        found.map(|(group, _)| known.with(group)).ok_or_else(|| format!("known: no group is called '{name}'"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_give_the_same_groups() {
        let known = KnownGroups::NONE.with(FieldGroup::Position).with(FieldGroup::Surface);
        assert_eq!(names(known), ["q", "surface"]);
        assert_eq!(groups(r#"["q", "surface"]"#), Ok(known));
        assert_eq!(groups(r#"["x"]"#), Err("known: no group is called 'x'".into()));
        assert_eq!(names(KnownGroups::ALL).len(), 6);
    }
}
