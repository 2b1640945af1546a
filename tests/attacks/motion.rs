//! Attacks on `--motion udp:`.

use meniscus_service::commanded_motion::{CommandedMotion, ExpectedSender, LINE_ALONG_X, WireMotion};
use serde_json::Value;
use std::net::{SocketAddr, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A port that was free a moment ago.
fn free_port() -> SocketAddr {
    UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0)))
        .expect("a socket")
        .local_addr()
        .expect("an address")
}

/// A socket at 127.0.0.`last`.
fn socket(last: u8) -> UdpSocket {
    UdpSocket::bind(SocketAddr::from(([127, 0, 0, last], 0))).expect("a loopback address")
}

/// A listener for `expected` at a free port.
fn listener(expected: ExpectedSender) -> (CommandedMotion, SocketAddr) {
    let address = free_port();
    let settings = WireMotion { address, lag_s: 0.0, line: LINE_ALONG_X, expected };
    (CommandedMotion::by_wire(settings, Box::new(|_| {})).expect("it listens"), address)
}

fn count(counter: &AtomicU64) -> u64 {
    counter.load(Ordering::Relaxed)
}

/// Waits until `done`, for 5 s at most.
fn wait_for(done: impl Fn() -> bool) {
    let begun = Instant::now();
    while !done() && begun.elapsed() < Duration::from_secs(5) {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A run of 6 s of the simulated camera with more `arguments`, and its report.
struct Run(Child);

impl Run {
    fn start(name: &str, arguments: &[&str]) -> Self {
        let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("attack-motion-{name}"));
        let child = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
            .args(["run", "--seconds", "6", "--json", "--out"])
            .arg(folder)
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn();
        Self(child.expect("it starts"))
    }

    fn report(self) -> (Value, String) {
        let output = self.0.wait_with_output().expect("it ends");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        (serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{why}: {said}")), said)
    }
}

/// A process that sends false accelerations does not move the estimated glass.
///
/// 150 and -150 m/s2 in turn, 250 times a second. No turn uses them, and the velocity is as without them.
#[test]
fn a_lie_about_the_motion_is_dropped() {
    let (plain, _) = Run::start("plain", &[]).report();
    let address = free_port();
    let run = Run::start("lie", &["--motion", &format!("udp:{address}")]);
    let over = AtomicBool::new(false);
    let (lied, said) = std::thread::scope(|scope| {
        scope.spawn(|| {
            let (socket, mut sign) = (socket(1), 1.0);
            while !over.load(Ordering::Relaxed) {
                let _nobody_yet = socket.send_to(format!("{}", 150.0 * sign).as_bytes(), address);
                sign = -sign;
                std::thread::sleep(Duration::from_millis(4));
            }
        });
        let report = run.report();
        over.store(true, Ordering::Relaxed);
        report
    });
    assert_eq!(lied["motion"]["commanded"], 0, "{lied:#}");
    let error = |report: &Value| report["field_error"]["v"].as_f64().expect("scored");
    let coasted = |report: &Value| report["modes"]["coasting"].as_u64().expect("a count");
    // On a machine that is too slow for 60 Hz both are errors of lost frames.
    let (with, without) = (error(&lied), error(&plain));
    let slow = coasted(&plain) + coasted(&lied) > 0;
    assert!(slow || with < 1.5 * without + 0.02, "{with} with the lie, {without} without");
    assert!(lied["motion"]["contradictions"].as_u64() >= Some(1), "{lied:#}");
    assert!(said.contains("is not that of the glass in the image"), "{said}");
}

/// A flood from other senders pushes no sample of the true one out.
///
/// Three senders of zeros as fast as they can, from the same address and from another; the true one sends 250 a second.
#[test]
fn a_flood_does_not_push_out_true_samples() {
    let (motion, address) = listener(ExpectedSender::default());
    let (sender, over) = (socket(1), AtomicBool::new(false));
    sender.send_to(b"#0 0.5", address).expect("sent");
    wait_for(|| count(&motion.counters.samples) == 1);
    let sent = std::thread::scope(|scope| {
        for last in [1, 1, 2] {
            let over = &over;
            scope.spawn(move || {
                let flood = socket(last);
                while !over.load(Ordering::Relaxed) {
                    let _lost = flood.send_to(b"0", address);
                }
            });
        }
        std::thread::sleep(Duration::from_millis(200));
        for number in 1..=500 {
            sender.send_to(format!("#{number} 0.5").as_bytes(), address).expect("sent");
            std::thread::sleep(Duration::from_millis(4));
        }
        over.store(true, Ordering::Relaxed);
        501
    });
    wait_for(|| count(&motion.counters.samples) >= sent);
    let taken = count(&motion.counters.samples);
    assert!(taken <= sent && taken >= sent - 10, "{taken} of {sent}");
}

/// Only the sender that was named is heard.
///
/// Good datagrams from another address, then from the named one.
#[test]
fn another_address_is_not_heard() {
    let address = Some(([127, 0, 0, 7]).into());
    let (motion, to) = listener(ExpectedSender { address, token: None });
    for number in 1..=10 {
        socket(8).send_to(format!("#{number} 1").as_bytes(), to).expect("sent");
    }
    wait_for(|| count(&motion.counters.strangers) == 10);
    assert_eq!((count(&motion.counters.strangers), count(&motion.counters.samples)), (10, 0));
    socket(7).send_to(b"#1 1", to).expect("sent");
    wait_for(|| count(&motion.counters.samples) == 1);
    assert_eq!(count(&motion.counters.samples), 1);
}

/// Without the token, or with an old number, a datagram is not heard.
///
/// No token, wrong ones, a number twice, and numbers that fall.
#[test]
fn wrong_tokens_and_repeated_numbers_are_not_heard() {
    let token = Some("0123456789abcdef".to_owned());
    let (motion, to) = listener(ExpectedSender { address: None, token });
    let sender = socket(1);
    let wrong = ["1", "#1 1", "0123456789abcdee #1 1", "0123456789abcdef0 #1 1", "0123456789abcdef #x 1"];
    let repeated =
        ["0123456789abcdef #5 1", "0123456789abcdef #5 2", "0123456789abcdef #4 2", "0123456789abcdef 2"];
    for text in wrong.iter().chain(&repeated) {
        sender.send_to(text.as_bytes(), to).expect("sent");
    }
    wait_for(|| count(&motion.counters.refused) == 8);
    assert_eq!((count(&motion.counters.refused), count(&motion.counters.samples)), (8, 1));
}

/// A port that others reach needs a sender's address or a token.
///
/// `run --motion udp:0.0.0.0:PORT` without either.
#[test]
fn an_open_port_without_a_sender_is_refused() {
    let output = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["run", "--seconds", "2", "--motion", "udp:0.0.0.0:0"])
        .output()
        .expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains("--motion-from ADDRESS"), "{said}");
}
