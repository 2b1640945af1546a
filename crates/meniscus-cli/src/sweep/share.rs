//! Share of a task: which parts of a sweep it runs.

use anyhow::{Context, bail, ensure};

/// Place of a task among all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Share {
    /// Number of the task, from 0.
    index: usize,
    /// Number of tasks.
    tasks: usize,
}

impl Share {
    /// Whether the part of this number, from 0, is of this task.
    pub(super) fn has(self, part: usize) -> bool {
        part % self.tasks == self.index
    }
}

/// The share of `part`, `I/N`, or of the environment as `variable` gives it; all without either.
pub(super) fn of(
    part: Option<&str>,
    tasks: Option<usize>,
    variable: impl Fn(&str) -> Option<String>,
) -> anyhow::Result<Share> {
    if let Some(text) = part {
        return written(text);
    }
    let number = |name: &str| -> anyhow::Result<Option<usize>> {
        let Some(text) = variable(name) else { return Ok(None) };
        Ok(Some(text.trim().parse().with_context(|| format!("{name} is '{text}', which is no number"))?))
    };
    if let Some(id) = number("SLURM_ARRAY_TASK_ID")? {
        let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
        let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        let count = match tasks {
            Some(count) => count,
            None => number("SLURM_ARRAY_TASK_COUNT")?
                .context("Slurm does not say how many tasks the array has: give --parts N")?,
        };
        ensure!(
            id >= first && (id - first) % step == 0,
            "SLURM_ARRAY_TASK_ID = {id} is no place of an array from {first} in steps of {step}: give --part I/N"
        );
        return placed((id - first) / step, count);
    }
    if let Some(index) = number("JOB_COMPLETION_INDEX")? {
        return placed(index, tasks.context("an indexed job does not say how many it has: give --parts N")?);
    }
    if let Some(tasks) = tasks {
        bail!("--parts {tasks} goes with a job array, and this is none: give --part I/{tasks}");
    }
    Ok(Share { index: 0, tasks: 1 })
}

/// Reads `I/N`.
fn written(text: &str) -> anyhow::Result<Share> {
    let wrong = || format!("'{text}' is not I/N, as 3/8: task I, from 1, of N");
    let (index, tasks) = text.split_once('/').with_context(wrong)?;
    let number = |text: &str| text.trim().parse::<usize>().with_context(wrong);
    let (index, tasks) = (number(index)?, number(tasks)?);
    ensure!(index >= 1, "{}", wrong());
    placed(index - 1, tasks).with_context(wrong)
}

fn placed(index: usize, tasks: usize) -> anyhow::Result<Share> {
    ensure!(index < tasks, "task {} of {tasks} is not there", index + 1);
    Ok(Share { index, tasks })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn under(variables: &[(&str, &str)], part: Option<&str>, tasks: Option<usize>) -> anyhow::Result<Share> {
        let find =
            |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned());
        of(part, tasks, find)
    }

    #[test]
    fn every_part_has_one_task() {
        let shares: Vec<Share> = (0..3).map(|index| Share { index, tasks: 3 }).collect();
        for part in 0..20 {
            assert_eq!(shares.iter().filter(|share| share.has(part)).count(), 1, "{part}");
        }
    }

    #[test]
    fn the_place_comes_from_the_command_or_the_engine() {
        let share = |index, tasks| Share { index, tasks };
        assert_eq!(under(&[], None, None).expect("all"), share(0, 1));
        assert_eq!(under(&[], Some("3/8"), None).expect("written"), share(2, 8));
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "5"),
            ("SLURM_ARRAY_TASK_MIN", "1"),
            ("SLURM_ARRAY_TASK_STEP", "2"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
        ];
        assert_eq!(under(&slurm, None, None).expect("Slurm"), share(2, 4));
        // A command has the last word.
        assert_eq!(under(&slurm, Some("1/2"), None).expect("written"), share(0, 2));
        assert_eq!(under(&[("JOB_COMPLETION_INDEX", "7")], None, Some(8)).expect("Kubernetes"), share(7, 8));
    }

    #[test]
    fn wrong_places_are_named() {
        for wrong in ["0/8", "9/8", "3", "a/b", "/", "1/0"] {
            let fault = format!("{:#}", under(&[], Some(wrong), None).expect_err(wrong));
            assert!(fault.contains("I/N"), "{fault}");
        }
        let faults = [
            (under(&[("JOB_COMPLETION_INDEX", "0")], None, None), "--parts N"),
            (under(&[("SLURM_ARRAY_TASK_ID", "x")], None, None), "no number"),
            (under(&[("SLURM_ARRAY_TASK_ID", "2")], None, None), "--parts N"),
            (under(&[], None, Some(8)), "--part I/8"),
        ];
        for (outcome, word) in faults {
            let fault = format!("{:#}", outcome.expect_err(word));
            assert!(fault.contains(word), "{fault}");
        }
    }
}
