//! Share of the largest package in the repository's Rust lines.

use super::sources::Source;
use crate::report::{Check, Target};
use std::collections::BTreeMap;

/// Lines of the largest package over all lines; files outside the workspace count in the sum alone.
pub(super) fn check(all: &[Source]) -> Check {
    let mut lines: BTreeMap<&str, usize> = BTreeMap::new();
    let mut sum = 0;
    for source in all {
        let count = source.text.lines().count();
        sum += count;
        if let Some(package) = &source.package {
            *lines.entry(package).or_default() += count;
        }
    }
    let mut sorted: Vec<(&str, usize)> = lines.into_iter().collect();
    sorted.sort_by_key(|&(_, count)| std::cmp::Reverse(count));
    let share = |count: usize| count as f64 / sum.max(1) as f64;
    Check {
        name: "largest_crate_share",
        value: sorted.first().map_or(0.0, |&(_, count)| share(count)),
        unit: "",
        target: Target::AtMost(0.22),
        offenders: sorted.iter().take(3).map(|&(name, n)| format!("{name}: {n} of {sum} lines")).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::sources::parse;
    use super::*;

    #[test]
    fn a_crate_that_is_too_large_is_named() {
        let source = |package: Option<&str>, lines: usize| {
            parse("x.rs".into(), package.map(str::to_owned), "// line\n".repeat(lines)).unwrap()
        };
        let all = [source(Some("large"), 60), source(Some("small"), 20), source(None, 20)];
        let check = check(&all);
        assert_eq!(check.value, 0.6);
        assert!(!check.ok());
        assert_eq!(check.offenders[0], "large: 60 of 100 lines");
    }
}
