//! Errors of recordings and of their tables.

use meniscus_data::motion::MotionError;
use meniscus_data::profiles::ProfileError;
use std::path::PathBuf;
use thiserror::Error;

/// Fault of one table: profiles, gauges, peak heights or poses.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TableError {
    /// A line is no profile.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// There is no row.
    #[error("it is empty; give one row for each frame")]
    Empty,
    /// The time from the first to the last frame cannot be used.
    #[error("it spans {frames} frames; {} to {} can be used", .range.0, .range.1)]
    Span {
        /// Frames from the first to the last row.
        frames: usize,
        /// Fewest and most frames.
        range: (usize, usize),
    },
    /// A column's name does not say what it holds, in which unit.
    #[error("'{name}': {why}; a heading is {example}")]
    Heading {
        /// Name of the column.
        name: String,
        /// Fault.
        why: String,
        /// Heading that would do.
        example: &'static str,
    },
    /// Rows do not follow one another evenly.
    #[error(
        "its rows are not even: a step of {step_s:.4} s where the mean is {mean_s:.4} s; leave the fields of a missing row empty"
    )]
    Uneven {
        /// Step, s.
        step_s: f64,
        /// Mean step, s.
        mean_s: f64,
    },
    /// A line does not have the expected columns.
    #[error("line {line}: expected '{expected}', found '{found}'")]
    Columns {
        /// Line, from 1.
        line: usize,
        /// Columns of the table.
        expected: &'static str,
        /// The line.
        found: String,
    },
    /// A number is not finite, or times do not increase.
    #[error("line {line}: '{found}' is not finite, or its time does not come after the last")]
    Sequence {
        /// Line, from 1.
        line: usize,
        /// The line.
        found: String,
    },
    /// A number is not finite.
    #[error("line {line}: '{found}' is not finite")]
    NotFinite {
        /// Line, from 1.
        line: usize,
        /// The line.
        found: String,
    },
    /// The table is too short.
    #[error("{rows} {unit}; at least {least} are needed")]
    TooShort {
        /// Rows of the table.
        rows: usize,
        /// Name of a row, plural.
        unit: &'static str,
        /// Fewest rows.
        least: usize,
    },
    /// Rows follow one another too fast or too slowly.
    #[error("{interval_s:.4} s between rows; {} to {} s can be used", .range_s.0, .range_s.1)]
    Interval {
        /// Mean interval, s.
        interval_s: f64,
        /// Shortest and longest interval, s.
        range_s: (f64, f64),
    },
}

/// Reason for which one recording cannot be used.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// A file cannot be read.
    #[error("{}: {cause}", .path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// A table has a fault.
    #[error("{file}: {fault}")]
    Table {
        /// File.
        file: String,
        /// Fault.
        fault: TableError,
    },
    /// The motion file has a fault.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The motion starts after the recording ends.
    #[error(
        "{}: it starts at {starts_s:.2} s, after the end of the recording at {ends_s:.2} s: its time has to start with \
         the recording's first frame", .path.display()
    )]
    MotionStartsLate {
        /// Motion file.
        path: PathBuf,
        /// Start of the motion, s.
        starts_s: f64,
        /// End of the recording, s.
        ends_s: f64,
    },
    /// The motion ends while the glass moves and the recording goes on.
    #[error(
        "{recording}: the motion ends at {motion_s:.2} s while the glass moves, the recording at {recording_s:.2} s: give \
         both over the same time and on the same clock"
    )]
    MotionEndsEarly {
        /// Recording.
        recording: String,
        /// End of the motion, s.
        motion_s: f64,
        /// End of the recording, s.
        recording_s: f64,
    },
    /// A channel never changes.
    #[error("{recording}: the {channel} never changes, not even by noise: is this a measurement?")]
    Constant {
        /// Recording.
        recording: String,
        /// Channel.
        channel: &'static str,
    },
    /// A channel is missing in most frames.
    #[error(
        "{recording}: the {channel} is missing in most frames: {seen} of {frames} hold it, a third is needed"
    )]
    HardlySeen {
        /// Recording.
        recording: String,
        /// Channel.
        channel: &'static str,
        /// Frames that hold the channel.
        seen: usize,
        /// All frames.
        frames: usize,
    },
    /// The glass moves before the noise can be learnt.
    #[error(
        "{recording}: the glass rests for only {frames} frames at the start; {least} are needed to learn the noise: \
         begin the recording half a second before the motion"
    )]
    NoRest {
        /// Recording.
        recording: String,
        /// Frames before the motion.
        frames: usize,
        /// Fewest frames.
        least: usize,
    },
    /// The glass never moves.
    #[error("{recording}: the glass never moves; a motion is needed to see any effect")]
    NoMotion {
        /// Recording.
        recording: String,
    },
    /// The camera sees the glass move at another time than the motion file.
    #[error(
        "{recording}: the camera shows the glass move {:.2} s {} than its motion file: give both on the same clock, from the \
         first frame on", .late_s.abs(), direction(.late_s)
    )]
    OtherClock {
        /// Recording.
        recording: String,
        /// Time by which the camera is later, s.
        late_s: f64,
    },
}

/// Keys that a setup has to have.
const SETUP_KEYS: &str = "radius_m, fill_m, density_kg_m3 and viscosity_pa_s";

/// Reason for which a folder of recordings cannot be used.
#[derive(Debug, Error)]
pub enum LoadError {
    /// The setup cannot be read.
    #[error("{}: {cause}; write it with {SETUP_KEYS}", .path.display())]
    ReadSetup {
        /// File.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// The setup has a fault.
    #[error("{} is not a setup: {fault}; it needs {SETUP_KEYS}", .path.display())]
    Setup {
        /// File.
        path: PathBuf,
        /// Fault.
        fault: String,
    },
    /// A number of the setup is out of range.
    #[error("{}: {name} = {value} is out of range: {} to {}", .path.display(), .range.0, .range.1)]
    OutOfRange {
        /// File.
        path: PathBuf,
        /// Name of the number.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest and largest value.
        range: (f64, f64),
    },
    /// The folder cannot be listed.
    #[error("{}: {cause}", .path.display())]
    List {
        /// Folder.
        path: PathBuf,
        /// Error of the operating system.
        cause: std::io::Error,
    },
    /// No recording of the folder can be used.
    #[error("no recording in {} can be used: {}", .path.display(), reasons(.left_out))]
    NoRecording {
        /// Folder.
        path: PathBuf,
        /// Recordings that were left out.
        left_out: Vec<RecordingError>,
    },
    /// There is no setup in the folder of references, nor in a folder of it.
    #[error("{}: no setup.toml in it, nor in a folder of it; write one with {SETUP_KEYS}", .path.display())]
    NoReferences {
        /// Folder.
        path: PathBuf,
    },
}

/// Returns why recordings were left out, in one line.
fn reasons(left_out: &[RecordingError]) -> String {
    if left_out.is_empty() {
        return String::from(
            "there is no NAME.profile.csv, NAME.gauges.csv or NAME.peak.csv in it (`meniscus record --out DIR/NAME.profile.csv` writes one)",
        );
    }
    left_out.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Returns the word for the sign of a delay.
fn direction(late_s: &f64) -> &'static str {
    if *late_s > 0.0 { "later" } else { "earlier" }
}
