//! Command as a simulator of the glass.

use super::answer::SimulatorAnswer;
use super::carried;
use super::process::{Ended, Limits, run};
use super::scene::{FORMAT, Scene};
use crate::fitting::fit_cache::CacheKey;
use crate::insert::simulated::Course;
use crate::insert::simulator::{GlassSimulator, SimulatorFault};
use meniscus::reduced::effects::{Active, Stated};
use meniscus::surface::POINTS;
use meniscus_data::effects::Effects;
use meniscus_sph::Setup;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;
use thiserror::Error;

/// Largest file whose content distinguishes one version of a simulator from another, bytes.
const HASHED: u64 = 64 << 20;

/// Bytes of an answer for each height, and beside them: a double in full is 20 characters.
const ANSWER_BYTES: (u64, u64) = (40, 1 << 16);

/// Reason for which a command cannot be a simulator.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CommandError {
    /// The text holds no program.
    #[error("'{0}' is no command: write a program and its arguments as in a shell, with each quote closed")]
    Text(String),
    /// There is no such program.
    #[error("the simulator '{0}' is not there, or may not be run: give a path, or a program of PATH")]
    Program(String),
}

/// Command that simulates: it gets the names of a scene and of its answer behind its own arguments.
#[derive(Clone, Debug)]
pub struct CommandSimulator {
    text: String,
    identity: String,
    words: Vec<String>,
    limit: Duration,
}

impl CommandSimulator {
    /// Returns the simulator that `text` spells as a shell would read it; a call may take as long as `limit`.
    ///
    /// # Errors
    /// [`CommandError`], when it is no command or there is no such program.
    pub fn new(text: &str, limit: Duration) -> Result<Self, CommandError> {
        let words = shlex::split(text).filter(|words| !words.is_empty());
        let words = words.ok_or_else(|| CommandError::Text(text.into()))?;
        let program = find(&words[0]).ok_or_else(|| CommandError::Program(words[0].clone()))?;
        let mut key = CacheKey::new();
        // The content of the program and of all files that its words name: an edited script is another simulator.
        for path in std::iter::once(program).chain(words[1..].iter().map(PathBuf::from)) {
            let small = std::fs::metadata(&path).is_ok_and(|file| file.is_file() && file.len() <= HASHED);
            if small && let Ok(bytes) = std::fs::read(&path) {
                key.add(bytes.iter().map(|byte| f64::from(*byte)));
            }
        }
        let identity = format!("command {FORMAT} {:016x} {}", key.finish(), words.join("\0"));
        Ok(Self { text: text.into(), identity, words, limit })
    }

    /// Runs the command on `scene` in the folder `scratch`.
    fn ask(
        &self,
        scene: &Scene,
        scratch: &Path,
        stop: Option<&AtomicBool>,
    ) -> Result<SimulatorAnswer, SimulatorFault> {
        let broken = |why: String| SimulatorFault::Broken(format!("the simulator '{}' {why}", self.text));
        let (request, answer) = (scratch.join("request.json"), scratch.join("answer.json"));
        let text = serde_json::to_vec(scene).map_err(|error| broken(error.to_string()))?;
        std::fs::write(&request, text)
            .map_err(|error| broken(format!("was not asked: {}: {error}", request.display())))?;
        let numbers = scene.motions.iter().map(|motion| motion.frames * POINTS).sum::<usize>() as u64;
        let bytes = ANSWER_BYTES.0 * numbers + ANSWER_BYTES.1;
        let mut command = Command::new(&self.words[0]);
        command.args(&self.words[1..]).arg(&request).arg(&answer);
        let limits = Limits { time: self.limit, file: &answer, bytes, stop };
        log::trace!("{command:?}");
        let seconds = self.limit.as_secs_f64();
        match run(command, &limits).map_err(|error| broken(format!("cannot be run: {error}")))? {
            Ended::Stopped => return Err(SimulatorFault::Stopped),
            Ended::Late => {
                return Err(broken(format!(
                    "was ended after {seconds} s, the longest that one call may take (--simulator-seconds)"
                )));
            }
            Ended::Large => return Err(broken(large(bytes))),
            Ended::Itself(status, said) if !status.success() => {
                let said =
                    if said.is_empty() { "it said nothing".into() } else { format!("it said: {said}") };
                return Err(broken(format!("failed ({status}); {said}")));
            }
            Ended::Itself(..) => {}
        }
        if std::fs::metadata(&answer).is_ok_and(|file| file.len() > bytes) {
            return Err(broken(large(bytes)));
        }
        let text = std::fs::read(&answer).map_err(|_| {
            broken("ended without the answer: it writes the file that its last argument names".into())
        })?;
        let answer: SimulatorAnswer =
            serde_json::from_slice(&text).map_err(|error| broken(wrong(&text, &error)))?;
        match answer.meniscus_simulator {
            Some(FORMAT) => Ok(answer),
            Some(other) => Err(broken(format!("answered in version {other} of the protocol, not {FORMAT}"))),
            None => Err(broken(format!("answered without \"meniscus_simulator\": {FORMAT}, the version"))),
        }
    }
}

impl GlassSimulator for CommandSimulator {
    fn name(&self) -> &str {
        &self.text
    }

    fn identity(&self) -> &str {
        &self.identity
    }

    fn carried(&self, effects: &[Active], stated: &Stated) -> Result<Effects, String> {
        carried(effects, stated)
    }

    fn particle_step_s(&self) -> Option<f64> {
        None
    }

    fn run(
        &self,
        setup: &Setup,
        courses: &[&Course],
        stop: Option<&AtomicBool>,
    ) -> Result<Vec<Vec<f32>>, SimulatorFault> {
        let scene = Scene::new(setup, courses).map_err(SimulatorFault::Here)?;
        let scratch = Scratch::new().map_err(|error| {
            SimulatorFault::Broken(format!("no folder for the simulator's files: {error}"))
        })?;
        let answer = self.ask(&scene, &scratch.0, stop)?;
        answer.heights(&format!("the simulator '{}'", self.text), setup, courses)
    }
}

fn large(bytes: u64) -> String {
    format!("wrote an answer of more than {} kB, the largest for these motions", bytes / 1000)
}

/// Returns what is wrong with an answer that is no JSON of the protocol.
fn wrong(text: &[u8], error: &serde_json::Error) -> String {
    let line = text.split(|byte| *byte == b'\n').nth(error.line().saturating_sub(1)).unwrap_or_default();
    let from = &line[error.column().saturating_sub(2).min(line.len())..];
    let not_finite = [&b"NaN"[..], b"Infinity", b"-Infinity", b"nan", b"inf"];
    if not_finite.iter().any(|word| from.windows(word.len()).take(3).any(|part| part == *word)) {
        return format!("answered with NaN or an infinite number ({error})");
    }
    format!("answered with something else than JSON of the protocol: {error}")
}

/// Returns the file that the shell would run for `program`.
fn find(program: &str) -> Option<PathBuf> {
    let runs = |path: &PathBuf| {
        std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.permissions().mode() & 0o111 != 0)
    };
    if program.contains('/') {
        return Some(PathBuf::from(program)).filter(runs);
    }
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(program)).find(runs)
}

/// A folder that goes with its owner.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> std::io::Result<Self> {
        static MADE: AtomicUsize = AtomicUsize::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let name = format!("meniscus-simulator-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        std::fs::create_dir(&path)?;
        Ok(Self(path))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What is left of it lies in the folder for temporary files.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
