//! Estimates for others: whole records, in order, to everybody who reads, and nobody is waited for.

#[path = "support/optional.rs"]
mod optional;

use meniscus::blob::{FieldGroup, Header, KnownGroups, Model};
use meniscus::latent::generic::Audit;
use meniscus::runtime::output::{HostTime, Packet};
use meniscus::runtime::{Estimate, Mode, Stages, Turn};
use meniscus::uncertainty::intervals::Interval;
use meniscus::uncertainty::latent_covariance::LatentCovariance;
use meniscus::units::Micros;
use meniscus_platform::files::AlignedBytes;
use meniscus_service::publish::{Destination, FIELD_KIND, FieldFrame, PublishOutlet, Publisher};
use meniscus_service::sink::{TurnRecord, TurnSink};
use meniscus_service::timed_turn::TimedTurn;
use std::io::{BufRead, BufReader};
use std::net::UdpSocket;
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

const FIELD: usize = 27_742;

/// Host time of every turn.
const HOST: HostTime = HostTime { unix_ns: 1_790_000_000_000_000_000, std_ns: 9_600_000, latency_us: 17_000 };

/// Header of the shipped model as its fourth version, whose shear stresses belong to another liquid.
fn header() -> Header {
    let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
    let header = Model::load(&bytes).expect("the shipped model").header.clone();
    let known = FieldGroup::ALL[..4].iter().copied().fold(KnownGroups::NONE, KnownGroups::with);
    Header { model_version: 4, stated_known: known.with(FieldGroup::Surface), ..header }
}

fn turn(n: u64) -> Turn {
    let estimate = Estimate {
        mode: Mode::Tracking,
        latent: [n as f64; 13],
        covariance: LatentCovariance::from_fn(|row, column| (n as f32) / (1 + row + column) as f32),
        surface_m: [0.07; 21],
        interval: Interval::default(),
        acceleration_m_s2: 0.0,
        port: 0.0,
        slosh_j: 0.0,
        heat_j: 0.0,
        corrected_j: 0.0,
        audit: Audit::default(),
        field_fresh: true,
        stages: Stages::default(),
    };
    Turn { time: Micros(n), stamp: None, profile: None, estimate }
}

/// Hands turn `n` to the publisher, as the worker does.
fn hand(outlet: &mut PublishOutlet, n: u64, field: &[f32]) {
    let logged = TimedTurn { host: Some(HOST), ..TimedTurn::untimed(turn(n)) };
    outlet.accept(&TurnRecord { logged: &logged, field, after: None });
}

fn socket(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("meniscus-{}-{name}.sock", std::process::id()))
}

fn reader(path: &PathBuf) -> BufReader<UnixStream> {
    let stream = UnixStream::connect(path).expect("the socket is there from the start");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    BufReader::new(stream)
}

/// The next record of a stream; `None` at its end.
fn record(reader: &mut impl BufRead) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.read_until(0, &mut bytes).expect("a record in time");
    if bytes.is_empty() {
        return None;
    }
    let length = cobs(&mut bytes);
    bytes.truncate(length);
    Some(bytes)
}

/// Takes the stuffing out in place; postcard does it only together with reading.
fn cobs(bytes: &mut [u8]) -> usize {
    let (mut from, mut to) = (0, 0);
    while bytes[from] != 0 {
        let code = usize::from(bytes[from]);
        for k in 1..code {
            bytes[to] = bytes[from + k];
            to += 1;
        }
        from += code;
        if code < 255 && bytes[from] != 0 {
            bytes[to] = 0;
            to += 1;
        }
    }
    to
}

#[test]
fn every_reader_gets_whole_records_in_order() {
    let path = socket("order");
    let udp = UdpSocket::bind("127.0.0.1:0").expect("a port");
    udp.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    let there = [Destination::Unix(path.clone()), Destination::Udp(udp.local_addr().expect("an address"))];
    let (mut outlet, publisher) = Publisher::start(&there, &header(), 0.0, FIELD).expect("both open");
    let mut reader = reader(&path);
    let mut datagram = [0; 2048];
    // The publisher lets a reader in before it sends the next record.
    for n in 1..=40 {
        hand(&mut outlet, n, &[]);
        let length = udp.recv(&mut datagram).expect("a datagram in time");
        assert_eq!(Packet::read(&datagram[..length]).expect("a packet").time, Micros(n));
        let mut packet = Packet::read(&record(&mut reader).expect("a record")).expect("a packet");
        let host = packet.host.expect("a host time");
        assert_eq!((packet.number, packet.time), (n - 1, Micros(n)));
        assert_eq!((host.unix_ns, host.std_ns), (HOST.unix_ns, HOST.std_ns));
        // The time since the turn counts, too.
        assert!((HOST.latency_us..HOST.latency_us + 20_000_000).contains(&host.latency_us), "{host:?}");
        // The shear stresses belong to another liquid.
        let half = std::mem::take(&mut packet.estimate.interval.field[4]);
        assert!(half.is_nan(), "{half}");
        assert_eq!(packet.estimate, turn(n).estimate);
        assert_eq!((packet.model_version, packet.known), (4, header().known()));
    }
    let counters = std::sync::Arc::clone(&outlet.counters);
    drop(outlet);
    publisher.finish();
    assert!(record(&mut reader).is_none(), "the stream ends with the run");
    assert!(!path.exists(), "the socket's file goes with the run");
    assert_eq!(counters.sent.load(Ordering::Relaxed), 80);
    assert_eq!(counters.queue_full.load(Ordering::Relaxed), 0);
}

/// A reader that never reads loses records, and the one beside it none that it had room for; the hand-over
/// comes back each time, or this test would not end.
#[test]
fn a_slow_reader_holds_up_nobody() {
    let path = socket("slow");
    let (mut outlet, publisher) =
        Publisher::start(&[Destination::Unix(path.clone())], &header(), 1000.0, FIELD).expect("it opens");
    let idle = UnixStream::connect(&path).expect("a reader");
    let mut busy = reader(&path);
    let field: Vec<f32> = (0..FIELD).map(|k| k as f32).collect();
    let (mut fields, mut last, mut n) = (0, 0, 0);
    let counters = std::sync::Arc::clone(&outlet.counters);
    let slow = || counters.reader_slow.load(Ordering::Relaxed);
    // Of how many turns a field is sent is up to the scheduler: go on until enough were, for as long as a hundred
    // times the turns that it takes on a machine that does nothing else.
    while slow() <= 100 || fields <= 10 {
        n += 1;
        assert!(n <= 40_000, "{} records had no room, {fields} fields came", slow());
        hand(&mut outlet, n, &field);
        // Read until this turn's record has come: fields lie between.
        while last < n {
            let bytes = record(&mut busy).expect("a record");
            if bytes[0] == FIELD_KIND {
                let frame: FieldFrame = postcard::from_bytes(&bytes).expect("a field");
                // Ten of 13 numbers a tracer: the model is not valid for the shear stresses.
                assert_eq!(frame.field, field[..FIELD / 13 * 10]);
                assert_eq!((frame.number + 1, frame.host), (frame.time.0, Some(HOST)));
                fields += 1;
            } else {
                last = Packet::read(&bytes).expect("a packet").time.0;
            }
        }
    }
    drop((outlet, idle));
    publisher.finish();
}

/// Of a corrected model the socket has positions and heights; the packet says which groups, and its other half-widths and
/// energies are not numbers.
#[test]
fn the_socket_has_no_number_of_an_unknown_group() {
    let path = socket("corrected");
    let header = Header { stated_known: KnownGroups::KINEMATICS, ..header() };
    let (mut outlet, publisher) =
        Publisher::start(&[Destination::Unix(path.clone())], &header, 1000.0, FIELD).expect("it opens");
    let mut reader = reader(&path);
    let field: Vec<f32> = (0..FIELD).map(|k| k as f32).collect();
    let (mut fields, mut n) = (0, 0);
    while fields < 3 {
        n += 1;
        assert!(n <= 40_000, "{fields} fields came");
        hand(&mut outlet, n, &field);
        loop {
            let bytes = record(&mut reader).expect("a record");
            if bytes[0] == FIELD_KIND {
                let frame: FieldFrame = postcard::from_bytes(&bytes).expect("a field");
                assert_eq!(frame.groups, KnownGroups::KINEMATICS);
                assert_eq!(frame.field, field[..FIELD / 13 * 3], "positions alone");
                fields += 1;
                continue;
            }
            let Packet { time, known, estimate, .. } = Packet::read(&bytes).expect("a packet");
            assert_eq!(known, KnownGroups::KINEMATICS);
            let half = estimate.interval.field;
            assert!(half[0].is_finite() && half[1..].iter().all(|half| half.is_nan()), "{half:?}");
            assert!(estimate.slosh_j.is_nan() && estimate.heat_j.is_nan() && estimate.audit.heat.is_nan());
            assert_eq!(estimate.surface_m, [0.07; 21]);
            if time.0 == n {
                break;
            }
        }
    }
    drop(outlet);
    publisher.finish();
}

#[test]
fn a_destination_that_cannot_be_is_refused_with_a_remedy() {
    let path = socket("taken");
    std::fs::write(&path, "not a socket").expect("written");
    let refused = |there: Destination| {
        let error = Publisher::start(&[there], &header(), 0.0, 0).expect_err("refused");
        format!("{error}")
    };
    let message = refused(Destination::Unix(path.clone()));
    assert!(message.contains("no socket lies there. What to do: choose another path"), "{message}");
    assert_eq!(std::fs::read_to_string(&path).expect("still there"), "not a socket");
    std::fs::remove_file(&path).expect("removed");
    let message = refused(Destination::Unix("/nowhere/at/all.sock".into()));
    assert!(message.contains("What to do: make the folder"), "{message}");
    let message = refused(Destination::Serial("/dev/null".into(), 9600));
    assert!(message.contains("name a serial device"), "{message}");
}

/// The Python client of the examples reads the published estimates; skipped without Python, which fails in CI.
#[test]
fn the_python_client_reads_it() {
    let client = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/client.py");
    if std::process::Command::new("python3").arg("--version").output().is_err() {
        return optional::skip("python3 is not there");
    }
    let path = socket("python");
    let (mut outlet, publisher) =
        Publisher::start(&[Destination::Unix(path.clone())], &header(), 0.0, FIELD).expect("it opens");
    let child = std::process::Command::new("python3")
        .args([client, &path.display().to_string(), "--count", "3"])
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("python3 starts");
    let mut n = 0;
    let mut child = child;
    while child.try_wait().expect("its state").is_none() && n < 2000 {
        n += 1;
        hand(&mut outlet, n, &[]);
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().expect("its output");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}");
    assert_eq!(text.lines().count(), 3, "{text}");
    assert!(
        text.lines()
            .all(|line| line.contains("tracking") && line.contains("70.0 mm") && line.contains(" ms after")),
        "{text}"
    );
    drop(outlet);
    publisher.finish();
}
