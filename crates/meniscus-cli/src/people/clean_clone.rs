//! `meniscus people study --clean-clone`: how long from a clean clone to a moving liquid on the page.
//!
//! ```text
//! git clone | (cargo fetch, not counted) | cargo view: build, start | page up | frames come, and differ
//! ```

use anyhow::{Context, bail, ensure};
use meniscus_report::checks::Check;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tungstenite::Message;

/// Commands that the README tells a newcomer to type in the clone (`tests/docs.rs` holds it to this).
const COMMAND: &str = "cargo view";

/// Additions to it: any free port, and an end after one round of the recording, whose turns are judged.
const AND: [&str; 5] = ["--listen", "127.0.0.1:0", "--seconds", "12", "--json"];

/// Time that the page may take to show a liquid that moves once it is up.
const PATIENCE: Duration = Duration::from_secs(30);

/// Measurements.
pub(super) struct Measured {
    clone_s: f64,
    build_and_start_s: f64,
    first_move_s: f64,
    /// Checks of the run itself.
    run: Vec<(String, Option<f64>)>,
}

/// A folder that goes with the measurement.
struct Folder(PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _gone = std::fs::remove_dir_all(&self.0);
    }
}

/// A run that ends with this value.
struct Run(Child);

impl Drop for Run {
    fn drop(&mut self) {
        let _gone = self.0.kill();
        let _waited = self.0.wait();
    }
}

/// Clones `from` and measures. What cargo says goes to standard error.
pub(super) fn measure(from: &Path) -> anyhow::Result<Measured> {
    let folder = Folder(std::env::temp_dir().join(format!("meniscus-clean-clone-{}", std::process::id())));
    std::fs::create_dir_all(&folder.0).with_context(|| format!("cannot make {}", folder.0.display()))?;
    // A folder is found from anywhere; what is no folder is an address.
    let from = from.canonicalize().unwrap_or_else(|_| from.into());
    let begun = Instant::now();
    done(Command::new("git").args(["clone", "--quiet"]).arg(from).arg("meniscus").current_dir(&folder.0))?;
    let clone_s = begun.elapsed().as_secs_f64();
    let clone = folder.0.join("meniscus");
    // What the network gives is not the program's to promise.
    done(newcomer(&clone).args(["fetch", "--locked", "--quiet"]))?;

    let begun = Instant::now();
    let words = COMMAND.split(' ').skip(1);
    let mut run = Run(newcomer(&clone)
        .args(words)
        .args(AND)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("cargo cannot be started")?);
    let (Some(stdout), Some(stderr)) = (run.0.stdout.take(), run.0.stderr.take()) else {
        bail!("cargo has no output");
    };
    let said = std::thread::spawn(move || {
        let mut text = String::new();
        BufReader::new(stdout).read_to_string(&mut text).map(|_| text)
    });
    let mut lines = BufReader::new(stderr).lines().map_while(Result::ok);
    let url = lines.by_ref().find_map(|line| {
        eprintln!("{line}");
        line.strip_prefix("live page: ").map(str::to_owned)
    });
    // The rest is read, or the program would wait for room.
    std::thread::spawn(move || lines.for_each(|line| eprintln!("{line}")));
    let url = url.with_context(|| format!("`{COMMAND}` has not opened its page"))?;
    let build_and_start_s = begun.elapsed().as_secs_f64();
    moving(&url)?;
    let first_move_s = begun.elapsed().as_secs_f64() - build_and_start_s;
    let text = match said.join() {
        Ok(text) => text.context("the run's summary cannot be read")?,
        Err(_) => bail!("the run's summary cannot be read"),
    };
    let report: Value = serde_json::from_str(&text).context("the run ended without its summary")?;
    let check = |check: &Value| Some((check["name"].as_str()?.to_owned(), check["value"].as_f64()));
    let run = report["checks"].as_array().into_iter().flatten().filter_map(check).collect();
    Ok(Measured { clone_s, build_and_start_s, first_move_s, run })
}

/// cargo in the clone as a newcomer calls it: nothing that this shell says of profiles, flags or folders.
fn newcomer(clone: &Path) -> Command {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(clone);
    let own = |name: &str| {
        let of_cargo = name.starts_with("CARGO_") && name != "CARGO_HOME";
        of_cargo
            || name.starts_with("RUSTFLAGS")
            || name.starts_with("RUSTC")
            || name == "RUST_RECURSION_COUNT"
    };
    for (name, _) in std::env::vars_os() {
        if name.to_str().is_some_and(own) {
            cargo.env_remove(name);
        }
    }
    cargo
}

/// Runs `command` to its good end.
fn done(command: &mut Command) -> anyhow::Result<()> {
    let status = command.status().with_context(|| format!("{command:?} cannot be started"))?;
    ensure!(status.success(), "{command:?} ended with {status}");
    Ok(())
}

/// Waits, as a browser does, for two frames of the page at `url` in which the liquid is tracked and differs.
fn moving(url: &str) -> anyhow::Result<()> {
    let authority = url.trim_start_matches("http://").split('/').next().unwrap_or_default();
    let stream = TcpStream::connect(authority).with_context(|| format!("{url} does not answer"))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    let (mut socket, _) = tungstenite::client(format!("ws://{authority}/live"), stream)
        .map_err(|error| anyhow::anyhow!("{url} lets no viewer in: {error}"))?;
    // Frame taken, and 60 wanted a second (docs/page.md).
    let taken = |[a, b, c, d]: [u8; 4]| Message::binary(vec![a, b, c, d, 60, 0, 0, 0]);
    socket.send(taken([0; 4]))?;
    let (begun, mut before) = (Instant::now(), None::<Vec<u8>>);
    while begun.elapsed() < PATIENCE {
        let Message::Binary(frame) = socket.read().with_context(|| format!("{url} sends nothing"))? else {
            continue;
        };
        // A frame: kind 1, mode 1 (tracking), flags, 0; its number; the time; the rest is what is drawn.
        if let [1, mode, _, _, number @ ..] = &*frame
            && let Some((number, rest)) = number.split_first_chunk::<4>()
        {
            socket.send(taken(*number))?;
            let drawn = rest.get(8..).unwrap_or_default().to_vec();
            if *mode == 1 && before.replace(drawn.clone()).is_some_and(|before| before != drawn) {
                return Ok(());
            }
        }
    }
    bail!("{url} has shown no moving liquid for {} s", PATIENCE.as_secs())
}

impl Measured {
    /// Everything as checks.
    pub(super) fn checks(&self) -> Vec<Check> {
        let all_s = self.clone_s + self.build_and_start_s + self.first_move_s;
        let cores = std::thread::available_parallelism().map_or(f64::NAN, |cores| cores.get() as f64);
        let mut checks = vec![
            Check::at_most("clean_clone_to_view_s", all_s, "s", 180.0),
            Check::informational("clone_s", self.clone_s, "s"),
            Check::informational("build_and_start_s", self.build_and_start_s, "s"),
            Check::informational("page_to_move_s", self.first_move_s, "s"),
            Check::informational("cores", cores, "1"),
        ];
        for name in ["turn_us_median", "turn_us_p99", "deadline_misses", "surface_slosh_rel"] {
            let value = self.run.iter().find(|(own, _)| own == name).and_then(|(_, value)| *value);
            checks.push(Check::informational(name, value.unwrap_or(f64::NAN), unit(name)));
        }
        checks
    }
}

/// Unit of a check of the run.
fn unit(name: &str) -> &'static str {
    if name.starts_with("turn_us") { "us" } else { "1" }
}
