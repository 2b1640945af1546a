//! Rights to run in real time: what this user may do, and the attempt to do it.

use crate::host::prelude::*;
use rustix::process::{Resource, getrlimit};
use thread_priority::ThreadPriority;
use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};

/// Priority of the camera's thread, of 1 to 99: above ordinary work, below the kernel's own threads.
pub const PRIORITY: u8 = 40;

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
