//! The peers: Python programs in an environment of their own, with the messages of the node.

use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Returns the interpreter of the environment that `.ci/run` makes.
pub(crate) fn python() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("../ros2/bin/python")
}

/// Folder of the peers' sources.
fn sources() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/ros2/peers"))
}

/// Returns the packages of messages that the peers' wheels lack.
fn packages() -> [PathBuf; 2] {
    [Path::new(env!("CARGO_MANIFEST_DIR")).join("../ros2/meniscus_msgs"), sources().join("tf2_msgs")]
}

/// Folder of the messages for Python, by the newest change of their sources.
fn messages() -> PathBuf {
    let [own, transforms] = packages();
    let mut text = String::new();
    for file in ["msg/Estimate.msg", "msg/PlanSample.msg", "msg/SurfaceForecast.msg", "srv/Plan.srv"] {
        text += &std::fs::read_to_string(own.join(file)).expect("a definition");
    }
    text += &std::fs::read_to_string(transforms.join("msg/TFMessage.msg")).expect("a definition");
    let digest = crc::Crc::<u64>::new(&crc::CRC_64_XZ).checksum(text.as_bytes());
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ros2-messages-{digest:016x}"))
}

/// Returns what installs the peers, where they are missing.
pub(crate) fn missing() -> Option<String> {
    let environment = python().parent().and_then(Path::parent)?.display().to_string();
    let install = format!("{environment}/bin/pip install -r tests/ros2/peers/requirements.txt");
    (!python().exists())
        .then(|| format!("the peers are not installed: python3.11 -m venv {environment} && {install}"))
}

/// Builds the messages, unless they are there.
pub(crate) fn prepare() {
    let (done, part) = (messages(), messages().with_extension("part"));
    if done.exists() {
        return;
    }
    // A folder of a build that was interrupted.
    let _gone = std::fs::remove_dir_all(&part);
    for package in packages() {
        let mut command = Command::new(python());
        command.arg(sources().join("build_messages.py")).arg(package).arg(&part);
        let output = environment(&mut command).output().expect("python starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    std::fs::rename(&part, &done).expect("renamed");
}

/// Sets what rclpy wants to find in its environment.
fn environment(command: &mut Command) -> &mut Command {
    let prefix = python().parent().and_then(Path::parent).expect("a folder").to_path_buf();
    let libraries =
        std::env::join_paths(["meniscus_msgs", "tf2_msgs"].map(|package| messages().join(package)))
            .expect("no folder has a colon");
    command
        .env("AMENT_PREFIX_PATH", prefix)
        .env("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
        .env("ROS_DISTRO", "kilted")
        .env("FASTDDS_DEFAULT_PROFILES_FILE", sources().join("fastdds.xml"))
        .env("PYTHONPATH", messages())
        .env("LD_LIBRARY_PATH", libraries)
        .env_remove("ROS_DOMAIN_ID")
}

/// Returns a file for the standard error of a peer: one for each peer of a scene.
fn file_of_errors() -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let (process, peer) = (std::process::id(), NEXT.fetch_add(1, Ordering::Relaxed));
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ros2-peer-{process}-{peer}"))
}

/// A peer that runs.
pub(crate) struct Peer {
    name: String,
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    /// File of its standard error.
    said: Option<PathBuf>,
}

impl Peer {
    /// Starts one.
    pub(crate) fn start(source: &str, arguments: &[&str]) -> Self {
        // A program that runs its arguments.
        Self::start_by(Command::new("env"), source, arguments)
    }

    /// Returns the number of its process.
    pub(crate) fn id(&self) -> String {
        self.child.id().to_string()
    }

    /// Starts one by a command that gets it as its last arguments.
    pub(crate) fn start_by(mut command: Command, source: &str, arguments: &[&str]) -> Self {
        let name = format!("{source} {}", arguments.join(" "));
        command
            .arg(python())
            .arg(sources().join(source))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped());
        // Cyclone writes a line about each datagram of garbage.
        let said = (!source.starts_with("cyclone")).then(file_of_errors);
        command.stderr(
            said.as_ref().map_or_else(Stdio::null, |said| File::create(said).expect("a file").into()),
        );
        let mut child = environment(&mut command).spawn().expect("python starts");
        let input = child.stdin.take().expect("piped");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        Self { name, child, input, output, said }
    }

    /// Writes a line to it.
    pub(crate) fn tell(&mut self, line: &Value) {
        writeln!(self.input, "{line}").expect("it reads");
    }

    /// Returns the next line that it writes.
    pub(crate) fn line(&mut self) -> Value {
        let mut text = String::new();
        self.output.read_line(&mut text).expect("it writes text");
        if text.is_empty() {
            let status = self.child.wait().expect("it ends");
            panic!("{} ended without a line, {status}: {}", self.name, self.errors());
        }
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}: {text:?}", self.name))
    }

    /// Returns what it wrote to standard error.
    fn errors(&self) -> String {
        self.said.as_ref().and_then(|said| std::fs::read_to_string(said).ok()).unwrap_or_default()
    }

    /// Returns its last line, when it has ended.
    pub(crate) fn last_line(mut self) -> Value {
        let line = self.line();
        assert!(self.child.wait().expect("it ends").success(), "{}", self.name);
        line
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _killed = self.child.kill();
        let _waited = self.child.wait();
        if let Some(said) = &self.said {
            // What a peer said belongs to the scene's output, whether it failed or not.
            eprint!("{}", self.errors());
            let _gone = std::fs::remove_file(said);
        }
    }
}
