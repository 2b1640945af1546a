//! `meniscus sweep` on one machine, by GNU parallel and by a real Slurm: whoever runs the parts, the report is the same to the byte.

#[path = "support/program.rs"]
mod program;

use program::{errors, folder, json, meniscus};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Four small simulations.
const DESIGN: &str = "command = \"simulate --liquid {liquid} --motion strokes:{seed}x0.2 --seconds 1.5 --spacing-mm 8.75 \
                      --out {out}/slosh.safetensors\"\n[vary]\nliquid = [\"water\", \"glycerine\"]\nseed = [1, 2]\n";

/// Longest time that a sweep of this size takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(240);

/// Makes a sweep of `design` in `folder`/`name`.
fn made(folder: &Path, design: &str, name: &str) -> PathBuf {
    fs::write(folder.join("design.toml"), design).expect("a design");
    let output = meniscus(folder, &format!("sweep make design.toml --out {name}"));
    assert!(output.status.success(), "{}", errors(&output));
    folder.join(name)
}

/// Runs `arguments`, which have to succeed.
fn done(folder: &Path, arguments: &str) {
    let output = meniscus(folder, arguments);
    assert!(output.status.success(), "{arguments}: {}", errors(&output));
}

/// Runs `arguments`, which have to fail and to say each of `words`.
fn refused(folder: &Path, arguments: &str, words: &[&str]) {
    let output = meniscus(folder, arguments);
    let errors = errors(&output);
    assert!(!output.status.success(), "{arguments} must be refused");
    for word in words {
        assert!(errors.contains(word), "`{word}` is missing in: {errors}");
    }
    assert!(!errors.contains("panicked"), "{errors}");
}

/// Merges the sweep `name` in `folder` and returns both reports.
fn merged(folder: &Path, name: &str) -> [Vec<u8>; 2] {
    done(folder, &format!("sweep merge {name}"));
    ["report.json", "report.csv"].map(|file| fs::read(folder.join(name).join(file)).expect("a report"))
}

/// The sweep of [`DESIGN`] as one task runs it.
struct Alone {
    folder: PathBuf,
    report: [Vec<u8>; 2],
}

impl Alone {
    /// Returns it; it is run once for all tests.
    fn run() -> &'static Self {
        static ALONE: OnceLock<Alone> = OnceLock::new();
        ALONE.get_or_init(|| {
            let folder = folder("sweep", "one");
            made(&folder, DESIGN, "alone");
            done(&folder, "sweep run alone");
            let report = merged(&folder, "alone");
            Self { folder, report }
        })
    }
}

/// A part of the sweep `name` that is under way.
fn under_way(folder: &Path, name: &str) -> bool {
    json(&meniscus(folder, &format!("sweep status {name} --json")))["running"] != 0
}

/// Runs the sweep `name` again until no part is missing, as a person would after a task was lost.
fn run_again(folder: &Path, name: &str) {
    let begun = Instant::now();
    loop {
        done(folder, &format!("sweep run {name}"));
        let status = json(&meniscus(folder, &format!("sweep status {name} --json")));
        if status["done"] == status["parts"] {
            return;
        }
        assert!(begun.elapsed() < PATIENCE, "{status:#}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

#[test]
fn tasks_that_share_a_folder_and_one_that_is_killed_give_the_report_of_one() {
    let folder = folder("sweep", "shared");
    let shared = made(&folder, DESIGN, "shared");
    made(&folder, DESIGN, "broken");
    let Alone { folder: folder_of_one, report } = Alone::run();
    let text = String::from_utf8_lossy(&report[0]).into_owned();
    assert!(text.contains("slosh.safetensors") && text.contains("\"partial\": false"), "{text}");
    assert!(
        !text.contains(folder_of_one.to_str().expect("UTF-8")),
        "a report says nothing about where it was made: {text}"
    );

    // Two tasks, the second first.
    done(&folder, "sweep run shared --part 2/2");
    refused(&folder, "sweep merge shared", &["2 of 4 parts are not done", "the first is 1"]);
    done(&folder, "sweep merge shared --partial --json");
    let partial = fs::read_to_string(shared.join("report.json")).expect("a report");
    assert!(partial.contains("\"partial\": true"), "{partial}");
    done(&folder, "sweep run shared --part 1/2");
    assert!(merged(&folder, "shared") == *report, "two tasks make the report of one");

    // Killed in the middle of a part, whose command goes on alone; a task beside it leaves that part to it.
    let mut child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["sweep", "run", "broken"])
        .current_dir(&folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    let begun = Instant::now();
    while !under_way(&folder, "broken") {
        assert!(begun.elapsed() < PATIENCE, "no part runs");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("killed");
    child.wait().expect("it ends");
    run_again(&folder, "broken");
    assert!(merged(&folder, "broken") == *report, "a task that was killed changes nothing");
    // What is done is not done twice.
    let written =
        |name: &Path| fs::metadata(name.join("parts/0001/slosh.safetensors")).expect("a file").modified();
    let alone = folder_of_one.join("alone");
    let before = written(&alone).expect("a time");
    done(folder_of_one, "sweep run alone");
    assert_eq!(written(&alone).expect("a time"), before);
}

#[test]
fn a_part_that_fails_is_named_and_tried_again() {
    let folder = folder("sweep", "failing");
    let design = "command = \"simulate --motion {table} --seconds 1.5 --spacing-mm 8.75 --out {out}/x.safetensors\"\n\
                  [vary]\ntable = [\"still:1\", \"later.csv\"]\n";
    made(&folder, design, "failing");
    refused(&folder, "sweep run failing", &["part 2 failed", "1 parts failed", "0002.log", "run again"]);
    let log = fs::read_to_string(folder.join("failing/parts/0002.log")).expect("its messages");
    assert!(log.contains("later.csv"), "{log}");
    let status = json(&meniscus(&folder, "sweep status failing --json"));
    assert_eq!((&status["done"], &status["failed"]), (&1.into(), &1.into()));
    // The file is found beside the design, wherever the command is run from.
    let rows: String = (0..40).map(|n| format!("{},0\n", 0.05 * f64::from(n))).collect();
    fs::write(folder.join("later.csv"), format!("t,x_m\n{rows}")).expect("a motion");
    done(folder.parent().expect("a parent"), "sweep run failing/failing");
    let status = json(&meniscus(&folder, "sweep status failing --json"));
    assert_eq!((&status["done"], &status["failed"]), (&2.into(), &0.into()));
}

#[test]
fn faults_of_a_design_are_named_before_the_work() {
    let folder = folder("sweep", "faults");
    let write = |text: &str| fs::write(folder.join("design.toml"), text).expect("a design");
    write("command = \"simulate --motion {m} --second 1 --out {out}/x\"\n[vary]\nm = [\"still:1\"]\n");
    refused(&folder, "sweep make design.toml --out x", &["part 1 cannot run", "--second"]);
    assert!(!folder.join("x/manifest.json").exists());
    write("command = \"simulate\"\n[vary]\nm = [1\n");
    refused(&folder, "sweep make design.toml --out x", &["design.toml is no design", "line"]);
    refused(&folder, "sweep make none.toml --out x", &["none.toml cannot be read"]);
    refused(&folder, "sweep run nowhere", &["manifest.json cannot be read", "sweep make"]);
    write(DESIGN);
    done(&folder, "sweep make design.toml --out y");
    done(&folder, "sweep make design.toml --out y");
    write(&DESIGN.replace("[1, 2]", "[1, 3]"));
    refused(&folder, "sweep make design.toml --out y", &["another sweep"]);
    refused(&folder, "sweep run y --part 5/4", &["'5/4' is not I/N"]);
    let manifest = folder.join("y/manifest.json");
    let older = fs::read_to_string(&manifest).expect("it").replace(env!("CARGO_PKG_VERSION"), "0.0.1");
    fs::write(&manifest, older).expect("written");
    refused(&folder, "sweep run y", &["version 0.0.1", "no one report"]);
}

/// Whether the program `name` is installed; on the machine of CI it has to be.
fn is_installed(name: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {name}")]).stdout(Stdio::null()).status();
    let found = found.is_ok_and(|status| status.success());
    assert!(found || std::env::var_os("CI").is_none(), "{name} is not installed");
    found
}

/// Folder with the program under its own name, for the scripts.
fn path_with_program(folder: &Path) -> String {
    let bin = folder.join("bin");
    fs::create_dir_all(&bin).expect("a folder");
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_meniscus-under-test"), bin.join("meniscus"))
        .expect("a link");
    format!("{}:{}", bin.display(), std::env::var("PATH").unwrap_or_default())
}

#[test]
fn gnu_parallel_gives_the_report_of_one() {
    if !is_installed("parallel") {
        return;
    }
    let folder = folder("sweep", "parallel");
    made(&folder, DESIGN, "parallel");
    let output = Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/sweep/parallel.sh"))
        .args(["parallel", "3"])
        .current_dir(&folder)
        .env("PATH", path_with_program(&folder))
        .output()
        .expect("it starts");
    assert!(output.status.success(), "{}", errors(&output));
    assert!(merged(&folder, "parallel") == Alone::run().report);
}

/// A Slurm of one node, ended with the test.
struct Slurm(PathBuf);

impl Slurm {
    fn script(verb: &str, folder: &Path) -> std::process::Output {
        Command::new(concat!(env!("CARGO_MANIFEST_DIR"), "/support/slurm.sh"))
            .arg(verb)
            .arg(folder)
            // Daemons that hold the output open would keep this one waiting for its end.
            .stdout(Stdio::null())
            .stderr(fs::File::create(folder.join("said.txt")).expect("a file"))
            .output()
            .expect("it starts")
    }

    fn start(folder: PathBuf) -> Self {
        let output = Self::script("start", &folder);
        let said = fs::read_to_string(folder.join("said.txt")).unwrap_or_default();
        assert!(output.status.success(), "{said}");
        Self(folder)
    }

    /// A client's command of this Slurm.
    fn client(&self, name: &str) -> Command {
        let mut command = Command::new(name);
        command.env("SLURM_CONF", self.0.join("slurm.conf"));
        command
    }
}

impl Drop for Slurm {
    fn drop(&mut self) {
        Self::script("stop", &self.0);
    }
}

#[test]
fn a_job_array_of_slurm_with_a_killed_task_gives_the_report_of_one() {
    if !["slurmctld", "slurmd", "munged", "sbatch"].iter().all(|name| is_installed(name)) {
        return;
    }
    let folder = folder("sweep", "slurm");
    let slurm = folder.join("cluster");
    fs::create_dir_all(&slurm).expect("a folder");
    let slurm = Slurm::start(slurm);
    made(&folder, DESIGN, "array");
    let path = path_with_program(&folder);
    let submit = |wait: &[&str]| {
        let mut command = slurm.client("sbatch");
        command.args(wait).args(["--parsable", "--array=1-2"]);
        command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/sweep/slurm.sh")).arg("array");
        let output = command.current_dir(&folder).env("PATH", &path).output().expect("it starts");
        (output.status, String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let (_, job) = submit(&[]);
    let begun = Instant::now();
    while !under_way(&folder, "array") {
        assert!(begun.elapsed() < PATIENCE, "no task runs");
        std::thread::sleep(Duration::from_millis(20));
    }
    let cancelled = slurm.client("scancel").args(["--signal=KILL", &format!("{job}_1")]).status();
    assert!(cancelled.expect("scancel starts").success(), "task 1 of job {job} is killed");
    let begun = Instant::now();
    while !slurm.client("squeue").args(["-h", "-j", &job]).output().expect("squeue starts").stdout.is_empty()
    {
        assert!(begun.elapsed() < PATIENCE, "the array ends");
        std::thread::sleep(Duration::from_millis(200));
    }
    refused(&folder, "sweep merge array", &["parts are not done"]);
    let (status, _) = submit(&["--wait"]);
    assert!(status.success(), "the array ends well the second time: {status}");
    assert!(merged(&folder, "array") == Alone::run().report);
}
