//! Child processes: steps with a name and a time, and commands whose output is read.

use anyhow::{Context, Result, bail};
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

/// A command with a name.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// Name by which a person selects it.
    pub(crate) name: String,
    /// Program and arguments.
    pub(crate) words: Vec<String>,
    /// Environment variables that are set for it.
    pub(crate) environment: Vec<(String, String)>,
}

impl Step {
    /// Step `name` that runs `words`.
    pub(crate) fn new<W: Into<String>>(name: &str, words: impl IntoIterator<Item = W>) -> Self {
        let words = words.into_iter().map(Into::into).collect();
        Self { name: name.to_owned(), words, environment: Vec::new() }
    }

    /// The same step with an environment variable.
    pub(crate) fn with(mut self, variable: &str, value: &str) -> Self {
        self.environment.push((variable.to_owned(), value.to_owned()));
        self
    }

    /// The command as a person would type it.
    pub(crate) fn line(&self) -> String {
        let set = self.environment.iter().map(|(variable, value)| format!("{variable}={value}"));
        set.chain(self.words.iter().cloned()).collect::<Vec<_>>().join(" ")
    }

    /// The command, to be run in `folder`.
    pub(crate) fn command(&self, folder: &Path) -> Result<Command> {
        let Some((program, arguments)) = self.words.split_first() else {
            bail!("step `{}` has no command", self.name);
        };
        let mut command = command(program);
        let set = self.environment.iter().map(|(variable, value)| (variable, value));
        command.args(arguments).envs(set).current_dir(folder);
        Ok(command)
    }
}

/// Result of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ran {
    /// Whether the exit status was 0.
    pub(crate) passed: bool,
    /// Wall time.
    pub(crate) took: Duration,
}

/// Runs a step with its output on the terminal, and prints its time.
pub(crate) fn timed(folder: &Path, step: &Step) -> Result<Ran> {
    println!("== {}: {}", step.name, step.line());
    let begin = Instant::now();
    let status =
        step.command(folder)?.status().with_context(|| format!("`{}` did not start", step.line()))?;
    let ran = Ran { passed: status.success(), took: begin.elapsed() };
    let verdict = if ran.passed { "passed" } else { "FAILED" };
    println!("== {}: {verdict} in {:.1} s", step.name, ran.took.as_secs_f64());
    Ok(ran)
}

/// Returns what a command prints; an error with its messages if it fails.
pub(crate) fn output<'a>(folder: &Path, words: impl IntoIterator<Item = &'a str>) -> Result<String> {
    let step = Step::new("query", words);
    let output =
        step.command(folder)?.output().with_context(|| format!("`{}` did not start", step.line()))?;
    if !output.status.success() {
        let messages = String::from_utf8_lossy(&output.stderr);
        bail!("`{}` in {}: {}\n{messages}", step.line(), folder.display(), output.status);
    }
    String::from_utf8(output.stdout).with_context(|| format!("`{}` did not print UTF-8", step.line()))
}

/// Returns the command `program` without what cargo says to this process about its own package.
///
/// Build scripts ask cargo to run them again when such a variable changes (that of `ring` does). With them, a build from here
/// and one from a shell would compile half of the workspace anew each time.
pub(crate) fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    let own = |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
    let said = std::env::vars_os().filter(|(name, _)| name.to_str().is_some_and(own));
    for (name, _) in said {
        command.env_remove(name);
    }
    command
}

/// Name of the cargo that runs this program.
pub(crate) fn cargo() -> String {
    std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_fails_does_not_pass() {
        let here = Path::new(".");
        assert!(timed(here, &Step::new("good", ["true"])).unwrap().passed);
        assert!(!timed(here, &Step::new("bad", ["false"])).unwrap().passed);
        let error = output(here, ["sh", "-c", "echo reason >&2; exit 3"]).unwrap_err().to_string();
        assert!(error.contains("reason") && error.contains('3'), "{error}");
    }

    #[test]
    fn a_build_does_not_learn_which_package_has_started_it() {
        assert!(std::env::var_os("CARGO_MANIFEST_DIR").is_some(), "cargo names the package of a test");
        let named =
            output(Path::new("."), ["sh", "-c", "env | grep -c '^CARGO_\\(PKG\\|MANIFEST\\)_' || true"]);
        assert_eq!(named.unwrap().trim(), "0");
    }

    #[test]
    fn environment_reaches_the_command_and_its_line() {
        let step = Step::new("say", ["sh", "-c", "test \"$WORD\" = one"]).with("WORD", "one");
        assert!(timed(Path::new("."), &step).unwrap().passed);
        assert!(step.line().starts_with("WORD=one sh"), "{}", step.line());
    }
}
