//! State of checkout and machine, for the log.

use crate::process;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// State of the checkout when a step begins.
pub(super) struct State {
    /// Root of the checkout.
    pub(super) root: PathBuf,
    /// Date and time, UTC.
    pub(super) date: String,
    /// Commit, its subject, and whether files differ from it.
    pub(super) commit: String,
}

impl State {
    /// Returns the state now.
    pub(super) fn now(root: &Path) -> Result<Self> {
        let commit = process::output(root, ["git", "log", "-1", "--format=%H %s"])?;
        let changed = process::output(root, ["git", "status", "--porcelain", "--", ".", ":!docs/nightly"])?;
        let tree = if changed.trim().is_empty() { "clean" } else { "with uncommitted changes" };
        let date = process::output(root, ["date", "-u", "+%FT%TZ"])?.trim().to_owned();
        Ok(Self { root: root.to_owned(), date, commit: format!("{} ({tree})", commit.trim()) })
    }

    /// Day of the state, as `2026-01-02`.
    pub(super) fn day(&self) -> &str {
        self.date.split('T').next().unwrap_or_default()
    }
}

/// Returns the head of a log: the processor.
pub(super) fn head() -> String {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processors = std::thread::available_parallelism().map_or(1, Into::into);
    format!("cpu     {}, {processors} processors\n", cpu_model(&cpu))
}

/// Processor's name in `/proc/cpuinfo`; on ARM there is a part number at most.
fn cpu_model(cpuinfo: &str) -> String {
    let field = |name: &str| {
        let line = cpuinfo.lines().find(|line| line.starts_with(name))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    field("model name")
        .or_else(|| Some(format!("CPU part {}", field("CPU part")?)))
        .unwrap_or_else(|| format!("unknown, {}", std::env::consts::ARCH))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_have_a_name() {
        assert_eq!(cpu_model("processor : 0\nmodel name\t: Some CPU @ 3 GHz\n"), "Some CPU @ 3 GHz");
        assert_eq!(cpu_model("processor : 0\nCPU part : 0xd08\n"), "CPU part 0xd08");
    }

    #[test]
    fn a_state_has_its_day() {
        let state = State { root: "/w".into(), date: "2026-01-02T03:04:05Z".into(), commit: String::new() };
        assert_eq!(state.day(), "2026-01-02");
    }
}
