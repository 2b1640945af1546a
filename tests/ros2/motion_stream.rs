//! Streams of samples by the peer, and the runs that read them.

use crate::motion_run::{MotionRun, Report};
use crate::peers::Peer;
use meniscus_data::motion::Motion;
use meniscus_data::recording::Recording;
use serde_json::Value;
use std::path::Path;
use std::time::Duration;

/// Direction of the line in the peer's world.
pub(super) const LINE: &str = "0.6,0.8,0";

/// Time from the sending of a sample to its stamp, ns, as of a command: a peer that a busy machine holds up is in time.
pub(super) const LEAD_NS: u64 = 60_000_000;

/// Samples a second.
pub(super) const RATE_HZ: f64 = 125.0;

/// Silence behind the streams that the runs have to notice.
pub(super) const SILENCE: Duration = Duration::from_millis(500);

/// Time of a run at which its stream begins, s: all runs have begun, the peer has built its messages, and Fast DDS has
/// spoken of what was published before to a new reader, which it does every three seconds.
pub(super) const FROM_S: f64 = 6.0;

/// Greatest delay of a peer with which a verdict is possible: two thirds of the lead.
const LATE_MOST: Duration = Duration::from_millis(40);

/// Greatest share of late frames of a run with which one is.
const LATE_SHARE: f64 = 0.1;

/// Greatest change of a map between the clocks with which one is: two thirds of the lead, as for the peer.
pub(super) const MOVED_MOST: Duration = LATE_MOST;

/// Runs that are begun at once.
pub(super) const AT_ONCE: usize = 3;

/// Times that a single run is begun while it or its peer is late.
const TRIES: usize = 5;

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

/// Has the peer send events in the order of their instants, and returns its greatest delay.
pub(super) fn play(peer: &mut Peer, mut events: Vec<Value>) -> Duration {
    events.sort_by_key(|event| event["due_ns"].as_u64());
    peer.tell(&events.into());
    let late_s = peer.line()["late_s"].as_f64().expect("a delay");
    Duration::from_secs_f64(late_s)
}

/// Returns the reports of `cases`, which `run` runs at once. Where peer or runs were late, or a map between the clocks moved by more than
/// `moved_most`, the samples were not those of the test: the cases are then run in halves, and a single one again.
pub(super) fn in_time<C: Copy>(
    cases: &[C],
    moved_most: Duration,
    run: &impl Fn(&[C]) -> (Vec<Report>, Duration),
) -> Vec<Report> {
    for _ in 0..TRIES {
        let (reports, late) = run(cases);
        let share = reports.iter().map(Report::late_share).fold(0.0, f64::max);
        let moved = reports.iter().map(|report| report.map_moved).max().unwrap_or_default();
        println!(
            "{} at once: the peer was late by {late:.1?} at most, a run in {:.1} % of its frames; a clock moved by {moved:.1?}",
            cases.len(),
            100.0 * share
        );
        if late <= LATE_MOST && share <= LATE_SHARE && moved <= moved_most {
            return reports;
        }
        if cases.len() > 1 {
            let (first, rest) = cases.split_at(cases.len() / 2);
            return [first, rest].into_iter().flat_map(|half| in_time(half, moved_most, run)).collect();
        }
    }
    panic!("one run and its peer were late {TRIES} times: this machine has no time for them")
}
