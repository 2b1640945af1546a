//! Facts of the edge board's steps, as `guest/board` prints them.
//!
//! A fact that is absent is `None`, so a step that did not run, or ended with an error, meets no target. A fact of
//! another type than stated here is an error that names the step.

use super::super::Failure;
use super::super::log::Log;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

/// Returns the facts of `step`; those of a step that did not run are all absent.
pub(super) fn step<T: DeserializeOwned + Default>(log: &Log, step: &str) -> Result<T, Failure> {
    match log.of(step) {
        None | Some(Value::Null) => Ok(T::default()),
        Some(facts) => serde_json::from_value(facts.clone()).map_err(|error| {
            format!("the facts of step `{step}` have another form: {error}: {facts}").into()
        }),
    }
}

/// Returns the number, or NaN, which meets no limit.
pub(super) fn or_nan(number: Option<f64>) -> f64 {
    number.unwrap_or(f64::NAN)
}

/// Owner, group and mode of the camera's device node.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Node {
    owner: Option<String>,
    group: Option<String>,
    mode: Option<String>,
}

impl Node {
    /// Whether the node is as the package's udev rule makes it.
    pub(super) fn by_the_rule(&self) -> bool {
        is(&self.owner, "root") && is(&self.group, "plugdev") && is(&self.mode, "0660")
    }
}

/// The flash slot that boots, with the hash of its content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
pub(super) struct Slot {
    active: Option<String>,
    pub(super) sha256: Option<String>,
}

impl Slot {
    /// Whether the slot holds a model, and `other` is the same slot with the same one.
    pub(super) fn same_as(&self, other: &Self) -> bool {
        self.sha256.as_ref().is_some_and(|sum| sum.len() == 64) && self == other
    }
}

/// Exit status of a program.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Ended {
    exit: Option<i32>,
}

impl Ended {
    pub(super) fn well(&self) -> bool {
        self.exit == Some(0)
    }
}

/// Facts of the board before the installation.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Before {
    /// Whether the service's user exists.
    pub(super) user: Option<bool>,
    pub(super) node: Option<Node>,
}

/// Facts of `dpkg --install` and of the first start.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Install {
    pub(super) dpkg: Ended,
    pub(super) enabled: Option<String>,
    pub(super) restarts: Option<u64>,
    pub(super) to_tracking_s: Option<f64>,
    pub(super) node: Option<Node>,
    pub(super) slot: Slot,
}

/// Rights of the service's process.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ProcessRights {
    pub(super) user: Option<String>,
    pub(super) group: Option<String>,
    pub(super) capabilities: Option<String>,
    pub(super) no_new_privileges: Option<String>,
    pub(super) locked_kib: Option<u64>,
    pub(super) fifo_priorities: Vec<u32>,
}

/// Facts of the rights that the service was given and refused.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Rights {
    pub(super) rights: ProcessRights,
    pub(super) refused: Option<Vec<String>>,
    pub(super) watchdog: Option<String>,
}

/// Facts of a plug that was pulled and put in again.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Replug {
    pub(super) noticed: Option<bool>,
    pub(super) same_process: Option<bool>,
    pub(super) restarted: Option<u64>,
    pub(super) node: Option<Node>,
    pub(super) to_tracking_s: Option<f64>,
}

/// Facts of a process that was killed, or stopped until its watchdog ended it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Restart {
    pub(super) restarts: Option<u64>,
    pub(super) by_watchdog: Option<bool>,
    pub(super) to_tracking_s: Option<f64>,
}

/// Facts of a journal into which more was written than it may hold.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Journal {
    pub(super) written_bytes: Option<f64>,
    pub(super) kept_bytes: Option<f64>,
    pub(super) tracks_on: Option<bool>,
}

/// Facts of the installation of the next version over a flashed model and an edited profile.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Upgrade {
    /// Versions.
    pub(super) before: Option<String>,
    pub(super) behind: Option<String>,
    pub(super) program: Option<String>,
    pub(super) enabled: Option<String>,
    pub(super) slot_before: Slot,
    pub(super) slot: Slot,
    pub(super) profile_kept: Option<bool>,
}

/// Facts of an upgrade of a service that was switched off.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Disabled {
    pub(super) enabled: Option<String>,
    pub(super) active: Option<String>,
}

/// Facts of the board at the end of a boot.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Rest {
    pub(super) slot: Slot,
    failed: Option<String>,
    kernel_complaints: Option<Vec<Value>>,
}

impl Rest {
    /// Whether no unit failed and the kernel has logged no fault.
    pub(super) fn quiet(&self) -> bool {
        is(&self.failed, "") && self.kernel_complaints.as_ref().is_some_and(Vec::is_empty)
    }
}

/// Facts of the second boot, which nobody touched.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct PowerOn {
    #[serde(flatten)]
    pub(super) rest: Rest,
    /// Times since the kernel's first moment.
    pub(super) tracked_s: Option<f64>,
    pub(super) systemd_s: Option<f64>,
    pub(super) started_s: Option<f64>,
    pub(super) restarts: Option<u64>,
    pub(super) state: Option<String>,
    pub(super) node: Option<Node>,
}

/// Facts of the removal of the package.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Remove {
    pub(super) removed: Ended,
    pub(super) purged: Ended,
    pub(super) active: Option<String>,
    pub(super) slot_kept: Slot,
    /// Files of the package that are still there.
    pub(super) left: Option<Vec<String>>,
}

/// Whether a fact is there and has this value.
pub(super) fn is(fact: &Option<String>, wanted: &str) -> bool {
    fact.as_deref() == Some(wanted)
}
