//! Topics that state no motion, or a wrong one: each fault has its counter and its sentence, and the turns go on.

use crate::motion_run::{MotionRun, Report};
use crate::motion_stream::{
    AT_ONCE, FROM_S, LEAD_NS, LINE, MOVED_MOST, SILENCE, in_time, motion, play, prepare, reports, stream,
};
use crate::peers::Peer;
use meniscus_data::motion::Motion;
use serde_json::{Value, json};
use std::time::Duration;

/// Length of the streams, s.
const STREAM_S: f64 = 3.0;

/// Instant of the faults behind the beginning of the streams, s: the camera has agreed to the motion by then.
const FAULTS_S: f64 = 1.5;

/// Messages of each fault, and of a second publisher.
const EACH: u64 = 3;
const OF_SECOND: u64 = 20;

/// Domain of a publisher whose bytes are no message.
const LIE: usize = 27;

/// Time for it to be found, and to send more than fifty of its messages.
const LIE_TIME: Duration = Duration::from_secs(5);

/// Time of a clock that is not the host's, at the beginning of its stream, ns.
const OTHER_CLOCK_NS: u64 = 100_000_000_000;

/// A run whose topic has a fault.
struct Case {
    name: &'static str,
    kind: &'static str,
    topic: &'static str,
    arguments: &'static [&'static str],
}

const CASES: [Case; 7] = [
    Case { name: "samples", kind: "pose", topic: "/pose", arguments: &[] },
    Case {
        name: "links",
        kind: "chain",
        topic: "/tf",
        arguments: &["--motion-frames", "world,glass_holder"],
    },
    Case { name: "clock", kind: "pose", topic: "/pose", arguments: &["--motion-clock", "sender"] },
    Case { name: "frame", kind: "chain", topic: "/tf", arguments: &["--motion-frames", "world,nowhere"] },
    Case { name: "type", kind: "text", topic: "/words", arguments: &[] },
    Case { name: "joint", kind: "joints", topic: "/joint_states", arguments: &["--motion-joint", "lift"] },
    Case { name: "nobody", kind: "text", topic: "/elsewhere", arguments: &[] },
];

/// Returns the messages of faults of the topic `to`, in the middle of its stream.
fn faults(motion: &Motion, case: &Case, to: &Value, begun_ns: u64) -> Vec<Value> {
    let at_s = FROM_S + FAULTS_S;
    let of = |count: u64, publisher: u64| {
        let mut to = to.clone();
        to["publisher"] = publisher.into();
        let mut events = stream(motion, &to, begun_ns, [at_s, at_s + 1.0]);
        events.truncate(count as usize);
        // Between two good ones.
        events.iter_mut().for_each(|event| {
            for time in ["due_ns", "stamp_ns"] {
                event[time] = (event[time].as_u64().expect("a time") + 3_000_000).into();
            }
        });
        events
    };
    let changed = |key: &str, change: &dyn Fn(&Value) -> Value| {
        let mut events = of(EACH, 0);
        events.iter_mut().for_each(|event| event[key] = change(&event[key]));
        events
    };
    let later = |by_ns: i64| {
        move |stamp: &Value| stamp.as_u64().expect("a stamp").saturating_add_signed(by_ns).into()
    };
    let mut second = of(OF_SECOND, 1);
    second.iter_mut().for_each(|event| event["x"] = 0.5.into());
    match case.name {
        "samples" => [
            changed("stamp_ns", &|_| 0.into()),
            changed("x", &|_| Value::Null),
            changed("quaternion", &|_| json!([0.0, 0.0, 0.0, 0.5])),
            changed("stamp_ns", &later(2_000_000_000)),
            changed("stamp_ns", &later(-2_000_000_000)),
            second,
        ]
        .concat(),
        "links" => second,
        _ => vec![],
    }
}

/// Runs the cases, and a liar.
pub(crate) fn scene() {
    let cases: Vec<(usize, &Case)> = CASES.iter().enumerate().collect();
    let reports: Vec<Report> =
        cases.chunks(AT_ONCE).flat_map(|cases| in_time(cases, MOVED_MOST, &run)).collect();
    for (case, report) in CASES.iter().zip(&reports) {
        println!("{:8} {}", case.name, report.motion);
        check(case, report);
    }
    check_lie();
}

/// Runs cases at once, each in a domain of its own. Returns their reports, and the peer's delay.
fn run(cases: &[(usize, &Case)]) -> (Vec<Report>, Duration) {
    let motion = motion();
    let mut peer = Peer::start("motion_peer.py", &[]);
    peer.line();
    let to = |(place, case): &(usize, &Case)| {
        let nobody = if case.name == "nobody" { "/here" } else { case.topic };
        json!({ "kind": case.kind, "domain": 20 + place, "topic": nobody })
    };
    let streams: Vec<Value> = cases.iter().map(to).collect();
    let of_kinds = |kinds: &[&str]| {
        let of = streams.iter().filter(|stream| kinds.contains(&stream["kind"].as_str().expect("a kind")));
        of.cloned().collect::<Vec<Value>>()
    };
    let is_second = |case: &Case| ["samples", "links"].contains(&case.name);
    let seconds = cases.iter().zip(&streams).filter(|((_, case), _)| is_second(case)).map(|(_, stream)| {
        let mut of = stream.clone();
        of["publisher"] = 1.into();
        of
    });
    let rails = of_kinds(&["chain"]).into_iter().map(
        |chain| json!({ "kind": "rail", "domain": chain["domain"], "topic": "/tf_static", "due_ns": 0 }),
    );
    let rails: Vec<Value> = rails.collect();
    let read = [&of_kinds(&["pose", "chain"])[..], &seconds.collect::<Vec<_>>(), &rails].concat();
    prepare(&mut peer, &[&streams[..], &read].concat(), "announce");
    let start = |(place, case): &(usize, &Case)| {
        let source = format!("ros2:{}", case.topic);
        let given = ["--motion", &source, "--motion-line", LINE];
        MotionRun::spawn(case.name, 20 + place, &[&given, case.arguments].concat())
    };
    let mut runs: Vec<MotionRun> = cases.iter().map(start).collect();
    runs.iter_mut().for_each(MotionRun::begin);
    prepare(&mut peer, &read, "await");
    play(&mut peer, rails);
    let mut events = Vec::new();
    for (((_, case), to), run) in cases.iter().zip(&streams).zip(&runs) {
        let mut own = stream(&motion, to, run.begun_ns(), [FROM_S, FROM_S + STREAM_S]);
        if case.name == "clock" {
            own.iter_mut().for_each(|event| {
                let passed_ns = event["stamp_ns"].as_u64().expect("a stamp") - run.begun_ns();
                event["stamp_ns"] = (OTHER_CLOCK_NS + passed_ns).into();
                // This clock is known by arrivals alone.
                event["due_ns"] = (event["due_ns"].as_u64().expect("a time") + LEAD_NS).into();
            });
        }
        events.extend(own);
        events.extend(faults(&motion, case, to, run.begun_ns()));
    }
    let late = play(&mut peer, events);
    std::thread::sleep(SILENCE);
    (reports(runs), late)
}

/// Runs beside a publisher whose bytes are no message, and checks that they were counted and named.
fn check_lie() {
    let mut lied = MotionRun::spawn("bytes", LIE, &["--motion", "ros2:/lie"]);
    lied.begin();
    // It is stopped at the end of the scene.
    let _liar = Peer::start("cyclone_peer.py", &["lie", "30", &LIE.to_string()]);
    std::thread::sleep(LIE_TIME);
    let Report { motion, said, .. } = reports(vec![lied]).pop().expect("one");
    println!("bytes    {motion}");
    assert!(
        motion["stamped"]["malformed"].as_u64() > Some(50) && motion["stamped"]["taken"] == 0,
        "{motion}"
    );
    assert!(said.contains("its bytes are no nav_msgs/msg/Odometry"), "{said}");
}

/// Holds counters and sentences of a run against its faults.
fn check(case: &Case, report: &Report) {
    let has = |words: &str| assert!(report.said.contains(words), "{}: {words}: {}", case.name, report.said);
    let count = |name: &str| report.count(name);
    let commanded = report.motion["commanded"].as_u64().expect("a number");
    let turns = commanded + report.motion["tracked"].as_u64().expect("a number");
    assert!(turns as f64 > 60.0 * STREAM_S, "{}: the turns go on: {turns}", case.name);
    assert_eq!(report.motion["contradictions"], 0, "{}: {}", case.name, report.said);
    match case.name {
        "samples" => {
            let faults = ["unstamped", "malformed", "unsound", "future", "stale"].map(count);
            assert_eq!((faults, count("lost")), ([EACH; 5], 0), "{}", report.motion);
            assert_eq!((&report.motion["refused"], count("stops") >= 1), (&OF_SECOND.into(), true));
            has("its stamp is zero");
            has("a number is not finite");
            has("its quaternion has the length 0.500, not 1");
            has("s ahead was refused");
            has("s ago was refused");
            has("motion frames are left out: another sender is heard");
            has("the stamped motion has stopped");
            assert!(commanded > 100, "the good ones are used: {commanded}");
        }
        "links" => {
            // Two links a message.
            assert_eq!(report.motion["refused"], 2 * OF_SECOND);
            has("has a second publisher: it is left out");
            assert!(commanded > 100 && count("stops") >= 1, "{commanded}");
        }
        "clock" => {
            let none = ["unstamped", "malformed", "future", "stale", "clock_steps"].map(count);
            assert_eq!(none, [0; 5], "{}", report.motion);
            assert!(count("taken") > 300 && commanded > 100, "{commanded}");
        }
        _ => {
            assert!(commanded == 0 && count("taken") == 0 && count("absent") >= 1, "{}", report.motion);
        }
    }
    match case.name {
        "frame" => has(
            "no transform from world to nowhere on /tf; frames that were seen: cart, glass_holder, rail, world",
        ),
        "type" => {
            has("no message on /words that can be read; types that were seen: std_msgs/msg/String. Types");
        }
        "joint" => has("no joint lift on /joint_states; joints that were seen: slide, wrist"),
        "nobody" => has("no message on /elsewhere: it has no publisher"),
        _ => {}
    }
}
