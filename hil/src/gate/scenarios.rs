//! The scenarios of the gate, in the order of their dependence, and what must come of each.

/// Required outcome of a scenario.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Must {
    /// All five interfaces at this speed, in Mbit/s.
    Enumerate(&'static str),
    /// The doctor reads calibration, unit, speed and frame rate.
    Doctor,
    /// A second of both streams in a file.
    Record,
    /// 60 frames a second for these seconds, nothing lost.
    Stream(f64),
    /// The surface and the field within this share of what the same frames come to in process.
    Track(f64),
    /// The tag is seen in this share of the images, and its motion used; the turns are as without it.
    Tag(f64),
    /// The tag is looked for in every image and is in none; the turns are as without the search.
    NoTag,
    /// Tracking to the end and no rung taken; what was lost is counted under these keys, each at least once.
    /// A key is a path in the facts; `|` separates keys of which one is enough.
    Ride(&'static [&'static str]),
    /// The highest rung that is taken (0 requeue, 1 renegotiate, 2 restart, 3 reset, 4 re-plug), and
    /// tracking at the end.
    Recover(usize),
    /// The service is ready and tracks within this many seconds, and gives a sign of life every two.
    Service(f64),
    /// A model is flashed twice while it streams, without a gap, and the slot that is whole starts.
    Flash,
    /// Healthy beside a program that never rests.
    Busy,
    /// No run, and these words.
    Refuse(&'static [&'static str]),
    /// The same without a remedy of its own.
    Fail(&'static [&'static str]),
}

/// One scenario.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scenario {
    /// Its chapter: 1 enumerate, 2 calibrate, 3 stream, 4 track, 5 faults, 6 recovery, 8 the machine.
    pub(crate) chapter: u8,
    /// For the guest: `NAME[:TROUBLE[:SECONDS]]`.
    pub(crate) plan: &'static str,
    /// Its required outcome.
    pub(crate) must: Must,
}

const fn scenario(chapter: u8, plan: &'static str, must: Must) -> Scenario {
    Scenario { chapter, plan, must }
}

/// The gate's.
pub(crate) const GATE: &[Scenario] = &[
    scenario(1, "enumerate", Must::Enumerate("5000")),
    scenario(1, "enumerate:usb2", Must::Enumerate("480")),
    scenario(2, "doctor", Must::Doctor),
    scenario(3, "record::1", Must::Record),
    scenario(3, "run::60", Must::Stream(60.0)),
    scenario(4, "track::6", Must::Track(0.05)),
    scenario(4, "tag::4", Must::Tag(0.95)),
    scenario(4, "tag-away::2", Must::NoTag),
    // Rows of the fault table that the kernel or libusb shows.
    scenario(5, "run:transfer-stall:2.5", Must::Recover(0)),
    scenario(5, "run:transfer-error:1.5", Must::Ride(&["camera_health.errors"])),
    scenario(5, "run:transfer-errors:2.5", Must::Recover(1)),
    scenario(5, "run:transfer-overflow:1.5", Must::Ride(&["camera_health.overflows"])),
    scenario(5, "run:transfer-overflows:2.5", Must::Recover(1)),
    scenario(5, "run:quiet-halt:2.5", Must::Recover(0)),
    scenario(5, "run:quiet-commit:3.5", Must::Recover(1)),
    scenario(5, "run:frozen:3.5", Must::Recover(1)),
    scenario(5, "run:probe-stalls-twice:1.5", Must::Ride(&[])),
    scenario(5, "run:commit-stalls-once:1.5", Must::Ride(&[])),
    scenario(5, "run:monitor-silent", Must::Refuse(&["hardware monitor", "no answer in time"])),
    scenario(5, "run:recovery", Must::Refuse(&["in recovery", "rs-fw-update"])),
    // Rows that only the reader's parser can see: the transfer completes.
    scenario(5, "run:wire-tear:1.5", Must::Ride(&["losses.depth.short_frame|losses.infrared.short_frame"])),
    scenario(5, "run:wire-fid:1.5", Must::Ride(&["losses.depth.fid_repeated|losses.infrared.fid_repeated"])),
    scenario(5, "run:wire-eof:1.5", Must::Ride(&["losses.depth.eof_missing|losses.infrared.eof_missing"])),
    scenario(5, "run:wire-err:1.5", Must::Ride(&["losses.depth.error_bit|losses.infrared.error_bit"])),
    scenario(5, "run:wire-length0:1.5", Must::Ride(&["losses.depth.bad_header|losses.infrared.bad_header"])),
    scenario(5, "run:wire-length2:1.5", Must::Ride(&["losses.depth.bad_header|losses.infrared.bad_header"])),
    scenario(
        5,
        "run:wire-length200:1.5",
        Must::Ride(&["losses.depth.bad_header|losses.infrared.bad_header"]),
    ),
    scenario(5, "run:wire-split:1.5", Must::Ride(&[])),
    scenario(
        5,
        "run:wire-empty:1.5",
        Must::Ride(&["losses.depth.empty_payload|losses.infrared.empty_payload"]),
    ),
    // Unplugged at every step, and plugged in again.
    scenario(6, "run:unplug-open:1.5", Must::Ride(&[])),
    scenario(6, "run:unplug-calibration:1.5", Must::Ride(&[])),
    scenario(6, "run:unplug-probe:1.5", Must::Ride(&[])),
    scenario(6, "run:unplug-commit:1.5", Must::Ride(&[])),
    // The first sign is a damaged request, so the climb begins at the bottom; the restart finds it gone and back.
    scenario(6, "run:unplug-start:5", Must::Recover(2)),
    scenario(6, "run:unplug:5", Must::Recover(4)),
    scenario(6, "run:quiet-restart:12", Must::Recover(2)),
    scenario(6, "run:quiet-reset:9", Must::Recover(3)),
    scenario(7, "flash::3", Must::Flash),
    scenario(
        8,
        "full-disk::2",
        Must::Fail(&["/tmp/small", "ended behind", "which are kept", "its disk is full"]),
    ),
    scenario(8, "low-memory::2", Must::Refuse(&["no memory", "usbfs_memory_mb"])),
    scenario(8, "busy::2", Must::Busy),
    scenario(8, "service::4", Must::Service(2.0)),
];
