//! The motion of the glass from topics of every type, beside the same samples over UDP.

use crate::motion_run::{FRAME_0_US, MotionRun, Report};
use crate::peers::Peer;
use meniscus::surface::POINTS;
use meniscus_data::motion::Motion;
use meniscus_data::recording::{EstimateRecording, Recording};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Duration;

/// Direction of the line in the peer's world.
pub(super) const LINE: &str = "0.6,0.8,0";

/// Time from the sending of a sample to its stamp, ns, as of a command: a peer that a busy machine holds up is in time.
pub(super) const LEAD_NS: u64 = 60_000_000;

/// Samples a second.
const RATE_HZ: f64 = 125.0;

/// Silence behind the streams that the runs have to notice.
pub(super) const SILENCE: Duration = Duration::from_millis(500);

/// Time that a peer takes to read its events, s.
const SOON_S: f64 = 0.3;

/// Returns the motion of the glass in the shipped recording over its time, s.
pub(super) fn motion() -> Motion {
    let bytes = meniscus_shipped::RECORDING;
    let recording = Recording::from_bytes(Path::new("shipped"), bytes).expect("the shipped recording");
    let positions = (0..).map(|frame| f64::from(frame) / 60.0).zip(recording.glass_x_m.iter().copied());
    Motion::sampled(&positions.collect::<Vec<_>>()).expect("a motion")
}

/// Events of a stream: `to` with the samples of `motion` between the times `from_s` and `to_s` of a run that began at `begun_ns`.
pub(super) fn stream(motion: &Motion, to: &Value, begun_ns: u64, [from_s, to_s]: [f64; 2]) -> Vec<Value> {
    let count = ((to_s - from_s) * RATE_HZ) as u32;
    let times = (0..count).map(|k| from_s + f64::from(k) / RATE_HZ);
    let events = times.map(|time_s| {
        let at_ns = begun_ns + (1e9 * time_s) as u64;
        let velocity = (motion.position(time_s + 1e-4) - motion.position(time_s - 1e-4)) / 2e-4;
        let mut event = to.clone();
        event["due_ns"] = (at_ns - LEAD_NS).into();
        event["stamp_ns"] = at_ns.into();
        event["x"] = motion.position(time_s).into();
        event["v"] = velocity.into();
        event["a"] = motion.acceleration(time_s).into();
        event
    });
    events.collect()
}

/// Ends runs.
pub(super) fn reports(runs: Vec<MotionRun>) -> Vec<Report> {
    runs.iter().for_each(MotionRun::stop);
    runs.into_iter().map(MotionRun::report).collect()
}

/// Has the peer make the publishers of `streams` (`announce`), or wait until somebody reads them (`await`).
pub(super) fn prepare(peer: &mut Peer, streams: &[Value], how: &str) {
    let of_topics = streams.iter().filter(|stream| stream["kind"] != "udp").cloned();
    let prepared = of_topics.map(|mut stream| {
        stream[how] = true.into();
        stream
    });
    peer.tell(&prepared.collect());
    peer.line();
}

/// Waits until streams may begin, soon and not before `least_s` in the time of the runs, and returns when they do, s.
pub(super) fn beginning(runs: &[MotionRun], least_s: f64) -> f64 {
    let since_s = || {
        let earliest = runs.iter().map(MotionRun::begun_ns).min().expect("runs");
        1e-9 * (1000 * crate::run::now_us() - earliest) as f64
    };
    std::thread::sleep(Duration::from_secs_f64((least_s - SOON_S - since_s()).max(0.0)));
    let from_s = since_s() + SOON_S;
    println!("the streams begin {from_s:.2} s behind the first run");
    from_s
}

/// Has the peer send events in the order of their instants.
pub(super) fn play(peer: &mut Peer, mut events: Vec<Value>) {
    events.sort_by_key(|event| event["due_ns"].as_u64());
    peer.tell(&events.into());
    peer.line();
}

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

/// Time by which every run has the frames that were published before it began, s: Fast DDS speaks of them to a new reader every three
/// seconds.
pub(super) const STATIC_S: f64 = 4.5;

/// Time from the beginning of the streams to the frames that are compared, s: the camera has agreed to the motion by then, and the
/// estimates have forgotten what was before.
const SETTLED_S: f64 = 1.0;

/// Bound on the median difference of the surfaces, to the slosh, and that on a busy machine. Each run has its own map between the clocks
/// of camera and host, and without the processor some of its turns come too late for a sample.
const SURFACE: f64 = 0.005;
const SURFACE_BUSY: f64 = 0.05;

/// Bound on the median difference of the accelerations, to their own size.
const ACCELERATION: f64 = 0.02;

/// Holds the estimates of a run by each type of message against those by frames over UDP.
pub(crate) fn scene_of_types() {
    let (motion, is_quiet) = (motion(), crate::load() <= crate::LOAD_MOST);
    let mut peer = Peer::start("motion_peer.py", &[]);
    peer.line();
    let to = |(place, case): (usize, &Case)| {
        json!({ "kind": case.kind, "domain": 10 + place, "topic": case.topic, "states": case.states,
                "address": format!("127.0.0.1:{}", 9100 + place) })
    };
    let streams: Vec<Value> = CASES.iter().enumerate().map(to).collect();
    let rail = json!({ "kind": "rail", "domain": 15, "topic": "/tf_static", "due_ns": 0 });
    let all = [&streams[..], std::slice::from_ref(&rail)].concat();
    prepare(&mut peer, &all, "announce");
    // Published once, before anybody reads it.
    play(&mut peer, vec![rail]);
    let start = |(place, case): (usize, &Case)| {
        let source = match case.kind {
            "udp" => format!("udp:127.0.0.1:{}", 9100 + place),
            _ => format!("ros2:{}", case.topic),
        };
        let given = ["--motion", &source, "--motion-line", LINE];
        let name = format!("{}-{}", case.kind, case.states);
        MotionRun::spawn(&name, 10 + place, &[&given, case.arguments].concat())
    };
    let mut runs: Vec<MotionRun> = CASES.iter().enumerate().map(start).collect();
    runs.iter_mut().for_each(MotionRun::begin);
    prepare(&mut peer, &all, "await");
    let from_s = beginning(&runs, STATIC_S);
    let events = streams
        .iter()
        .zip(&runs)
        .flat_map(|(to, run)| stream(&motion, to, run.begun_ns(), [from_s, from_s + STREAM_S]));
    play(&mut peer, events.collect());
    std::thread::sleep(SILENCE);
    let reports = reports(runs);
    let window = [from_s + SETTLED_S, from_s + STREAM_S - 0.1];
    let by_udp = |case: &Case| {
        let place = CASES.iter().position(|udp| udp.kind == "udp" && udp.states == case.states);
        &reports[place.expect("frames with the same numbers")]
    };
    let apart = CASES.iter().zip(&reports).map(|(case, report)| {
        let [surface, acceleration] = apart(&report.estimates, &by_udp(case).estimates, window);
        println!(
            "{:9} {:2}: surface {:.3} % of the slosh, acceleration {:.2} %, from those by UDP; {} turns; {}",
            case.kind,
            case.states,
            100.0 * surface,
            100.0 * acceleration,
            report.motion["commanded"],
            report.motion["stamped"]
        );
        [surface, acceleration]
    });
    let apart: Vec<[f64; 2]> = apart.collect();
    for ((case, report), [surface, acceleration]) in CASES.iter().zip(&reports).zip(apart) {
        let most = if is_quiet { SURFACE } else { SURFACE_BUSY };
        assert!(surface < most && acceleration < ACCELERATION, "{}: {surface} {acceleration}", case.kind);
        check_counts(case, report);
        let commanded = |report: &Report| report.motion["commanded"].as_f64().expect("a number");
        // A busy machine holds the peer up.
        let as_many = commanded(report) > commanded(by_udp(case)) - 12.0 && report.count("stale") == 0;
        assert!(as_many || !is_quiet, "{}: {}", case.kind, report.motion);
    }
}

/// Every sample was taken, nothing else was counted, and the end of the stream was noticed.
fn check_counts(case: &Case, report: &Report) {
    let sent = (STREAM_S * RATE_HZ) as u64;
    let came = report.count("taken") + report.count("stale");
    assert!(came + 5 >= sent && came <= sent, "{}: {came} of {sent}: {}", case.kind, report.said);
    for name in ["late", "across", "future", "repeated", "malformed", "unstamped", "unsound"] {
        assert_eq!(report.count(name), 0, "{}: {name}: {}", case.kind, report.said);
    }
    assert!(report.count("stops") >= 1, "{}: {}", case.kind, report.said);
    assert!(report.said.contains("the stamped motion has stopped"), "{}", report.said);
    assert_eq!((&report.motion["contradictions"], &report.motion["refused"]), (&0.into(), &0.into()));
    // All turns of the stream but those before the camera has agreed.
    let least = 60.0 * (STREAM_S - 1.0);
    assert!(report.motion["commanded"].as_f64() > Some(least), "{}: {}", case.kind, report.motion);
}

/// Returns the median over the turns of two runs in a window of their time of the difference of the surfaces, to the slosh, and of the
/// accelerations, to their own size; slosh and size are root mean squares.
fn apart(is: &EstimateRecording, due: &EstimateRecording, [from_s, to_s]: [f64; 2]) -> [f64; 2] {
    let heights =
        |of: &EstimateRecording, row: usize| of.surface_m[row * POINTS..(row + 1) * POINTS].to_vec();
    let root_mean_square = |numbers: &[f64]| {
        (numbers.iter().map(|number| number * number).sum::<f64>() / numbers.len() as f64).sqrt()
    };
    let (mut surfaces, mut slosh, mut accelerations, mut sizes) = (vec![], vec![], vec![], vec![]);
    for (k, camera_us) in is.camera_us.iter().enumerate() {
        let time_s = 1e-6 * (*camera_us - FRAME_0_US) as f64;
        let other = due.camera_us.binary_search(camera_us).ok();
        let Some(other) = other.filter(|_| (from_s..to_s).contains(&time_s)) else { continue };
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
