//! Attacks by datagrams that are no motion and no plan.

use crate::support::Scratch;
use meniscus_service::commanded_motion::{
    CommandedMotion, ExpectedSender, LINE_ALONG_X, MotionFrame, StampClock, WireMotion,
};
use meniscus_service::controller::Plan;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use std::net::{SocketAddr, UdpSocket};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A port that was free a moment ago.
fn free_port() -> SocketAddr {
    let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket");
    socket.local_addr().expect("an address")
}

/// A sound frame of motion.
fn frame(sequence: u32) -> MotionFrame {
    MotionFrame {
        clock: StampClock::Sender,
        sequence,
        stamp_ns: 1_000_000_000 + u64::from(sequence) * 4_000_000,
        position_m: [0.01, 0.0, 0.0],
        velocity_m_s: Some([0.0; 3]),
        acceleration_m_s2: Some([0.5, 0.0, 0.0]),
    }
}

/// Datagrams that no listener may take: wrong lengths, versions and flags, numbers that are none or out of range, text that is
/// none, noise up to the longest datagram.
fn malformed(random: &mut ChaCha8Rng, sequence: u32) -> Vec<u8> {
    let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e6][random.random_range(0..5_usize)];
    let sound = frame(sequence).to_bytes();
    match random.random_range(0..8) {
        0 => {
            let length = random.random_range(0..sound.len());
            sound[..length].to_vec()
        }
        1 => {
            let mut all = frame(sequence);
            match random.random_range(0..3) {
                0 => all.position_m[1] = wrong,
                1 => all.velocity_m_s = Some([0.0, 0.0, wrong]),
                _ => all.acceleration_m_s2 = Some([wrong, 0.0, 0.0]),
            }
            all.to_bytes()
        }
        2 => [sound, vec![0; random.random_range(1..200)]].concat(),
        3 => {
            let mut other = sound;
            other[4] = random.random_range(2..255);
            other
        }
        4 => {
            let mut other = sound;
            other[5] = 8 << random.random_range(0..5);
            other
        }
        5 => format!("#{} {wrong}", random.random::<u64>()).into_bytes(),
        6 => format!("{wrong} {wrong} \u{0} \u{fffd}").into_bytes(),
        _ => {
            let mut noise = vec![0; [0, 1, 19, 20, 255, 256, 257, 65_507][random.random_range(0..8_usize)]];
            random.fill_bytes(&mut noise);
            // Noise is neither a frame nor a number.
            noise.iter_mut().take(1).for_each(|byte| *byte = 0xff);
            noise
        }
    }
}

/// A datagram that is no motion changes nothing and ends nothing.
///
/// A run of six seconds that gets 3000 malformed datagrams a second where it listens for motion and for plans.
#[test]
fn malformed_datagrams_change_nothing() {
    let scratch = Scratch::new("datagrams");
    let (motion, plans) = (free_port(), free_port());
    let run = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["run", "--seconds", "6", "--json", "--out", "out", "--controller", "--publish", "unix:s"])
        .args(["--motion", &format!("udp:{motion}"), "--plan", &format!("udp:{plans}")])
        .current_dir(&scratch.0)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let over = AtomicBool::new(false);
    let output = std::thread::scope(|scope| {
        scope.spawn(|| {
            let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket");
            let mut random = ChaCha8Rng::seed_from_u64(1);
            for sequence in 0_u32.. {
                if over.load(Ordering::Relaxed) {
                    break;
                }
                let bytes = malformed(&mut random, sequence);
                let _nobody_yet = socket.send_to(&bytes, motion);
                let _nobody_yet = socket.send_to(&bytes, plans);
                if sequence.is_multiple_of(3) {
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
        });
        let output = run.wait_with_output().expect("it ends");
        over.store(true, Ordering::Relaxed);
        output
    });
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|why| panic!("{why}: {said}"));
    assert_eq!(report["motion"]["commanded"], 0, "{report:#}");
    assert!(report["motion"]["refused"].as_u64() > Some(100), "{:#}", report["motion"]);
    assert!(!said.contains("panicked"), "{said}");
}

/// No malformed frame or number is taken for a sample.
///
/// 20,000 malformed datagrams to the listener, and a sound one behind them, which is taken.
#[test]
fn no_malformed_datagram_is_a_sample() {
    let address = free_port();
    let settings =
        WireMotion { address, lag_s: 0.0, line: LINE_ALONG_X, expected: ExpectedSender::default() };
    let motion = CommandedMotion::by_wire(settings, Box::new(|_| {})).expect("it listens");
    let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket");
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let samples = || motion.counters.samples.load(Ordering::Relaxed);
    for sequence in 0..20_000_u32 {
        let bytes = malformed(&mut random, sequence);
        socket.send_to(&bytes, address).expect("sent");
        if sequence.is_multiple_of(100) {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(samples(), 0, "a malformed datagram was taken");
    let heard = motion.counters.refused.load(Ordering::Relaxed);
    assert!(heard > 2_000, "{heard} of them were read at all");
    socket.send_to(b"0.5", address).expect("sent");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(samples(), 1, "the sound one behind them");
}

/// Refused plans do not fill the log.
///
/// 200 plans a second with a number that is none, for three seconds.
#[test]
fn refused_plans_do_not_fill_the_log() {
    let scratch = Scratch::new("plans");
    let plans = free_port();
    let run = Command::new(env!("CARGO_BIN_EXE_meniscus-under-test"))
        .args(["run", "--seconds", "4", "--json", "--out", "out", "--controller", "--publish", "unix:s"])
        .args(["--plan", &format!("udp:{plans}")])
        .current_dir(&scratch.0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let socket = UdpSocket::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a socket");
    let points: Vec<(u64, [f64; 3])> = (0..20).map(|n| (n * 4_000_000, [f64::NAN, 0.0, 0.0])).collect();
    for sequence in 0..800 {
        let _nobody_yet = socket.send_to(&Plan::to_bytes(sequence, &points), plans);
        std::thread::sleep(Duration::from_millis(5));
    }
    let output = run.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let lines = said.lines().filter(|line| line.contains("a plan was refused")).count();
    assert!(output.status.success() && (1..=6).contains(&lines), "{lines} lines: {said}");
}
