//! A robot beside a running program: its records, a plan, stamped motion, and the Python example that does the same.

#[path = "support/optional.rs"]
mod optional;
#[path = "support/stuffing.rs"]
mod stuffing;

use meniscus_service::controller::{
    CHAIN_TURNS, CONTROL_KIND, ControlRecord, LINEAR_EVERY, PLAN_SAMPLES_MAX, Plan,
};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, UdpSocket};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use stuffing::unstuffed;

/// A run of the simulated camera in real time that listens for motion and plans.
struct Run {
    child: Child,
    socket: PathBuf,
    motion: SocketAddr,
    plans: SocketAddr,
}

fn free_port() -> SocketAddr {
    let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket");
    socket.local_addr().expect("an address")
}

impl Run {
    fn start(name: &str, seconds: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("robots-{name}"));
        let socket = std::env::temp_dir().join(format!("meniscus-robots-{}-{name}.sock", std::process::id()));
        let (motion, plans) = (free_port(), free_port());
        let child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--seconds", seconds, "--json", "--fields", "none", "--controller", "--out"])
            .arg(folder)
            .arg("--publish")
            .arg(format!("unix:{}", socket.display()))
            .args(["--plan", &format!("udp:{plans}"), "--motion", &format!("udp:{motion}")])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let run = Self { child, socket, motion, plans };
        let begun = Instant::now();
        while !run.socket.exists() {
            assert!(begun.elapsed() < Duration::from_secs(30), "the socket is there from the start");
            std::thread::sleep(Duration::from_millis(10));
        }
        run
    }

    fn report(self) -> (Value, String) {
        let output = self.child.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{why}: {said}")), said)
    }
}

/// The controller's records of a stream, without those of other kinds.
fn records(socket: &Path) -> impl Iterator<Item = ControlRecord> {
    let stream = UnixStream::connect(socket).expect("connected");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    let mut reader = BufReader::new(stream);
    std::iter::from_fn(move || {
        loop {
            let mut stuffed = Vec::new();
            reader.read_until(0, &mut stuffed).expect("a record in time");
            if stuffed.is_empty() {
                return None;
            }
            let bytes = unstuffed(&stuffed);
            if bytes.first() == Some(&CONTROL_KIND) {
                return Some(ControlRecord::read(&bytes).expect("a whole record of this version"));
            }
        }
    })
}

fn now_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64
}

/// A move by `distance_m` along x in 0.4 s that begins in `ahead_ms` and ends at rest.
fn course(distance_m: f64, ahead_ms: u64, samples: u64) -> Vec<(u64, [f64; 3])> {
    let begun_ns = now_ns() + ahead_ms * 1_000_000;
    let place = |k: u64| {
        let s = (k as f64 / 40.0).min(1.0);
        distance_m * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    };
    (0..samples).map(|k| (begun_ns + k * 10_000_000, [place(k), 0.0, 0.0])).collect()
}

#[test]
fn a_plan_is_taken_its_forecast_is_published_and_a_wrong_one_is_named() {
    let run = Run::start("plan", "8");
    let sender = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let send = |sequence, samples: &[(u64, [f64; 3])]| {
        sender.send_to(&Plan::to_bytes(sequence, samples), run.plans).expect("sent");
    };
    let (mut planned, mut linear, mut count, mut last_number) = (0, 0, 0_u64, None);
    let (mut latencies_ms, mut state, mut tallest) = (Vec::new(), 0, 0.0_f32);
    for record in records(&run.socket) {
        assert!(last_number.is_none_or(|last| record.number > last), "numbers rise");
        last_number = Some(record.number);
        count += 1;
        match count {
            60 => send(1, &course(0.0, 50, 30)),
            61 => send(2, &course(0.05, 50, 20)),
            62 => send(3, &course(0.05, 50, PLAN_SAMPLES_MAX as u64 + 10)),
            63 => {
                let mut past = course(0.05, 0, 60);
                past.iter_mut().for_each(|(stamp_ns, _)| *stamp_ns -= 2_000_000_000);
                send(4, &past);
            }
            90 => send(5, &course(0.06, 50, 50)),
            _ => {}
        }
        state += usize::from(record.state.along[0].amplitude_m.abs() > 1e-3);
        assert!(record.linear.is_some() == record.number.is_multiple_of(LINEAR_EVERY));
        linear += usize::from(record.linear.is_some());
        assert_eq!(record.chain.len(), if record.linear.is_some() { CHAIN_TURNS } else { 0 });
        latencies_ms.extend(record.host.map(|host| 1e-3 * host.latency_us as f64));
        if record.plan.sequence == Some(5) {
            planned += 1;
            assert!(record.forecast.len() >= 10 && record.spill.planned >= 30, "{:?}", record.spill);
            assert!(record.forecast.windows(2).all(|pair| pair[1].ahead == pair[0].ahead + 3));
            let halves = record.forecast.iter().flat_map(|point| point.half_width_m);
            assert!(halves.into_iter().all(|half| half > 0.0 && half < 0.1));
            tallest = tallest.max(record.spill.crest_m);
            // Three of the plans that were sent before have to be refused.
            assert_eq!((record.plan.refused, record.plan.taken), (3, 2), "{:?}", record.plan);
        } else {
            assert!(record.forecast.is_empty() || record.plan.sequence == Some(1));
            assert!(count < 64 || record.plan.last_fault > 0 || record.plan.refused < 3);
        }
        if count > 200 {
            break;
        }
    }
    latencies_ms.sort_by(f64::total_cmp);
    println!(
        "{count} records, {linear} with the linearised model, {planned} with the forecast of a plan (highest crest {:.1} mm); \
         from mid-exposure to the record, median {:.1} ms",
        1e3 * tallest,
        latencies_ms[latencies_ms.len() / 2]
    );
    assert!(planned >= 10 && linear >= 20 && state >= 50, "{planned} {linear} {state}");
    let (report, said) = run.report();
    for words in [
        "a plan was refused: it ends while the glass moves at",
        "266 samples, and 256 are the most",
        "s in the past",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!(report["clock"]["restarts"], 0, "{report:#}");
}

/// The Python example of the same; skipped without Python, which fails in CI.
#[test]
fn the_python_example_reads_moves_and_plans() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/robot.py");
    if Command::new("python3").arg("--version").output().is_err() {
        return optional::skip("python3 is not there");
    }
    let run = Run::start("python", "8");
    let python = |arguments: &[&str]| {
        let mut command = Command::new("python3");
        command.arg(example).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("python3 starts")
    };
    let (motion, plans, socket) =
        (run.motion.to_string(), run.plans.to_string(), run.socket.display().to_string());
    let reader = python(&["read", &socket, "--count", "150"]);
    let mover = python(&["move", &motion, "--seconds", "2"]);
    std::thread::sleep(Duration::from_millis(1500));
    let planner = python(&["plan", &plans, "--distance", "0.03", "--seconds", "0.6", "--sequence", "9"]);
    let ended = |child: Child| {
        let output = child.wait_with_output().expect("its output");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
        text
    };
    assert_eq!(ended(planner), "plan 9: 62 samples sent\n");
    ended(mover);
    let text = ended(reader);
    assert_eq!(text.lines().count(), 150, "{text}");
    assert!(text.contains("mm/s, spill ") && text.contains("A[0][0] "), "{text}");
    assert!(text.contains("plan 9 with "), "{text}");
    let (report, said) = run.report();
    let stamped = &report["motion"]["stamped"];
    // It is heard until the camera has contradicted it.
    assert!(stamped["taken"].as_u64() > Some(100), "{stamped}: {said}");
    assert_eq!(
        (&stamped["stale"], &stamped["future"], &stamped["across"]),
        (&0.into(), &0.into(), &0.into())
    );
    assert!(stamped["stops"].as_u64() >= Some(1), "it ends before the run: {stamped}");
    // The glass does not move as it says.
    assert!(said.contains("the commanded motion is not that of the glass in the image"), "{said}");
}
