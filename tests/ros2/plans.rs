//! The plan service beside the controller's interface.

use crate::peers::Peer;
use crate::run::{Run, now_us};
use crate::stuffing::unstuffed;
use meniscus_service::controller::{CONTROL_KIND, ControlRecord, ForecastPoint, Plan};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Address of the plans over UDP; the namespace has no other program.
const PLANS: &str = "127.0.0.1:9001";

/// Plans that are compared. A turn may have no controller's record: that one was late.
const COMPARED: usize = 5;

/// Times that a plan is sent at most.
const TRIES: u32 = 40;

/// A move by `distance_m` along x in half a second, from 0.4 s ahead to rest.
fn course(distance_m: f64) -> Vec<(u64, [f64; 3])> {
    let begun_ns = 1000 * now_us() + 400_000_000;
    let place = |k: u64| {
        let s = (k as f64 / 50.0).min(1.0);
        distance_m * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    };
    (0..55).map(|k| (begun_ns + k * 10_000_000, [place(k), 0.0, 0.0])).collect()
}

/// Whether a busy machine brought the request behind the beginning of its plan, or gave the run no time for a turn.
fn busy(answer: &Value) -> bool {
    answer["fault"] == 7 || answer["reason"].as_str().is_some_and(|reason| reason.starts_with("no turn came"))
}

/// Longest time of a call behind the first, seconds: a turn on a busy machine. The first call of a client may come before the node
/// knows the client, and again with the client's next heartbeat, 3 s later (`docs/robots.md`).
const LONGEST_S: f64 = 0.3;

/// Returns how long a call took, which is not long.
fn took_in_time(answer: &Value) -> f64 {
    let took_s = answer["took_s"].as_f64().expect("a time");
    assert!(took_s < LONGEST_S, "{answer}");
    took_s
}

fn request(sequence: u32, follow: bool, samples: &[(u64, [f64; 3])]) -> Value {
    json!({ "sequence": sequence, "follow": follow, "samples": samples })
}

/// The controller's records of a run, as they come.
#[derive(Default)]
struct Records {
    all: Mutex<Vec<ControlRecord>>,
    over: AtomicBool,
}

/// Ends the reader, whatever ends the test.
struct Over<'o>(&'o AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Records {
    fn read(&self, run: &Run) {
        let mut reader = BufReader::new(run.records());
        while !self.over.load(Ordering::Relaxed) {
            let mut stuffed = Vec::new();
            reader.read_until(0, &mut stuffed).expect("a record in time");
            let bytes = unstuffed(&stuffed);
            if bytes.first() == Some(&CONTROL_KIND) {
                let record = ControlRecord::read(&bytes).expect("a whole record");
                self.all.lock().expect("nobody has panicked").push(record);
            }
        }
    }

    /// Returns the record of the turn at `camera_us`; `None` where a later one is there and that one is not.
    fn of(&self, camera_us: u64) -> Option<ControlRecord> {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(10) {
            let all = self.all.lock().expect("nobody has panicked");
            if let Some(record) = all.iter().find(|record| record.time.0 == camera_us) {
                return Some(record.clone());
            }
            if all.last().is_some_and(|last| last.time.0 > camera_us) {
                return None;
            }
            drop(all);
            std::thread::sleep(Duration::from_millis(5));
        }
        panic!("no record for ten seconds");
    }
}

/// Compares answers of the service with records of the same turn under the same plan, then refusals.
pub(crate) fn scene() {
    let run = Run::start("plans", &["--controller", "--plan", &format!("udp:{PLANS}")]);
    let (records, sender) = (Records::default(), UdpSocket::bind("127.0.0.1:0").expect("a port"));
    let mut peer = Peer::start("rclpy_peer.py", &["plan"]);
    let mut ask = |request: &Value| {
        peer.tell(request);
        peer.line()
    };
    // The first answer takes the time of the discovery.
    let begun = Instant::now();
    while busy(&ask(&request(1, false, &course(0.03)))) {
        assert!(begun.elapsed() < Duration::from_secs(20), "the service answers");
    }
    std::thread::scope(|scope| {
        scope.spawn(|| records.read(&run));
        let _over = Over(&records.over);
        let (mut compared, mut took_s) = (0, Vec::new());
        for sequence in 2..TRIES {
            let samples = course(0.02 + 0.002 * f64::from(sequence));
            // The controller has the plan over UDP, the service by its request.
            sender.send_to(&Plan::to_bytes(sequence, &samples), PLANS).expect("sent");
            let answer = ask(&request(sequence, false, &samples));
            if busy(&answer) {
                continue;
            }
            assert_eq!(answer["accepted"], true, "{answer}");
            took_s.push(took_in_time(&answer));
            let Some(record) = records.of(answer["camera_time"].as_u64().expect("a turn")) else { continue };
            assert_eq!(record.plan.sequence, Some(sequence));
            compare(&answer, &record);
            compared += 1;
            if compared == COMPARED {
                break;
            }
        }
        assert_eq!(compared, COMPARED, "the controller has a record of nearly every turn");
        took_s.sort_by(f64::total_cmp);
        println!(
            "{compared} answers are the controller's; a call took {:.1} ms in the median",
            1e3 * took_s[took_s.len() / 2]
        );
        // A plan that the run follows stands in the controller's records, though it came by the service.
        let followed_by = 77;
        let followed = ask(&request(followed_by, true, &course(0.04)));
        assert_eq!(followed["accepted"], true, "{followed}");
        let begun = Instant::now();
        while !records
            .all
            .lock()
            .expect("nobody has panicked")
            .iter()
            .any(|record| record.plan.sequence == Some(followed_by))
        {
            assert!(begun.elapsed() < Duration::from_secs(5), "the run follows the plan");
            std::thread::sleep(Duration::from_millis(10));
        }
        refusals(&mut ask);
    });
    let ended = run.end();
    assert!(!ended.said.contains(", 0 plans answered"), "{}", ended.said);
}

/// An answer is a record of the same turn: surfaces, crest and risk, to the last bit.
fn compare(answer: &Value, record: &ControlRecord) {
    let floats = |value: &Value| -> Vec<f32> {
        let numbers = value.as_array().expect("a list").iter();
        numbers.map(|number| number.as_f64().expect("a number") as f32).collect()
    };
    let profiles = answer["profiles"].as_array().expect("surfaces");
    assert_eq!(profiles.len(), record.forecast.len());
    for (profile, ForecastPoint { ahead, surface_m, half_width_m }) in profiles.iter().zip(&record.forecast) {
        let after = profile[0].as_f64().expect("a time");
        assert!((after - f64::from(*ahead) / 60.0).abs() < 1e-9, "{after} s for turn {ahead}");
        assert_eq!((floats(&profile[1]), floats(&profile[2])), (surface_m.to_vec(), half_width_m.to_vec()));
    }
    let spill = &record.spill;
    assert_eq!(floats(&answer["crest"])[..2], [spill.crest_m, spill.crest_half_m]);
    assert_eq!(floats(&json!([answer["spill"]])), [spill.probability]);
    let horizon = answer["horizon"].as_array().expect("two times");
    for (seconds, turns) in horizon.iter().zip([spill.horizon, spill.planned]) {
        assert!((seconds.as_f64().expect("a time") - f64::from(turns) / 60.0).abs() < 1e-9);
    }
    assert_eq!(answer["host_ns"].as_u64(), record.host.map(|host| host.unix_ns), "the same instant");
}

/// Something that is no plan is refused with its number and the reason.
fn refusals(ask: &mut impl FnMut(&Value) -> Value) {
    let whole = || course(0.05);
    let past = || whole().into_iter().map(|(stamp, place)| (stamp - 2_000_000_000, place)).collect();
    let cases: [(&dyn Fn() -> Vec<_>, u8, &str); 3] = [
        (&|| whole()[..3].to_vec(), 3, "it has 3 samples, and 4 are the least"),
        (&|| whole()[..25].to_vec(), 9, "it ends while the glass moves at"),
        (&past, 7, "s in the past"),
    ];
    for (samples, fault, reason) in cases {
        let answer = ask(&request(90, false, &samples()));
        took_in_time(&answer);
        assert_eq!((&answer["accepted"], &answer["fault"]), (&false.into(), &fault.into()), "{answer}");
        assert!(answer["reason"].as_str().is_some_and(|text| text.contains(reason)), "{answer}");
        assert_eq!(answer["profiles"], json!([]));
    }
}
