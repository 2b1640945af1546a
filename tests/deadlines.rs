//! Deadlines that see what never came: every frame that the camera took is in one account, whatever the host did meanwhile.
//!
//! What must have been counted is found without the ledger, from the end of each frame's turn. No test depends on the
//! machine's speed: a busy machine only moves frames from one account to another.

#[path = "support/running.rs"]
mod running;

use meniscus::blob::Model;
use meniscus::runtime::{DEADLINE_US, Estimator};
use meniscus::surface::{Config, Settings};
use meniscus_data::recording::Recording;
use meniscus_hil::FaultList;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::ledger::FrameCounts;
use meniscus_service::live::{Log, Worker};
use meniscus_service::sink::{LatestTurn, TurnRecord, TurnSink};
use meniscus_usb::link::link;
use meniscus_virtual::camera::{PAYLOAD_ROOM, SimulatedCamera};
use meniscus_virtual::render::SceneSettings;
use running::Running;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// One run at a time: each is a real-time program.
static ONE: Mutex<()> = Mutex::new(());

/// Time beyond the deadline from which on a frame was late by any reckoning, microseconds: a turn may end this much sooner
/// after its frame's arrival than another.
const CLEARLY_US: i64 = 10_000;

/// A frame that had a turn.
struct FrameTurn {
    /// End of its turn on the host's clock, microseconds.
    ended_us: i64,
    /// Its time on the camera's clock, microseconds.
    camera_us: i64,
}

/// Returns how many of `taken` frames had clearly no turn in time, by the end of each frame's turn and its camera time.
fn clearly_missed(taken: u64, turns: &[FrameTurn]) -> u64 {
    let delay_us = |turn: &FrameTurn| turn.ended_us - turn.camera_us;
    let Some(least_us) = turns.iter().map(delay_us).min() else { return taken };
    let limit_us = least_us + DEADLINE_US as i64 + CLEARLY_US;
    taken - turns.iter().filter(|turn| delay_us(turn) <= limit_us).count() as u64
}

/// Holds the accounts against the frames that the camera took and those that were clearly missed. Prints the share of the
/// latter that was counted, which must be 1.
fn all_are_counted(counts: &FrameCounts, taken: u64, missed: u64) {
    assert_eq!(counts.taken(), taken, "every frame has one account: {counts}");
    assert!((counts.over_s - taken as f64 / 60.0).abs() < 0.05, "{counts}");
    let counted = counts.missed();
    let share = if missed == 0 { 1.0 } else { counted.min(missed) as f64 / missed as f64 };
    println!("lost_frames_counted {share}: {missed} clearly missed; {counts}");
    assert!(counted >= missed, "{missed} frames were clearly missed: {counts}");
}

/// A sink that writes to a slow disk: every thirtieth turn it is kept waiting for `pause`.
struct SlowWriter {
    turns: u64,
    pause: Duration,
}

impl TurnSink for SlowWriter {
    fn accept(&mut self, _: &TurnRecord<'_>) {
        self.turns += 1;
        if self.turns.is_multiple_of(30) {
            std::thread::sleep(self.pause);
        }
    }
}

/// Runs `frames` frames of the simulated camera in real time before a worker with a slow writer; `spinning` threads keep the
/// machine busy.
fn worked(frames: u64, pause: Duration, spinning: usize) -> Log {
    let _turn = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let model = Model::load(&bytes).expect("the shipped model");
    let recording = Recording::from_bytes(Path::new("shipped"), meniscus_shipped::RECORDING)
        .expect("the shipped recording");
    let header = &model.header;
    let optics = Settings::for_glass(header.radius_m, header.fill_m, header.rim_m);
    let config = Config::new(optics).expect("a camera before the glass");
    let scene = SceneSettings { camera: optics, ..SceneSettings::default() };
    let camera = SimulatedCamera::new(&recording, scene, FaultList::default());
    let (camera_end, worker_end) = link(8, PAYLOAD_ROOM);
    let (stop, over) = (AtomicBool::new(false), AtomicBool::new(false));
    let (stop, over) = (&stop, &over);
    std::thread::scope(|scope| {
        for _ in 0..spinning {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        scope.spawn(move || camera.play(frames as usize, &camera_end, stop));
        let (latest, mut log) = (LatestTurn::default(), Log::for_frames(frames as usize));
        let (mut newest, mut writer) = (&latest, SlowWriter { turns: 0, pause });
        let mut sinks: [&mut dyn TurnSink; 3] = [&mut newest, &mut log, &mut writer];
        Worker::new(Estimator::new(&model), config).run(&worker_end, stop, &mut sinks);
        over.store(true, Ordering::Relaxed);
        let shown = latest.get().expect("turns were taken").frames;
        assert!(shown.taken() <= log.frames.taken(), "{shown} and {}", log.frames);
        if shown.taken() == log.frames.taken() {
            assert_eq!(shown, log.frames, "a viewer and the summary have the same accounts");
        }
        log
    })
}

/// Returns the end and the camera time of each frame's turn, microseconds.
fn turns_of(log: &Log) -> Vec<FrameTurn> {
    let Some(first) = log.turns.first() else { return Vec::new() };
    let with_frame = log.turns.iter().filter_map(|logged| logged.turn.stamp.map(|stamp| (logged, stamp)));
    with_frame
        .map(|(logged, stamp)| {
            let ended = logged.ended.saturating_duration_since(first.ended);
            FrameTurn { ended_us: ended.as_micros() as i64, camera_us: stamp.captured.0 as i64 }
        })
        .collect()
}

#[test]
fn frames_behind_a_slow_writer_are_counted() {
    let log = worked(300, Duration::from_millis(250), 0);
    let missed = clearly_missed(300, &turns_of(&log));
    assert!(missed >= 30, "a writer that stops for 15 frames has to cost some: {missed}, {}", log.frames);
    all_are_counted(&log.frames, 300, missed);
}

#[test]
fn frames_on_a_loaded_machine_are_counted() {
    let cores = std::thread::available_parallelism().map_or(2, usize::from);
    let log = worked(240, Duration::ZERO, 3 * cores);
    all_are_counted(&log.frames, 240, clearly_missed(240, &turns_of(&log)));
}

/// A folder of its own for each test.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("deadlines").join(name);
    let _old = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Returns the accounts of a report, which its checks must repeat.
fn accounts(report: &Value) -> FrameCounts {
    let deadlines = &report["deadlines"];
    let account = |name: &str| deadlines[name].as_u64().unwrap_or_else(|| panic!("{name}: {deadlines}"));
    let counts = FrameCounts {
        in_time: account("in_time"),
        late: account("late"),
        lost: account("lost"),
        never_handled: account("never_handled"),
        over_s: deadlines["over_s"].as_f64().expect("a span"),
    };
    let checks = report["checks"].as_array().expect("checks");
    let checks: BTreeMap<&str, f64> =
        checks.iter().filter_map(|check| Some((check["name"].as_str()?, check["value"].as_f64()?))).collect();
    assert_eq!(checks["deadline_misses"], counts.missed() as f64);
    assert_eq!(checks["frames_taken"], counts.taken() as f64);
    assert_eq!(checks["frames_lost"], counts.lost as f64);
    counts
}

/// Returns the end and the camera time of each frame's turn in a table of turns, microseconds.
fn turns_in(table: &Path) -> Vec<FrameTurn> {
    let text = std::fs::read_to_string(table).expect("a table");
    let rows = text.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>());
    let number = |word: &str| word.parse().unwrap_or_else(|error| panic!("{word}: {error}"));
    rows.filter(|row| !row[2].is_empty())
        .map(|row| FrameTurn { ended_us: number(row[0]), camera_us: number(row[1]) })
        .collect()
}

/// Stops the program for 3 s in a run of 8 s. Every frame must be counted, of which the camera took `taken`, where that is
/// known.
fn stopped(name: &str, source: &str, taken: Option<u64>) {
    let _turn = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let folder = folder(name);
    let begun = Instant::now();
    let running = Running::start(&folder, &["--source", source, "--seconds", "8", "--turns", "turns.csv"]);
    std::thread::sleep(Duration::from_secs(2));
    running.signal("STOP");
    std::thread::sleep(Duration::from_secs(3));
    running.signal("CONT");
    let counts = accounts(&running.report());
    let most = (60.0 * begun.elapsed().as_secs_f64()) as u64;
    // 180 frames in 3 s; the first of them may be in time.
    assert!(counts.missed() >= 175, "3 s without the program: {counts}");
    assert!(counts.late + counts.never_handled >= 150, "the host is why: {counts}");
    // A camera on a bus is connected in the first part of the run, which a busy machine may end late.
    assert!((420..=most).contains(&counts.taken()), "{counts} but {most} at most");
    let taken = taken.unwrap_or_else(|| counts.taken());
    all_are_counted(&counts, taken, clearly_missed(taken, &turns_in(&folder.join("turns.csv"))));
}

#[test]
fn frames_of_a_stopped_program_are_counted() {
    stopped("stopped", "shipped", Some(480));
}

#[test]
fn frames_of_a_stopped_program_with_a_camera_on_a_bus_are_counted() {
    stopped("stopped-bus", "simulated-usb", None);
}

#[test]
fn a_service_reports_all_of_its_time() {
    let _turn = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let begun = Instant::now();
    let running = Running::start(&folder("service"), &["--source", "simulated-usb", "--service"]);
    let first = Instant::now();
    std::thread::sleep(Duration::from_secs(20));
    let least_s = first.elapsed().as_secs_f64();
    running.signal("TERM");
    let report = running.report();
    let counts = accounts(&report);
    println!("a service of {least_s:.1} s: {counts}");
    let most_s = begun.elapsed().as_secs_f64();
    assert!((least_s - 1.0..most_s + 0.1).contains(&counts.over_s), "{least_s} to {most_s} s: {counts}");
    assert!((counts.taken() as f64 / 60.0 - counts.over_s).abs() < 0.1, "{counts}");
    let modes = report["modes"].as_object().expect("modes");
    let turns: u64 = modes.values().filter_map(Value::as_u64).sum();
    assert_eq!(report["frames"].as_u64(), Some(turns), "every turn is in the report");
    assert!(turns > 1000, "more than 16 s of turns: {turns}");
}
