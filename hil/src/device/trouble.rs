//! The list of what can go wrong with the device as a whole, numbered from 1 in its order.
//!
//! Troubles of a stream begin a second after its first start, and go when they are cured: by the named
//! action or a stronger one.

use crate::fault_list::FaultKind;

/// Action that ends a trouble, from the weakest action to the strongest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cure {
    /// CLEAR_FEATURE(ENDPOINT_HALT).
    ClearHalt,
    /// A new commit.
    Commit,
    /// The hardware monitor's restart.
    Restart,
    /// A reset of the port; the restart command is not heard.
    Reset,
    /// Somebody plugs the camera in again, 15 s after the trouble began; nothing else is heard.
    Replug,
    /// Nothing.
    Never,
}

/// When the camera is unplugged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// At the first control request.
    Open,
    /// At the first command to the hardware monitor.
    Calibration,
    /// At the first probe.
    Probe,
    /// At the first commit.
    Commit,
    /// At the first clear-halt.
    Start,
    /// A second into the stream.
    Stream,
}

/// As what the camera comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Back {
    /// As it was, 2 s later.
    Same,
    /// Not at all.
    Never,
    /// On a USB 2 link, and as it was when it is plugged in once more, 5 s later.
    Usb2,
    /// In recovery.
    Recovery,
}

/// Failure of a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Damaged on the wire.
    Error,
    /// The endpoint is halted, until clear-halt.
    Stall,
    /// More bytes than requested.
    Overflow,
    /// Its time is up.
    TimedOut,
    /// Cancelled by nobody.
    Cancelled,
}

/// Misbehaviour of the device.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "each is described in TROUBLES")]
pub enum Trouble {
    Absent,
    Denied(u32),
    Busy(u32),
    OpenRace,
    Usb2,
    Recovery,
    OldFirmware,
    CutDescriptors,
    ZeroDescriptor,
    SilentDescriptors,
    NoDepth,
    NoInfrared,
    NoRate,
    OldGuid,
    NoUnit,
    MonitorCut,
    MonitorLength,
    MonitorEcho,
    MonitorRefuses(i32, u32),
    MonitorStalls(u32),
    MonitorSilent,
    TableCrc,
    TableCut,
    TableOther,
    TableWild,
    NoList,
    AdvancedOff,
    UnitStuck,
    ProbeStalls(u32),
    ProbeSilent,
    ProbeCut,
    ProbeFormat,
    ProbeInterval(u32),
    ProbeSize,
    CommitStalls(u32),
    Unplug(At, Back),
    Transfer(Ending, u32),
    Quiet(Cure),
    QuietInfrared(Cure),
    Frozen(Cure),
    Erring(Cure),
    Torn(Cure),
    ClockReset,
    Wire(FaultKind),
    InterruptStalls,
    InterruptNoise,
    InterruptError(u8),
    InterruptDead,
    DrainStuck,
    NoMemory,
    ClearHaltRefused,
    Apart(Cure),
    OtherCamera,
}

/// Every trouble: its name, what it is, what it does. Its number is its place, from 1.
pub const TROUBLES: &[(&str, Trouble, &str)] = &[
    ("absent", Trouble::Absent, "no camera is connected"),
    ("denied", Trouble::Denied(u32::MAX), "the user may not open it"),
    ("busy", Trouble::Busy(u32::MAX), "another program holds it"),
    ("busy-twice", Trouble::Busy(2), "the kernel's driver lets go at the third claim"),
    ("open-race", Trouble::OpenRace, "the first open fails, as in a race with enumeration"),
    ("usb2", Trouble::Usb2, "the link is USB 2"),
    ("recovery", Trouble::Recovery, "the firmware did not start"),
    ("old-firmware", Trouble::OldFirmware, "firmware 5.5.8.0"),
    ("cut-descriptors", Trouble::CutDescriptors, "the configuration ends in the middle of a descriptor"),
    ("zero-descriptor", Trouble::ZeroDescriptor, "a descriptor of length 0"),
    ("silent-descriptors", Trouble::SilentDescriptors, "the configuration is never sent"),
    ("no-depth", Trouble::NoDepth, "no format is Z16"),
    ("no-infrared", Trouble::NoInfrared, "no format is Y8"),
    ("no-rate", Trouble::NoRate, "no mode has 60 Hz"),
    ("old-guid", Trouble::OldGuid, "depth is called D16, as by old firmware"),
    ("no-unit", Trouble::NoUnit, "no extension unit"),
    ("monitor-cut", Trouble::MonitorCut, "the hardware monitor's messages have 1000 bytes"),
    ("monitor-length", Trouble::MonitorLength, "they announce 2000 bytes"),
    ("monitor-echo", Trouble::MonitorEcho, "they answer another command"),
    (
        "monitor-not-ready",
        Trouble::MonitorRefuses(-7, u32::MAX),
        "they say that the camera is not ready, for ever",
    ),
    ("monitor-slow", Trouble::MonitorRefuses(-7, 5), "they say so five times"),
    ("monitor-refuses", Trouble::MonitorRefuses(-1, u32::MAX), "they say that the command is wrong"),
    ("monitor-stalls", Trouble::MonitorStalls(u32::MAX), "the hardware monitor stalls, for ever"),
    ("monitor-stalls-twice", Trouble::MonitorStalls(2), "it stalls twice"),
    ("monitor-silent", Trouble::MonitorSilent, "it never answers"),
    ("table-crc", Trouble::TableCrc, "the calibration table's CRC does not fit"),
    ("table-cut", Trouble::TableCut, "the calibration table is short"),
    ("table-other", Trouble::TableOther, "another table comes"),
    ("table-wild", Trouble::TableWild, "the intrinsics are no numbers"),
    ("no-list", Trouble::NoList, "the list of intrinsics is missing"),
    ("advanced-off", Trouble::AdvancedOff, "the advanced mode is off: the depth unit is 1 mm"),
    ("unit-stuck", Trouble::UnitStuck, "the depth unit cannot be changed"),
    ("probe-stalls", Trouble::ProbeStalls(u32::MAX), "the probe stalls, for ever"),
    ("probe-stalls-twice", Trouble::ProbeStalls(2), "the probe stalls twice"),
    ("probe-silent", Trouble::ProbeSilent, "the probe is never answered"),
    ("probe-cut", Trouble::ProbeCut, "the probe's answer has 26 bytes"),
    ("probe-format", Trouble::ProbeFormat, "it has another format"),
    ("probe-interval", Trouble::ProbeInterval(u32::MAX), "it has 30 Hz"),
    ("probe-interval-once", Trouble::ProbeInterval(1), "it has 30 Hz, the first time"),
    ("probe-size", Trouble::ProbeSize, "it has another frame size"),
    ("commit-stalls", Trouble::CommitStalls(u32::MAX), "the commit stalls, for ever"),
    ("commit-stalls-once", Trouble::CommitStalls(1), "the commit stalls once"),
    ("unplug-open", Trouble::Unplug(At::Open, Back::Same), "unplugged at the first request, back in 2 s"),
    (
        "unplug-calibration",
        Trouble::Unplug(At::Calibration, Back::Same),
        "unplugged while the calibration is read",
    ),
    ("unplug-probe", Trouble::Unplug(At::Probe, Back::Same), "unplugged at the probe"),
    ("unplug-commit", Trouble::Unplug(At::Commit, Back::Same), "unplugged at the commit"),
    ("unplug-start", Trouble::Unplug(At::Start, Back::Same), "unplugged at the start"),
    ("unplug", Trouble::Unplug(At::Stream, Back::Same), "unplugged while it streams, back in 2 s"),
    ("unplug-for-good", Trouble::Unplug(At::Stream, Back::Never), "unplugged while it streams, never back"),
    ("unplug-usb2", Trouble::Unplug(At::Stream, Back::Usb2), "back at USB 2, and at USB 3 after 5 s more"),
    ("unplug-recovery", Trouble::Unplug(At::Stream, Back::Recovery), "back in recovery"),
    ("transfer-error", Trouble::Transfer(Ending::Error, 1), "a transfer is damaged"),
    ("transfer-errors", Trouble::Transfer(Ending::Error, 8), "eight transfers are damaged"),
    ("transfer-stall", Trouble::Transfer(Ending::Stall, 1), "the endpoint halts"),
    ("transfer-overflow", Trouble::Transfer(Ending::Overflow, 1), "a transfer overflows"),
    ("transfer-overflows", Trouble::Transfer(Ending::Overflow, 8), "eight transfers overflow"),
    ("transfer-timeout", Trouble::Transfer(Ending::TimedOut, 1), "a transfer's time is up"),
    ("transfer-cancelled", Trouble::Transfer(Ending::Cancelled, 1), "a transfer is cancelled by nobody"),
    ("quiet-halt", Trouble::Quiet(Cure::ClearHalt), "no frames, until clear-halt"),
    ("quiet-commit", Trouble::Quiet(Cure::Commit), "no frames, until a new commit"),
    ("quiet-restart", Trouble::Quiet(Cure::Restart), "no frames, until the camera restarts"),
    ("quiet-reset", Trouble::Quiet(Cure::Reset), "no frames and no restart, until the port is reset"),
    ("quiet-replug", Trouble::Quiet(Cure::Replug), "no frames, until it is plugged in again"),
    ("quiet-for-good", Trouble::Quiet(Cure::Never), "no frames any more"),
    ("quiet-infrared", Trouble::QuietInfrared(Cure::Commit), "no infrared frames, until a new commit"),
    ("frozen", Trouble::Frozen(Cure::Commit), "the same frame again and again, until a new commit"),
    ("frozen-restart", Trouble::Frozen(Cure::Restart), "the same frame again and again, until a restart"),
    ("erring", Trouble::Erring(Cure::Commit), "the error bit in every frame, until a new commit"),
    ("torn", Trouble::Torn(Cure::ClearHalt), "every frame is cut, until clear-halt"),
    ("torn-for-good", Trouble::Torn(Cure::Never), "every frame is cut"),
    ("clock-reset", Trouble::ClockReset, "the camera's clock and counter begin anew"),
    ("wire-drop", Trouble::Wire(FaultKind::Drop), "a payload never comes"),
    ("wire-tear", Trouble::Wire(FaultKind::Tear), "a payload is cut"),
    ("wire-late", Trouble::Wire(FaultKind::Late), "a payload comes 40 ms late"),
    ("wire-fid", Trouble::Wire(FaultKind::Fid), "a wrong frame identifier"),
    ("wire-eof", Trouble::Wire(FaultKind::Eof), "no end of frame"),
    ("wire-err", Trouble::Wire(FaultKind::Err), "the error bit"),
    ("wire-length0", Trouble::Wire(FaultKind::Length0), "a header of length 0"),
    ("wire-length2", Trouble::Wire(FaultKind::Length2), "a header of length 2"),
    ("wire-length200", Trouble::Wire(FaultKind::Length200), "a header longer than its payload"),
    ("wire-duplicate", Trouble::Wire(FaultKind::Duplicate), "a payload comes twice"),
    ("wire-gap", Trouble::Wire(FaultKind::Gap), "the counter skips"),
    ("wire-split", Trouble::Wire(FaultKind::Split), "a frame in four payloads"),
    ("wire-noinfrared", Trouble::Wire(FaultKind::NoInfrared), "no infrared payload for a depth payload"),
    ("wire-overlong", Trouble::Wire(FaultKind::Overlong), "64 pixels too many"),
    ("wire-empty", Trouble::Wire(FaultKind::Empty), "a payload of no byte"),
    ("interrupt-stalls", Trouble::InterruptStalls, "the interrupt endpoint stalls at every read"),
    ("interrupt-noise", Trouble::InterruptNoise, "status packets without sense"),
    ("interrupt-hot", Trouble::InterruptError(1), "the laser is hot"),
    (
        "interrupt-infrared",
        Trouble::InterruptError(23),
        "the infrared stream fails, and says so, until a new commit",
    ),
    ("interrupt-dead", Trouble::InterruptDead, "the interrupt endpoint is missing"),
    (
        "drain-stuck",
        Trouble::DrainStuck,
        "quiet, and cancelled transfers do not come back until it is closed",
    ),
    ("no-memory", Trouble::NoMemory, "the system has no memory for transfers"),
    ("clear-halt-refused", Trouble::ClearHaltRefused, "quiet until a restart, and clear-halt fails"),
    ("apart", Trouble::Apart(Cure::Commit), "depth and infrared of different instants, until a new commit"),
    ("interrupt-off", Trouble::InterruptError(2), "the laser is too hot and was turned off"),
    ("interrupt-overflow", Trouble::InterruptError(12), "a buffer of the camera overflowed"),
    ("other-camera", Trouble::OtherCamera, "an L515 and no D435 is on the bus"),
];

impl Trouble {
    /// By name or number.
    #[must_use]
    pub fn find(text: &str) -> Option<Self> {
        let number = text.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        let by_number = number.and_then(|at| TROUBLES.get(at));
        by_number.or_else(|| TROUBLES.iter().find(|(name, ..)| *name == text)).map(|(_, trouble, _)| *trouble)
    }
}
