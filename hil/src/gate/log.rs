//! A guest's log: its lines, the facts in them, and how two logs differ.

use super::Failure;
use serde_json::Value;
use std::path::Path;

/// Prefix of the guest's lines of facts.
const MARK: &str = "HIL ";

/// One boot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Log {
    /// The lines of facts, as they were printed.
    pub(crate) lines: Vec<String>,
    /// Plan and facts of each scenario, in order.
    pub(crate) facts: Vec<(String, Value)>,
    /// Wall time of each, seconds.
    pub(crate) wall_s: Vec<f64>,
}

impl Log {
    /// Reads a log and the wall times beside it.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut log = Self::default();
        for line in text.lines().filter_map(|line| line.find(MARK).map(|at| &line[at..])) {
            let mut object: Value = serde_json::from_str(&line[MARK.len()..]).map_err(|error| {
                format!("{}: a line of facts is damaged ({error}): {line}", path.display())
            })?;
            let plan = object["scenario"].as_str().unwrap_or_default().to_owned();
            log.facts.push((plan, object["facts"].take()));
            log.lines.push(line.to_owned());
        }
        let times = std::fs::read_to_string(path.with_extension("times")).unwrap_or_default();
        log.wall_s = times.lines().filter_map(|line| line.parse().ok()).collect();
        Ok(log)
    }

    /// Facts of a plan.
    pub(crate) fn of(&self, plan: &str) -> Option<&Value> {
        self.facts.iter().find(|(known, _)| known == plan).map(|(_, facts)| facts)
    }
}

/// Returns the lines to remove from and to add to `old` to get `new`, by the longest common subsequence.
pub(crate) fn difference<'t>(old: &[&'t str], new: &[&'t str]) -> Vec<String> {
    let (n, m) = (old.len(), new.len());
    let mut common = vec![vec![0_u32; m + 1]; n + 1];
    for i in (0..n).rev() {
        for j in (0..m).rev() {
            common[i][j] = if old[i] == new[j] {
                common[i + 1][j + 1] + 1
            } else {
                common[i + 1][j].max(common[i][j + 1])
            };
        }
    }
    let (mut i, mut j, mut lines) = (0, 0, Vec::new());
    while i < n || j < m {
        if i < n && j < m && old[i] == new[j] {
            (i, j) = (i + 1, j + 1);
        } else if i < n && (j == m || common[i + 1][j] >= common[i][j + 1]) {
            lines.push(format!("-{}", old[i]));
            i += 1;
        } else {
            lines.push(format!("+{}", new[j]));
            j += 1;
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_shows_what_went_and_what_came() {
        assert_eq!(difference(&["a", "b", "c"], &["a", "x", "c", "d"]), ["-b", "+x", "+d"]);
        assert!(difference(&["a"], &["a"]).is_empty());
    }

    #[test]
    fn facts_are_found_among_the_kernels_lines() {
        let path = std::env::temp_dir().join(format!("meniscus-log-{}.log", std::process::id()));
        std::fs::write(&path, "[ 0.1] usb\nHIL {\"scenario\":\"run\",\"facts\":{\"exit\":0}}\n")
            .expect("written");
        let log = Log::read(&path).expect("read");
        assert_eq!(log.of("run").map(|facts| facts["exit"].clone()), Some(0.into()));
        assert!(log.of("other").is_none());
        std::fs::write(&path, "HIL {\"scenario\"").expect("written");
        assert!(Log::read(&path).is_err(), "a line that was cut");
        std::fs::remove_file(&path).expect("removed");
    }
}
