//! Program that runs for a limited time and writes a file of limited size; with everything that it started it is ended.

use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};
use std::io::Read;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Time between two looks at a running program.
const LOOK: Duration = Duration::from_millis(5);

/// Time that the last words of an ended program are waited for: what it left behind may hold its standard error open.
const LAST_WORDS: Duration = Duration::from_millis(500);

/// Bytes of standard error that are kept.
const KEPT: usize = 1000;

/// Limits of a program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits<'a> {
    /// Time.
    pub(super) time: Duration,
    /// File that it writes.
    pub(super) file: &'a Path,
    /// Size of that file.
    pub(super) bytes: u64,
    /// Flag that ends it.
    pub(super) stop: Option<&'a AtomicBool>,
}

/// End of a program.
#[derive(Debug)]
pub(super) enum Ended {
    /// It ended by itself; the end of its standard error.
    Itself(ExitStatus, String),
    /// It ran longer than it may.
    Late,
    /// Its file grew larger than it may.
    Large,
    /// The flag was raised.
    Stopped,
}

/// Runs `command` within `limits`.
///
/// # Errors
/// When it cannot be started or watched.
pub(super) fn run(mut command: Command, limits: &Limits<'_>) -> std::io::Result<Ended> {
    // Its own group, so that what it starts ends with it.
    command.process_group(0).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let words = last_words(&mut child);
    let begun = Instant::now();
    let why = loop {
        if has_ended(&child)? {
            break None;
        }
        if limits.stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            break Some(Ended::Stopped);
        }
        if begun.elapsed() > limits.time {
            break Some(Ended::Late);
        }
        if std::fs::metadata(limits.file).is_ok_and(|file| file.len() > limits.bytes) {
            break Some(Ended::Large);
        }
        std::thread::sleep(LOOK);
    };
    // Before the child is waited for, so that its number is still its own. An empty group is no error.
    if let Ok(group) = i32::try_from(child.id()).map(Pid::from_raw)
        && let Some(group) = group
    {
        let _ = kill_process_group(group, Signal::KILL);
    }
    let status = child.wait()?;
    if let Some(why) = why {
        return Ok(why);
    }
    let said = words.recv_timeout(LAST_WORDS).unwrap_or_default();
    Ok(Ended::Itself(status, said))
}

/// Returns whether `child` has ended, and leaves it to be waited for.
fn has_ended(child: &Child) -> std::io::Result<bool> {
    let Some(pid) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) else { return Ok(true) };
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    Ok(waitid(WaitId::Pid(pid), options)?.is_some())
}

/// Reads standard error to its end on a thread of its own, and sends the last of it.
fn last_words(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    if let Some(mut stream) = child.stderr.take() {
        std::thread::spawn(move || {
            let (mut kept, mut block) = (Vec::new(), [0; 4096]);
            while let Ok(count @ 1..) = stream.read(&mut block) {
                kept.extend_from_slice(&block[..count]);
                let surplus = kept.len().saturating_sub(KEPT);
                kept.drain(..surplus);
            }
            // Nobody waits for it where the program was ended.
            let _ = sender.send(String::from_utf8_lossy(&kept).trim().to_string());
        });
    }
    receiver
}
