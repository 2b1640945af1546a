//! Stamped samples of the motion over UDP: late ones, false stamps, a second sender, a stream that stops, by real datagrams.

use meniscus_service::commanded_motion::{
    CommandedMotion, ExpectedSender, LINE_ALONG_X, MotionFrame, StampClock, StampedCounts, WireMotion,
};
use std::net::{SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// A listener, its address, and what it said.
struct Listening {
    motion: CommandedMotion,
    sender: UdpSocket,
    said: Arc<Mutex<Vec<String>>>,
}

impl Listening {
    fn start(token: Option<&str>) -> Self {
        let any: SocketAddr = ([127, 0, 0, 1], 0).into();
        let free = UdpSocket::bind(any).expect("a socket").local_addr().expect("an address");
        let said: Arc<Mutex<Vec<String>>> = Arc::default();
        let heard = Arc::clone(&said);
        let say = move |line: &str| heard.lock().expect("nobody panicked").push(line.to_owned());
        let expected = ExpectedSender { address: None, token: token.map(str::to_owned) };
        let settings = WireMotion { address: free, lag_s: 0.0, line: LINE_ALONG_X, expected };
        let motion = CommandedMotion::by_wire(settings, Box::new(say)).expect("it listens");
        let sender = UdpSocket::bind(any).expect("a socket");
        sender.connect(free).expect("connected");
        Self { motion, sender, said }
    }

    fn send(&self, frame: &MotionFrame) {
        self.sender.send(&frame.to_bytes()).expect("sent");
    }

    /// Waits until the counters fulfil `done`, 5 s at most, and returns them.
    fn counts(&self, done: impl Fn(&StampedCounts) -> bool) -> StampedCounts {
        let begun = Instant::now();
        loop {
            let counts = self.motion.turns().stamped;
            if done(&counts) {
                return counts;
            }
            assert!(begun.elapsed() < Duration::from_secs(5), "{counts:?} {:?}", self.said);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn has_said(&self, words: &str) -> bool {
        self.said.lock().expect("nobody panicked").iter().any(|line| line.contains(words))
    }
}

fn now_ns() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970").as_nanos() as u64
}

fn frame(sequence: u32, stamp_ns: u64) -> MotionFrame {
    MotionFrame {
        clock: StampClock::Host,
        sequence,
        stamp_ns,
        position_m: [0.0; 3],
        velocity_m_s: None,
        acceleration_m_s2: Some([1.0, 0.0, 0.0]),
    }
}

#[test]
fn late_lost_stale_and_future_samples_are_counted_and_named() {
    let listening = Listening::start(None);
    let begun_ns = now_ns();
    // Number 3 comes behind number 4, number 6 never.
    for sequence in [1, 2, 4, 3, 5, 7] {
        listening.send(&frame(sequence, begun_ns + u64::from(sequence) * 1_000_000));
    }
    let counts = listening.counts(|counts| counts.taken == 6);
    assert_eq!((counts.late, counts.lost, counts.across), (1, 1, 0), "{counts:?}");
    listening.send(&frame(8, now_ns() - 2_000_000_000));
    listening.send(&frame(9, now_ns() + 2_000_000_000));
    listening.send(&frame(7, begun_ns + 7_000_000));
    listening.send(&MotionFrame { position_m: [0.0, 0.004, 0.0], ..frame(10, begun_ns + 10_000_000) });
    let counts = listening.counts(|counts| counts.across == 1);
    assert_eq!((counts.stale, counts.future, counts.repeated, counts.taken), (1, 1, 1, 7), "{counts:?}");
    for words in ["s ago was refused", "s ahead was refused", "leaves the line that the model knows"] {
        assert!(listening.has_said(words), "{words}: {:?}", listening.said);
    }
    // A version that nobody knows yet.
    let mut newer = frame(11, now_ns()).to_bytes();
    newer[4] = 2;
    listening.sender.send(&newer).expect("sent");
    listening.counts(|counts| counts.malformed == 1);
    assert!(listening.has_said("it has version 2, and this program reads version 1"));
    // Then the sender falls silent, and goes on.
    listening.counts(|counts| counts.stops == 1);
    assert!(listening.has_said("the stamped motion has stopped"));
    listening.send(&frame(12, now_ns()));
    listening.counts(|counts| counts.taken == 8);
}

#[test]
fn a_clock_of_the_senders_own_is_mapped_and_its_step_is_counted() {
    let listening = Listening::start(None);
    let begun = Instant::now();
    let mut sequence = 0;
    let mut send_for = |seconds: f64, ahead_ns: u64| {
        let until = Instant::now() + Duration::from_secs_f64(seconds);
        while Instant::now() < until {
            sequence += 1;
            let stamp_ns = begun.elapsed().as_nanos() as u64 + ahead_ns;
            listening.send(&MotionFrame { clock: StampClock::Sender, ..frame(sequence, stamp_ns) });
            std::thread::sleep(Duration::from_millis(4));
        }
        sequence
    };
    let sent = send_for(0.8, 77_000_000_000);
    let counts = listening.counts(|counts| counts.taken + counts.late + 20 > u64::from(sent));
    assert_eq!((counts.clock_steps, counts.stale, counts.future), (0, 0, 0), "{counts:?}");
    send_for(0.3, 99_000_000_000);
    listening.counts(|counts| counts.clock_steps == 1);
    assert!(listening.has_said("the clock of the motion's sender has stepped"));
}

#[test]
fn a_second_sender_and_a_wrong_token_are_not_heard() {
    let listening = Listening::start(Some("0123456789abcdef"));
    let with = |token: &str, sequence| {
        let bytes = [token.as_bytes(), b" ", &frame(sequence, now_ns()).to_bytes()].concat();
        listening.sender.send(&bytes).expect("sent");
    };
    with("0123456789abcdeX", 1);
    with("0123456789abcdef", 2);
    let counts = listening.counts(|counts| counts.taken == 1);
    assert_eq!(counts.malformed, 0);
    let refused = listening.motion.turns().refused;
    assert_eq!(refused, 1, "the wrong token");
    // Another one with the right token, while the first one goes on.
    let second = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let there = listening.sender.peer_addr().expect("connected");
    for sequence in 0..50 {
        let bytes = [b"0123456789abcdef ", &frame(1000 + sequence, now_ns()).to_bytes()[..]].concat();
        let _sent = second.send_to(&bytes, there);
        with("0123456789abcdef", 3 + sequence);
        std::thread::sleep(Duration::from_millis(2));
    }
    let counts = listening.counts(|counts| counts.taken >= 45);
    assert!(counts.taken <= 51 && counts.lost == 0, "the second one moved nothing: {counts:?}");
}
