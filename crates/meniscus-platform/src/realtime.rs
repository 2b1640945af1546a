//! Rights to run in real time: what this user may do, and the attempt to do it.

use rustix::mm::{MlockAllFlags, mlockall};
use rustix::process::{Resource, getrlimit};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use thread_priority::ThreadPriority;
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

/// Priority of the camera's thread, of 1 to 99: above ordinary work, below the kernel's own threads.
pub const PRIORITY: u8 = 40;

/// Scheduling of a thread.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Priority {
    /// As any other thread.
    #[default]
    Normal,
    /// SCHED_FIFO; for a worker also a core of its own and locked memory, as far as the system grants them.
    RealTime,
}

impl Priority {
    /// Returns real-time scheduling if it is `wanted`.
    #[must_use]
    pub fn real_time_if(wanted: bool) -> Self {
        if wanted { Self::RealTime } else { Self::Normal }
    }
}

/// Highest real-time priority that this user may take; `None` for no limit.
#[must_use]
pub fn priority_limit() -> Option<u64> {
    getrlimit(Resource::Rtprio).current
}

/// Bytes that this user may lock into memory; `None` for no limit.
#[must_use]
pub fn locked_memory_limit() -> Option<u64> {
    getrlimit(Resource::Memlock).current
}

/// Tries to put the calling thread under SCHED_FIFO.
///
/// # Errors
/// What the system said, in words.
pub fn become_realtime() -> Result<(), String> {
    let priority = ThreadPriority::Crossplatform(PRIORITY.try_into().map_err(|_| "no such priority")?);
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| format!("{error}"))
}

/// Real-time rights that a thread requested, each granted or refused.
#[derive(Clone, Debug)]
pub struct Granted {
    /// SCHED_FIFO at [`PRIORITY`].
    pub fifo: Result<(), String>,
    /// The core that the thread stays on; `Ok(None)` where there is only one.
    pub core: Result<Option<usize>, String>,
    /// All memory of the program, now and to come, held in place: no turn waits for a page.
    pub locked: Result<(), String>,
}

impl Granted {
    /// Asks for everything, for the calling thread.
    #[must_use]
    pub fn ask() -> Self {
        // Memory first: a thread under SCHED_FIFO that faults pages in holds up everybody.
        let locked =
            mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(|error| format!("{error}"));
        Self { locked, core: pin(), fifo: become_realtime() }
    }

    /// One line for each that was not granted, with what to do.
    #[must_use]
    pub fn refusals(&self) -> Vec<String> {
        let warning = |what: &str, why: &str, limit: &str| {
            format!(
                "{what}: {why}; give the user {limit} (/etc/security/limits.conf, or the unit's Limit lines)"
            )
        };
        let mut lines = Vec::new();
        if let Err(why) = &self.locked {
            lines.push(warning(
                "memory is not locked, so a turn may wait for a page",
                why,
                "memlock unlimited",
            ));
        }
        if let Err(why) = &self.core {
            lines.push(format!("the worker wanders between cores: {why}"));
        }
        if let Err(why) = &self.fifo {
            lines.push(warning(
                "no real-time priority, so ordinary work may hold up a turn",
                why,
                "rtprio 40",
            ));
        }
        lines
    }
}

/// Keeps the calling thread on the last of its cores, where interrupts are rarest.
fn pin() -> Result<Option<usize>, String> {
    let allowed = sched_getaffinity(None).map_err(|error| format!("{error}"))?;
    let Some(last) = (0..CpuSet::MAX_CPU).rev().find(|&core| allowed.is_set(core)) else { return Ok(None) };
    if allowed.count() < 2 {
        return Ok(None);
    }
    let mut one = CpuSet::new();
    one.set(last);
    sched_setaffinity(None, &one).map_err(|error| format!("{error}"))?;
    Ok(Some(last))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a thread of its own: what is granted stays with it.
    #[test]
    fn a_pinned_thread_has_one_core() {
        let cores = std::thread::spawn(|| {
            let before = sched_getaffinity(None).expect("its cores").count();
            let core = pin().expect("a thread may choose among its cores");
            assert_eq!(core.is_some(), before > 1);
            sched_getaffinity(None).expect("its cores").count()
        });
        assert_eq!(cores.join().expect("it ended"), 1);
    }

    #[test]
    fn a_refusal_says_what_to_do() {
        let no = || Err(String::from("Operation not permitted"));
        let lines = Granted { fifo: no(), core: Ok(Some(1)), locked: Ok(()) }.refusals();
        assert!(matches!(&lines[..], [line] if line.contains("rtprio 40") && line.contains("not permitted")));
        assert_eq!(
            Granted { fifo: no(), core: Err(String::new()), locked: Err(String::new()) }.refusals().len(),
            3
        );
    }
}
