//! One part of a sweep: its command, run once, and what it left.
//!
//! ```text
//! DIR/parts/0001/            outputs of the command
//! DIR/parts/0001.log         its messages
//! DIR/parts/0001.lock        held while it runs
//! DIR/parts/0001.json        its answer and the checksums of its outputs, written last
//! DIR/parts/0001.failed      its exit status, where it failed
//! ```

use super::design::filled;
use super::manifest::Manifest;
use anyhow::{Context, bail};
use meniscus::blob::CRC;
use meniscus_platform::files::write_whole;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::fs::{self, File, TryLockError};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// State of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// Its record is there.
    Done,
    /// A task is at it.
    Running,
    /// Its command failed.
    Failed,
    /// Nothing was run yet, or a task was lost.
    Missing,
}

impl State {
    /// All states.
    pub(super) const ALL: [Self; 4] = [Self::Done, Self::Running, Self::Failed, Self::Missing];
}

/// End of [`run`].
pub(super) enum Done {
    /// It was done before.
    Before,
    /// It is done now.
    Now,
    /// Another task is at it.
    Elsewhere,
    /// It failed, with the reason.
    Failed(String),
}

/// Output of a part.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Output {
    /// Name in the part's folder.
    pub(super) name: String,
    /// Length, bytes.
    pub(super) bytes: u64,
    /// Checksum.
    pub(super) crc32: String,
}

/// Record of a part that is done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// Answer of the command, where it printed one JSON object.
    pub(super) answer: Option<Value>,
    /// Outputs, by name.
    pub(super) outputs: Vec<Output>,
}

/// Path of a part's folder or, with an ending, of a file beside it.
fn beside(folder: &Path, part: usize, ending: &str) -> PathBuf {
    folder.join("parts").join(format!("{:04}{ending}", part + 1))
}

/// Messages of a part.
pub(super) fn log(folder: &Path, part: usize) -> PathBuf {
    beside(folder, part, ".log")
}

/// State of a part.
pub(super) fn state(folder: &Path, part: usize) -> State {
    if beside(folder, part, ".json").exists() {
        return State::Done;
    }
    let lock = File::open(beside(folder, part, ".lock"));
    // The lock is let go as soon as it was had.
    if lock.is_ok_and(|lock| matches!(lock.try_lock(), Err(TryLockError::WouldBlock))) {
        return State::Running;
    }
    if beside(folder, part, ".failed").exists() { State::Failed } else { State::Missing }
}

/// Record of a part; none where it is not done.
pub(super) fn record(folder: &Path, part: usize) -> anyhow::Result<Option<Record>> {
    let path = beside(folder, part, ".json");
    let Ok(text) = fs::read_to_string(&path) else { return Ok(None) };
    let record = serde_json::from_str(&text).with_context(|| {
        format!("{} is no record of a part: remove it and run the sweep again", path.display())
    })?;
    Ok(Some(record))
}

/// Runs the part of this number, from 0, unless it is done or another task is at it.
pub(super) fn run(manifest: &Manifest, folder: &Path, part: usize) -> anyhow::Result<Done> {
    if record(folder, part)?.is_some() {
        return Ok(Done::Before);
    }
    fs::create_dir_all(folder.join("parts"))
        .with_context(|| format!("{} cannot be written", folder.display()))?;
    let lock = beside(folder, part, ".lock");
    let held = File::create(&lock).with_context(|| format!("{} cannot be written", lock.display()))?;
    if let Err(TryLockError::WouldBlock) = held.try_lock() {
        return Ok(Done::Elsewhere);
    }
    // Another task may have ended it since.
    if record(folder, part)?.is_some() {
        return Ok(Done::Before);
    }
    let out = beside(folder, part, "");
    if out.exists() && !manifest.resumes {
        fs::remove_dir_all(&out)
            .with_context(|| format!("{} of a lost task cannot be removed", out.display()))?;
    }
    fs::create_dir_all(&out).with_context(|| format!("{} cannot be made", out.display()))?;
    let whole = out.canonicalize().with_context(|| format!("{} cannot be found", out.display()))?;
    let whole = whole.to_str().context("the folder of a sweep needs a name in UTF-8")?;
    let values = &manifest.parts[part].values;
    let words: Vec<String> = manifest.parts[part]
        .words
        .iter()
        .map(|word| filled(word, values, whole))
        .collect::<Result<_, _>>()?;
    let messages = File::create(log(folder, part)).context("the messages of a part cannot be written")?;
    let mut child = Command::new(std::env::current_exe().context("this program cannot be found")?)
        .args(&words)
        .current_dir(&manifest.files_from)
        // The lock stays with the command, should this program be killed and the command go on.
        .stdin(Stdio::from(held))
        .stdout(Stdio::piped())
        .stderr(messages)
        .spawn()
        .with_context(|| {
            format!("`meniscus {}` cannot be started in {}", words.join(" "), manifest.files_from.display())
        })?;
    let mut printed = Vec::new();
    if let Some(stdout) = &mut child.stdout {
        stdout.read_to_end(&mut printed).context("the answer of a part cannot be read")?;
    }
    let status = child.wait().context("the end of a part cannot be seen")?;
    let failed = beside(folder, part, ".failed");
    if !status.success() {
        if crate::stop::raised() {
            // The command was interrupted with this program: it did not fail.
            return Ok(Done::Elsewhere);
        }
        let why = format!("`meniscus {}` ended with {status}", words.join(" "));
        write_whole(&failed, format!("{why}\n").as_bytes())?;
        return Ok(Done::Failed(why));
    }
    let record = Record { answer: serde_json::from_slice(&printed).ok(), outputs: outputs(&out)? };
    if record.answer.is_none() && record.outputs.is_empty() {
        let why = "it printed no JSON object and wrote no file: give its command --json, or {out}";
        write_whole(&failed, format!("{why}\n").as_bytes())?;
        return Ok(Done::Failed(why.into()));
    }
    write_whole(
        &beside(folder, part, ".json"),
        format!("{}\n", serde_json::to_string_pretty(&record)?).as_bytes(),
    )?;
    if failed.exists() {
        fs::remove_file(&failed).context("the note of an earlier failure cannot be removed")?;
    }
    Ok(Done::Now)
}

/// The files below `folder` with their checksums, by name.
fn outputs(folder: &Path) -> anyhow::Result<Vec<Output>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).with_context(|| format!("{} cannot be read", next.display()))? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned();
            let (bytes, crc32) = checksum(&path)?;
            found.push(Output { name, bytes, crc32 });
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// Length and checksum of a file.
fn checksum(path: &Path) -> anyhow::Result<(u64, String)> {
    let mut file = File::open(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let (mut digest, mut length, mut buffer) = (CRC.digest(), 0, vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok((length, format!("{:08x}", digest.finalize()))),
            Ok(count) => {
                digest.update(&buffer[..count]);
                length += count as u64;
            }
            Err(error) => bail!("{} cannot be read: {error}", path.display()),
        }
    }
}
