//! The simulated camera as a USB device: descriptors, control requests, payloads, troubles.
//!
//! It knows no transport: requests come in as setup packets with the time, payloads go out with theirs.
//! A front end (in process, or under a kernel) queues reads, asks for what is due, and tells of plugs.
//!
//! ```text
//! setup packet, time --control--> Reply          time --due--> Event { endpoint, time, bytes or ending }
//! ```

mod control;
mod descriptors;
mod firmware;
mod habits;
mod imposed;
mod replay;
mod scenery;
mod stream;
mod trouble;

pub use firmware::{COLOUR_INTRINSICS, COLOUR_LENS_M, COLOUR_PITCH_RAD, INTRINSICS, INTRINSICS_SMALL};
pub use habits::{ClockStep, Habits, Lag};
pub use replay::{ControlExchange, Replay};
pub use scenery::{Film, Scenery, TestCard};
pub use trouble::{At, Back, Cure, Ending, TROUBLES, Trouble};

use crate::camera::{Camera, CameraSettings};
use crate::fault_list::{FaultKind, FaultList, When};
use crate::faults::FaultInjector;
use firmware::Firmware;
use std::collections::{HashMap, HashSet};

/// Endpoints.
pub const DEPTH: u8 = 0x82;
/// Left infrared.
pub const INFRARED: u8 = 0x83;
/// Colour.
pub const COLOUR: u8 = 0x84;
/// Status packets.
pub const INTERRUPT: u8 = 0x87;

/// Shots from the first start of the streams to the beginning of a stream's trouble.
const STRIKE: u64 = 60;
/// Time between two shots, microseconds: of 60 Hz, in thirds.
const SHOT_US: [u64; 3] = [16_667, 16_667, 16_666];
/// Device time of the middle of the first exposure, microseconds.
pub const FIRST_SHOT_US: u64 = 1_000_000;

/// Device time of the middle of the first exposure after a restart of the clock, microseconds.
const AFTER_POWER_UP_US: i64 = 5_000;

/// State of the device as the bus shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen {
    /// idVendor.
    pub vendor: u16,
    /// idProduct.
    pub product: u16,
    /// Serial number string.
    pub serial: String,
    /// Whether the link is USB 2.
    pub usb2: bool,
}

/// Answer to a control request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// Bytes.
    Data(Vec<u8>),
    /// Taken.
    Done,
    /// Refused.
    Stall,
    /// No answer, ever.
    Silence,
    /// The device is not there.
    Gone,
}

/// Outcome of a queued read.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Its endpoint.
    pub endpoint: u8,
    /// When.
    pub at_us: u64,
    /// Bytes, or another ending.
    pub what: Result<Vec<u8>, Ending>,
}

/// A trouble's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    Ahead,
    Struck,
    Over,
}

/// The device.
pub struct Device {
    scenery: Box<dyn Scenery>,
    trouble: Option<Trouble>,
    life: Life,
    struck_us: u64,
    /// Remaining strikes of the trouble.
    left: u32,
    firmware: Firmware,
    replay: Option<Replay>,
    wire: FaultInjector<Camera>,
    /// Absent from, until: microseconds.
    away: Vec<(u64, u64)>,
    as_what: Back,
    back_us: u64,
    probes: HashMap<u8, Vec<u8>>,
    committed: HashSet<u8>,
    started_us: Option<u64>,
    shot: u64,
    shots_of_start: u64,
    due: Vec<Event>,
    last: [Vec<u8>; 2],
    /// A colour image without anything in it, once it is wanted.
    even: Vec<u8>,
    halted: HashSet<u8>,
    /// Device time less that of a camera that was never restarted, microseconds.
    clock_ahead_us: i64,
    habits: Habits,
    /// Middle of each exposure on the bus's clock, microseconds.
    exposures: Vec<u64>,
}

impl std::fmt::Debug for Device {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Device")
            .field("trouble", &self.trouble)
            .field("shot", &self.shot)
            .finish_non_exhaustive()
    }
}

impl Device {
    /// A camera before `scenery`, with at most one trouble and with faults on its wire.
    #[must_use]
    pub fn new(
        scenery: Box<dyn Scenery>,
        trouble: Option<Trouble>,
        mut faults: FaultList,
        seed: u64,
    ) -> Self {
        if let Some(Trouble::Wire(kind)) = trouble {
            // The duplicate of a rare shot, and so on: one shot of a second.
            faults.0.push((kind, When::Shot(STRIKE)));
            faults.0.extend((kind == FaultKind::Late).then_some((kind, When::Shot(STRIKE + 10))));
        }
        let left = match trouble {
            Some(
                Trouble::Denied(n)
                | Trouble::Busy(n)
                | Trouble::MonitorStalls(n)
                | Trouble::ProbeStalls(n)
                | Trouble::ProbeInterval(n)
                | Trouble::CommitStalls(n)
                | Trouble::Transfer(_, n),
            ) => n,
            _ => 1,
        };
        let usb2 = trouble == Some(Trouble::Usb2);
        Self {
            scenery,
            trouble,
            life: Life::Ahead,
            struck_us: 0,
            left,
            firmware: Firmware::new(trouble),
            replay: None,
            wire: wire(usb2, faults, seed),
            away: if trouble == Some(Trouble::Absent) { vec![(0, u64::MAX)] } else { vec![] },
            as_what: Back::Same,
            back_us: 0,
            probes: HashMap::new(),
            committed: HashSet::new(),
            started_us: None,
            shot: 0,
            shots_of_start: 0,
            due: Vec::new(),
            last: [vec![], vec![]],
            even: vec![],
            halted: HashSet::new(),
            clock_ahead_us: 0,
            habits: Habits::default(),
            exposures: Vec::new(),
        }
    }

    /// The same camera with other habits.
    #[must_use]
    pub fn with_habits(mut self, habits: Habits) -> Self {
        self.habits = habits;
        self.clock_ahead_us = i64::from(habits.up_us);
        self
    }

    /// A camera that says what another one said.
    #[must_use]
    pub fn replaying(replay: Replay) -> Self {
        let mut device = Self::new(Box::new(TestCard::default()), None, FaultList::default(), 1);
        device.replay = Some(replay);
        device
    }

    /// Returns the device's state on the bus; `None` while it is unplugged.
    #[must_use]
    pub fn seen(&self, now_us: u64) -> Option<Seen> {
        if self.is_away(now_us) {
            return None;
        }
        let recovery = self.trouble == Some(Trouble::Recovery) || self.as_what == Back::Recovery;
        let seen = Seen {
            vendor: 0x8086,
            product: match self.trouble {
                _ if recovery => 0x0adb,
                Some(Trouble::OtherCamera) => 0x0b64,
                _ => 0x0b07,
            },
            serial: "839213061234".into(),
            usb2: self.usb2(now_us),
        };
        match &self.replay {
            Some(replay) => Some(Seen {
                vendor: replay.vendor,
                product: replay.product,
                serial: replay.serial.clone(),
                usb2: replay.usb2,
            }),
            None => Some(seen),
        }
    }

    fn usb2(&self, now_us: u64) -> bool {
        let back_slow = self.as_what == Back::Usb2 && now_us < self.back_us + 5_000_000;
        self.trouble == Some(Trouble::Usb2) || back_slow
    }

    fn is_away(&self, now_us: u64) -> bool {
        self.away.iter().any(|(from, until)| (*from..*until).contains(&now_us))
    }

    /// When the device last left the bus before `now_us`, if ever: handles from before are dead.
    #[must_use]
    pub fn left_us(&self, now_us: u64) -> Option<u64> {
        self.away.iter().map(|(from, _)| *from).filter(|from| *from <= now_us).max()
    }

    /// Middle of the exposure of a shot on the bus's clock, microseconds: the truth, which no host gets; `None` for a shot
    /// that was not taken yet.
    #[must_use]
    pub fn exposed_us(&self, shot: u64) -> Option<u64> {
        self.exposures.get(usize::try_from(shot).ok()?).copied()
    }

    /// Which trouble it has.
    #[must_use]
    pub fn trouble(&self) -> Option<Trouble> {
        self.trouble
    }

    /// Whether the trouble may strike once more; counts it.
    pub fn strike(&mut self) -> bool {
        let strikes = self.left > 0;
        self.left = self.left.saturating_sub(u32::from(self.left != u32::MAX));
        strikes
    }

    /// Whether a stream's trouble has begun and is not cured.
    #[must_use]
    pub fn is_struck(&self) -> bool {
        self.life == Life::Struck
    }

    /// A reset of the port. `false` when the device does not hear it.
    pub fn reset(&mut self, now_us: u64) -> bool {
        if self.is_away(now_us) || (self.life == Life::Struck && self.cure_of() >= Some(Cure::Replug)) {
            return false;
        }
        self.cure(Cure::Reset);
        self.forget();
        true
    }

    fn leave(&mut self, from_us: u64, until_us: u64) {
        self.away.push((from_us, until_us));
        self.back_us = until_us;
        self.forget();
        if self.habits.clock_restarts {
            self.restart_clock();
        }
    }

    /// Lets clock and frame counter begin anew with the next shot.
    pub(super) fn restart_clock(&mut self) {
        let since_us = self.habits.since_first_us(shot_time_us(self.shot));
        self.clock_ahead_us = AFTER_POWER_UP_US - (FIRST_SHOT_US + since_us) as i64;
        self.wire.inner_mut().restart_counter();
    }

    fn unplug(&mut self, now_us: u64, back: Back) {
        self.life = Life::Over;
        self.as_what = back;
        let until_us = if back == Back::Never { u64::MAX } else { now_us + 2_000_000 };
        self.leave(now_us, until_us);
        if back == Back::Usb2 {
            self.away.push((until_us + 5_000_000, until_us + 5_500_000));
        }
    }

    /// Clears the state that a restart loses.
    fn forget(&mut self) {
        self.probes.clear();
        self.committed.clear();
        self.halted.clear();
        self.started_us = None;
        self.due.clear();
    }

    fn cure_of(&self) -> Option<Cure> {
        match self.trouble? {
            Trouble::Quiet(cure)
            | Trouble::QuietInfrared(cure)
            | Trouble::Frozen(cure)
            | Trouble::Erring(cure)
            | Trouble::Torn(cure)
            | Trouble::Apart(cure) => Some(cure),
            Trouble::InterruptError(23) => Some(Cure::Commit),
            Trouble::DrainStuck | Trouble::ClearHaltRefused => Some(Cure::Restart),
            _ => None,
        }
    }

    fn cure(&mut self, action: Cure) {
        if self.life == Life::Struck
            && self.cure_of().is_some_and(|cure| action >= cure && cure != Cure::Never)
        {
            self.life = Life::Over;
        }
    }
}

fn wire(usb2: bool, faults: FaultList, seed: u64) -> FaultInjector<Camera> {
    let (width, height) = if usb2 { (480, 270) } else { (640, 480) };
    let settings = CameraSettings { width, height, ..CameraSettings::default() };
    FaultInjector::new(Camera::new(settings), faults, seed)
}

/// Time from the first shot to another one, microseconds.
fn shot_time_us(shot: u64) -> u64 {
    let [a, b, c] = SHOT_US;
    shot / 3 * (a + b + c) + [0, a, a + b][(shot % 3) as usize]
}
