//! `cargo xtask nightly`: steps that take hours, one log per night in `docs/nightly/DATE.log`.

use crate::process::{self, Step, cargo};
use crate::workspace;
use anyhow::{Context, Result, bail};
use clap::Args;
use serde_json::Value;
use std::fmt::Write as _;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Last lines of a step's output that the log keeps.
const KEPT_LINES: usize = 20;
/// Mutations per target of the fuzz tests.
const FUZZ_CASES: &str = "1000000";

/// Files of the core that mutation testing alters.
const MUTATED: [&str; 10] = [
    "blob/load",
    "filter/covariance",
    "filter/kalman",
    "filter/measurements",
    "latent/generic/step",
    "surface/depth",
    "surface/extract",
    "uncertainty/error_model",
    "usb/d4xx/table",
    "usb/uvc/assembler",
];

/// Options of `cargo xtask nightly`.
#[derive(Args)]
pub(crate) struct Options {
    /// Only this step; may be repeated.
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Print the steps and run none.
    #[arg(long)]
    list: bool,
}

/// Runs the steps and returns whether all passed. A step that fails does not stop the others.
pub(crate) fn run(options: &Options) -> Result<bool> {
    let root = workspace::root()?;
    let steps = chosen(steps(&root), &options.only)?;
    if options.list {
        for step in &steps {
            println!("{:<16} {}", step.name, step.line());
        }
        return Ok(true);
    }
    let mut log = header(&root)?;
    let path = root.join("docs/nightly").join(format!("{}.log", date(&root)?));
    let mut passed = true;
    for step in &steps {
        println!("== {}: {}", step.name, step.line());
        let done = attempt(&root, step);
        passed &= done.passed();
        let record = done.record(step);
        print!("{record}");
        log += &record;
        // After every step, so that an interrupted night leaves what it measured.
        write(&path, &log)?;
    }
    println!("nightly: {} in {}", if passed { "all passed" } else { "FAILED" }, path.display());
    Ok(passed)
}

/// The steps of a night. The program is built first; the studies run that build.
fn steps(root: &Path) -> Vec<Step> {
    let cargo = cargo();
    let program = workspace::target(root).join("release/meniscus").to_string_lossy().into_owned();
    let study =
        |name: &str, words: &str| Step::new(name, [&program].into_iter().cloned().chain(split(words)));
    let with_cargo =
        |name: &str, words: &str| Step::new(name, [&cargo].into_iter().cloned().chain(split(words)));
    vec![
        with_cargo("build", "build --release --locked -p meniscus-cli --features train,foxglove"),
        with_cargo("house", "xtask house --rebuild --json"),
        with_cargo("package", "xtask package"),
        with_cargo("board", "xtask board --json"),
        // `cargo install cargo-deny typos-cli`; advisories are asked for where their database can be fetched.
        with_cargo("licences", "deny --workspace check licenses bans sources"),
        Step::new("spelling", split("typos")),
        with_cargo("fuzz", "test --release --locked --workspace --test fuzz")
            .with("MENISCUS_FUZZ", FUZZ_CASES),
        // `cargo install cargo-mutants`; `.cargo/mutants.toml` has its settings.
        with_cargo(
            "mutants",
            &format!("mutants {}", MUTATED.map(|file| format!("-f src/{file}.rs")).join(" ")),
        ),
        study("validate", "simulate validate --json --out out/nightly/validation"),
        study("discover", "discover study --json --out out/nightly/discover"),
        study("camera", "camera study --json --check --out out/nightly/camera"),
        study("deadline", "deadline --json --out out/nightly/deadline"),
        with_cargo("under-attack", "xtask under-attack --json"),
        study("people", "people study --json --check"),
        Step::new("hil-gate", split("hil/run gate --json")),
        Step::new("hil-boot", split("hil/run boot --json")),
        Step::new("hil-install", split("hil/run install --json")),
        Step::new("hil-xhci", split("hil/run xhci --json")),
        Step::new("hil-webcam", split("hil/run webcam")),
        Step::new("hil-bare-metal", split("hil/run bare-metal --json")),
        Step::new("hil-soak", split("hil/run soak --json")),
    ]
}

fn split(words: &str) -> impl Iterator<Item = String> {
    words.split_whitespace().map(str::to_owned)
}

/// The steps with the given names; all of them without a name.
fn chosen(steps: Vec<Step>, only: &[String]) -> Result<Vec<Step>> {
    let known: Vec<&str> = steps.iter().map(|step| step.name.as_str()).collect();
    if let Some(name) = only.iter().find(|name| !known.contains(&name.as_str())) {
        bail!("there is no step `{name}`; the steps are {}", known.join(", "));
    }
    Ok(steps.into_iter().filter(|step| only.is_empty() || only.contains(&step.name)).collect())
}

/// Date, commit and processor.
fn header(root: &Path) -> Result<String> {
    let commit = process::output(root, ["git", "log", "-1", "--format=%H %s"])?;
    let changed = process::output(root, ["git", "status", "--porcelain"])?;
    let tree = if changed.trim().is_empty() { "clean" } else { "with uncommitted changes" };
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let processors = std::thread::available_parallelism().map_or(1, Into::into);
    let mut text = String::new();
    let _ = writeln!(text, "date    {}", process::output(root, ["date", "-u", "+%FT%TZ"])?.trim());
    let _ = writeln!(text, "commit  {} ({tree})", commit.trim());
    let _ = writeln!(text, "cpu     {}, {processors} processors", cpu_model(&cpu));
    Ok(text)
}

fn date(root: &Path) -> Result<String> {
    Ok(process::output(root, ["date", "-u", "+%F"])?.trim().to_owned())
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

/// Outcome of a step.
struct Done {
    /// Exit status, or why there is none.
    status: String,
    exit_zero: bool,
    /// Names of the checks in its report that missed their target.
    missed: Vec<String>,
    took: Duration,
    last_lines: Vec<String>,
}

impl Done {
    fn passed(&self) -> bool {
        self.exit_zero && self.missed.is_empty()
    }

    /// The step's part of the log.
    fn record(&self, step: &Step) -> String {
        let verdict = if self.passed() { "passed" } else { "FAILED" };
        let mut text = format!("\n== {} {verdict} in {:.0} s\n", step.name, self.took.as_secs_f64());
        // Where cargo and the program lie on this machine is of no use to a reader of the log.
        let _ = writeln!(text, "command {}", step.line().replace(&cargo(), "cargo"));
        let _ = writeln!(text, "status  {}", self.status);
        if !self.missed.is_empty() {
            let _ = writeln!(text, "missed  {}", self.missed.join(", "));
        }
        for line in &self.last_lines {
            let _ = writeln!(text, "  {line}");
        }
        text
    }
}

/// Runs a step; one that does not start has failed like any other.
fn attempt(root: &Path, step: &Step) -> Done {
    let begin = Instant::now();
    let ran = output_of(root, step);
    let took = begin.elapsed();
    match ran {
        Ok((status, lines)) => {
            let last_lines = lines[lines.len().saturating_sub(KEPT_LINES)..].to_vec();
            let missed = missed_checks(&lines.join("\n"));
            Done { status: status.to_string(), exit_zero: status.success(), missed, took, last_lines }
        }
        Err(error) => Done {
            status: format!("{error:#}"),
            exit_zero: false,
            missed: Vec::new(),
            took,
            last_lines: Vec::new(),
        },
    }
}

/// Exit status and output of a step; its messages go to the terminal and are kept where it prints nothing else.
fn output_of(root: &Path, step: &Step) -> Result<(std::process::ExitStatus, Vec<String>)> {
    let mut command = step.command(root)?;
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).stdin(Stdio::null());
    let mut child = command.spawn().with_context(|| format!("`{}` did not start", step.line()))?;
    // Both pipes are emptied at the same time: a child that fills one of them would wait for ever.
    let messages = child.stderr.take().map(|pipe| {
        std::thread::spawn(move || {
            let lines = BufReader::new(pipe).lines().map_while(Result::ok);
            lines.inspect(|line| eprintln!("{line}")).collect::<Vec<_>>()
        })
    });
    let printed: Vec<String> = child
        .stdout
        .take()
        .map_or(Vec::new(), |pipe| BufReader::new(pipe).lines().map_while(Result::ok).collect());
    let said = messages.and_then(|thread| thread.join().ok()).unwrap_or_default();
    let status = child.wait().with_context(|| format!("`{}` was lost", step.line()))?;
    Ok((status, if status.success() { printed } else { printed.into_iter().chain(said).collect() }))
}

/// Names of the checks that miss their target in a report `{"checks": [{"name", "ok", ..}]}`. The studies print one and
/// end with status 0 whatever it says.
fn missed_checks(output: &str) -> Vec<String> {
    let Some(report) = output.find('{').and_then(|at| serde_json::from_str::<Value>(&output[at..]).ok())
    else {
        return Vec::new();
    };
    let checks = report["checks"].as_array().map_or(&[][..], Vec::as_slice);
    let missed = checks.iter().filter(|check| check["ok"] == false);
    missed.map(|check| check["name"].as_str().unwrap_or("unnamed").to_owned()).collect()
}

fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
    std::fs::write(path, text).with_context(|| format!("{} cannot be written", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_fails_is_recorded_with_its_messages() {
        let step = Step::new("bad", ["sh", "-c", "echo printed; echo reason >&2; exit 4"]);
        let done = attempt(Path::new("."), &step);
        assert!(!done.passed());
        let record = done.record(&step);
        assert!(record.contains("== bad FAILED") && record.contains("exit status: 4"), "{record}");
        assert!(record.contains("  printed\n  reason\n"), "{record}");
        let absent = attempt(Path::new("."), &Step::new("absent", ["./no-such-program"]));
        assert!(!absent.passed() && absent.status.contains("did not start"), "{}", absent.status);
    }

    #[test]
    fn a_missed_target_in_a_report_fails_the_step() {
        let report = r#"{"checks": [{"name": "a", "ok": true}, {"name": "b", "ok": false}, {"name": "c", "ok": null}]}"#;
        assert_eq!(missed_checks(report), ["b"]);
        let done = attempt(Path::new("."), &Step::new("study", ["echo", report]));
        assert!(done.exit_zero && !done.passed());
        assert!(missed_checks("no report").is_empty());
    }

    #[test]
    fn unknown_steps_are_refused_and_known_ones_chosen() {
        let all = || steps(Path::new("/w"));
        assert_eq!(chosen(all(), &["fuzz".to_owned()]).unwrap()[0].name, "fuzz");
        assert_eq!(chosen(all(), &[]).unwrap().len(), all().len());
        let error = chosen(all(), &["fuz".to_owned()]).unwrap_err().to_string();
        assert!(error.contains("`fuz`") && error.contains("validate"), "{error}");
    }

    #[test]
    fn processors_have_a_name() {
        assert_eq!(cpu_model("processor : 0\nmodel name\t: Some CPU @ 3 GHz\n"), "Some CPU @ 3 GHz");
        assert_eq!(cpu_model("processor : 0\nCPU part : 0xd08\n"), "CPU part 0xd08");
    }
}
