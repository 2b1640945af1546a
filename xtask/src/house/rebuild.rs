//! Processor time of a release build after an edit of one file.

use crate::process::{Step, cargo};
use crate::report::{Check, Target};
use anyhow::{Context, Result, bail};
use std::path::Path;
use std::time::SystemTime;

/// Ticks of a second in `/proc/self/stat`: fixed by the kernel's interface.
const TICKS_PER_S: f64 = 100.0;

/// An edit whose cost is measured.
struct Edit {
    name: &'static str,
    file: &'static str,
    package: &'static str,
    most_s: f64,
}

const EDITS: [Edit; 2] = [
    Edit { name: "rebuild_core_cpu_s", file: "src/math.rs", package: "meniscus", most_s: 10.0 },
    Edit {
        name: "rebuild_cli_after_leaf_edit_cpu_s",
        file: "crates/meniscus-bags/src/lib.rs",
        package: "meniscus-cli",
        most_s: 60.0,
    },
];

/// Builds, touches and builds again.
pub(super) fn checks(root: &Path) -> Result<Vec<Check>> {
    EDITS.iter().map(|edit| cost(root, edit)).collect()
}

fn cost(root: &Path, edit: &Edit) -> Result<Check> {
    let cargo = cargo();
    let build = Step::new("build", [cargo.as_str(), "build", "--quiet", "--release", "-p", edit.package]);
    // What was not built yet would count as the cost of the edit.
    run(root, &build)?;
    let file = root.join(edit.file);
    let touched = std::fs::File::options().append(true).open(&file);
    touched
        .and_then(|open| open.set_modified(SystemTime::now()))
        .with_context(|| format!("{} cannot be touched", file.display()))?;
    let before = children_user_s()?;
    run(root, &build)?;
    Ok(of_cost(edit, children_user_s()? - before))
}

fn of_cost(edit: &Edit, cpu_s: f64) -> Check {
    let offenders = vec![format!("{}: an edit costs {cpu_s:.1} s of {}", edit.file, edit.package)];
    Check { name: edit.name, value: cpu_s, unit: "s (user)", target: Target::AtMost(edit.most_s), offenders }
}

fn run(root: &Path, build: &Step) -> Result<()> {
    let status =
        build.command(root)?.status().with_context(|| format!("`{}` did not start", build.line()))?;
    if !status.success() {
        bail!("`{}`: {status}", build.line());
    }
    Ok(())
}

/// User time of all descendants that have ended and were waited for, in seconds.
fn children_user_s() -> Result<f64> {
    let path = "/proc/self/stat";
    let stat =
        std::fs::read_to_string(path).with_context(|| format!("{path} is needed for processor times"))?;
    cutime_s(&stat).with_context(|| format!("{path} has an unknown form: {stat}"))
}

/// Field 16 (`cutime`) of proc_pid_stat(5); the name in field 2 may hold blanks and brackets.
fn cutime_s(stat: &str) -> Option<f64> {
    let after_name = stat.rsplit_once(')')?.1;
    let ticks: f64 = after_name.split_whitespace().nth(16 - 3)?.parse().ok()?;
    Some(ticks / TICKS_PER_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_of_children_is_read_and_grows() {
        let line = "12 (a name) x) S 1 12 12 0 -1 4194304 100 200 0 0 7 3 1234 55 20 0 1 0 99";
        assert_eq!(cutime_s(line), Some(12.34));
        assert_eq!(cutime_s("12 (name"), None);
        let before = children_user_s().unwrap();
        let busy = Step::new("busy", ["sh", "-c", "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done"]);
        run(Path::new("."), &busy).unwrap();
        assert!(children_user_s().unwrap() > before);
    }

    #[test]
    fn an_expensive_edit_is_reported() {
        let check = of_cost(&EDITS[0], 11.0);
        assert!(!check.ok());
        assert!(check.offenders[0].contains("src/math.rs"), "{:?}", check.offenders);
        assert!(run(Path::new("."), &Step::new("build", ["false"])).is_err());
    }
}
