//! The motion of the glass from topics of every type, beside the same samples over UDP.

use crate::motion_run::{FRAME_0_US, MotionRun, Report};
use crate::motion_stream::{
    AT_ONCE, FROM_S, LINE, RATE_HZ, SILENCE, in_time, motion, play, prepare, reports, stream,
};
use crate::peers::Peer;
use meniscus::surface::POINTS;
use meniscus_data::recording::EstimateRecording;
use serde_json::{Value, json};
use std::time::Duration;

/// One type of messages, and the frame over UDP with the same numbers.
struct Case {
    kind: &'static str,
    topic: &'static str,
    arguments: &'static [&'static str],
    states: &'static str,
}

/// The types; the first three are the frames themselves.
const CASES: [Case; 9] = [
    Case { kind: "udp", topic: "", arguments: &[], states: "x" },
    Case { kind: "udp", topic: "", arguments: &[], states: "xv" },
    Case { kind: "udp", topic: "", arguments: &[], states: "a" },
    Case { kind: "pose", topic: "/pose", arguments: &[], states: "x" },
    Case { kind: "transform", topic: "/vicon/glass", arguments: &[], states: "x" },
    Case { kind: "chain", topic: "/tf", arguments: &["--motion-frames", "world,glass_holder"], states: "x" },
    Case { kind: "odometry", topic: "/odom", arguments: &[], states: "xv" },
    Case {
        kind: "joints",
        topic: "/joint_states",
        arguments: &["--motion-joint", "slide", "--motion-axis", LINE],
        states: "xv",
    },
    Case { kind: "imu", topic: "/imu", arguments: &[], states: "a" },
];

/// Length of the streams, s.
const STREAM_S: f64 = 2.6;

/// Time from the beginning of the streams to the frames that are compared, s: the camera has agreed to the motion by then, and the
/// estimates have forgotten what was before.
const SETTLED_S: f64 = 1.0;

/// Bound on the median difference of the surfaces, to the slosh. Each run has its own map between the clocks of camera and host.
const SURFACE: f64 = 0.005;

/// Bound on the median difference of the accelerations, to their own size.
const ACCELERATION: f64 = 0.02;

/// Greatest change of a map between the clocks with which two runs are compared: it moves the samples against the frames.
const MOVED_MOST: Duration = Duration::from_micros(500);

/// Greatest share of the due turns that may be without a motion.
const FEWER: f64 = 0.075;

/// Turns after which the camera first agrees to a motion (`commanded_motion/agreement.rs`).
const AGREED_AFTER: usize = 20;

/// Holds the estimates of a run by each type of message against those by frames over UDP.
pub(crate) fn scene_of_types() {
    let cases: Vec<(usize, &Case)> = CASES.iter().enumerate().collect();
    let reports: Vec<Report> =
        cases.chunks(AT_ONCE).flat_map(|cases| in_time(cases, MOVED_MOST, &run)).collect();
    let by_udp = |case: &Case| {
        let place = CASES.iter().position(|udp| udp.kind == "udp" && udp.states == case.states);
        &reports[place.expect("frames with the same numbers")]
    };
    for (case, report) in CASES.iter().zip(&reports) {
        let [surface, acceleration] = apart(&report.estimates, &by_udp(case).estimates);
        println!(
            "{:9} {:2}: surface {:.3} % of the slosh, acceleration {:.2} %, from those by UDP; {} turns of {}; {}",
            case.kind,
            case.states,
            100.0 * surface,
            100.0 * acceleration,
            report.motion["commanded"],
            due(&report.estimates),
            report.motion["stamped"]
        );
        assert!(surface < SURFACE && acceleration < ACCELERATION, "{}: {surface} {acceleration}", case.kind);
        check_counts(case, report);
    }
}

/// Runs cases at once, each in a domain of its own. Returns their reports, and the peer's delay.
fn run(cases: &[(usize, &Case)]) -> (Vec<Report>, Duration) {
    let motion = motion();
    let mut peer = Peer::start("motion_peer.py", &[]);
    peer.line();
    let to = |(place, case): &(usize, &Case)| {
        json!({ "kind": case.kind, "domain": 10 + place, "topic": case.topic, "states": case.states,
                "address": format!("127.0.0.1:{}", 9100 + place) })
    };
    let streams: Vec<Value> = cases.iter().map(to).collect();
    let chains = cases.iter().filter(|(_, case)| case.kind == "chain");
    let rails: Vec<Value> = chains
        .map(|(place, _)| json!({ "kind": "rail", "domain": 10 + place, "topic": "/tf_static", "due_ns": 0 }))
        .collect();
    let all = [&streams[..], &rails].concat();
    prepare(&mut peer, &all, "announce");
    // Published once, before anybody reads it.
    play(&mut peer, rails);
    let start = |(place, case): &(usize, &Case)| {
        let source = match case.kind {
            "udp" => format!("udp:127.0.0.1:{}", 9100 + place),
            _ => format!("ros2:{}", case.topic),
        };
        let given = ["--motion", &source, "--motion-line", LINE];
        let name = format!("{}-{}", case.kind, case.states);
        MotionRun::spawn(&name, 10 + place, &[&given, case.arguments].concat())
    };
    let mut runs: Vec<MotionRun> = cases.iter().map(start).collect();
    runs.iter_mut().for_each(MotionRun::begin);
    prepare(&mut peer, &all, "await");
    let events = streams
        .iter()
        .zip(&runs)
        .flat_map(|(to, run)| stream(&motion, to, run.begun_ns(), [FROM_S, FROM_S + STREAM_S]));
    let late = play(&mut peer, events.collect());
    std::thread::sleep(SILENCE);
    (reports(runs), late)
}

/// Every sample was taken, nothing else was counted, and the end of the stream was noticed.
fn check_counts(case: &Case, report: &Report) {
    let sent = (STREAM_S * RATE_HZ) as u64;
    let taken = report.count("taken");
    assert!(taken + 5 >= sent && taken <= sent, "{}: {taken} of {sent}: {}", case.kind, report.said);
    for name in ["stale", "late", "across", "future", "repeated", "malformed", "unstamped", "unsound"] {
        assert_eq!(report.count(name), 0, "{}: {name}: {}", case.kind, report.said);
    }
    assert!(report.count("stops") >= 1, "{}: {}", case.kind, report.said);
    assert!(report.said.contains("the stamped motion has stopped"), "{}", report.said);
    assert_eq!((&report.motion["contradictions"], &report.motion["refused"]), (&0.into(), &0.into()));
    let due = due(&report.estimates) as f64;
    let least = f64::max(60.0 * (STREAM_S - 1.0), (1.0 - FEWER) * due);
    assert!(report.motion["commanded"].as_f64() > Some(least), "{} of {due}: {}", case.kind, report.motion);
}

/// Returns the number of turns of the stream behind the camera's agreement. A frame that a busy machine leaves out has no turn; one that
/// comes late has two: the first was predicted.
fn due(estimates: &EstimateRecording) -> usize {
    let stream_s = FROM_S..FROM_S + STREAM_S;
    let turns = estimates.camera_us.iter().filter(|us| stream_s.contains(&time_s(**us))).count();
    turns.saturating_sub(AGREED_AFTER)
}

/// Returns the time of a run at which its frame of `camera_us` was taken, s.
fn time_s(camera_us: u64) -> f64 {
    1e-6 * (camera_us - FRAME_0_US) as f64
}

/// Returns medians over the turns of two runs behind the first second of the stream: of the difference of the surfaces, to the slosh, and
/// of the accelerations, to their own size. Slosh and size are root mean squares.
fn apart(is: &EstimateRecording, due: &EstimateRecording) -> [f64; 2] {
    let window_s = FROM_S + SETTLED_S..FROM_S + STREAM_S - 0.1;
    let heights =
        |of: &EstimateRecording, row: usize| of.surface_m[row * POINTS..(row + 1) * POINTS].to_vec();
    let root_mean_square = |numbers: &[f64]| {
        (numbers.iter().map(|number| number * number).sum::<f64>() / numbers.len() as f64).sqrt()
    };
    let (mut surfaces, mut slosh, mut accelerations, mut sizes) = (vec![], vec![], vec![], vec![]);
    for (k, camera_us) in is.camera_us.iter().enumerate() {
        let other = due.camera_us.binary_search(camera_us).ok();
        let Some(other) = other.filter(|_| window_s.contains(&time_s(*camera_us))) else { continue };
        let (is_m, due_m) = (heights(is, k), heights(due, other));
        let mean = due_m.iter().sum::<f32>() / POINTS as f32;
        let apart: Vec<f64> = is_m.iter().zip(&due_m).map(|(is_m, due_m)| f64::from(is_m - due_m)).collect();
        surfaces.push(root_mean_square(&apart));
        slosh.extend(due_m.iter().map(|due_m| f64::from(due_m - mean)));
        accelerations.push(f64::from(is.acceleration_m_s2[k] - due.acceleration_m_s2[other]).abs());
        sizes.push(f64::from(due.acceleration_m_s2[other]));
    }
    assert!(sizes.len() > 60, "{} turns of both runs", sizes.len());
    let median = |mut numbers: Vec<f64>| {
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    };
    [median(surfaces) / root_mean_square(&slosh), median(accelerations) / root_mean_square(&sizes)]
}
