//! Attacks on the live page, the Foxglove server and the Unix socket.

use crate::server::{ask, frame, taken};
use crate::support::{LOOPBACK, beside_turns, blob, connect_from};
use meniscus::blob::Model;
use meniscus::surface::{Config, Settings};
use meniscus_service::publish::{Destination, Publisher, READERS_MAX};
use meniscus_ui::foxglove::{Foxglove, Listen};
use meniscus_ui::page::{Page, VIEWERS_EACH, VIEWERS_MAX};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::net::UnixStream;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tungstenite::{Message, WebSocket};

fn config() -> Config {
    Config::new(Settings::default()).expect("sound")
}

/// An open page without a token, attacked beside a worker.
fn attack_page(attack: impl FnOnce(SocketAddr, &Page) + Send) {
    let bytes = blob();
    let model = Model::load(&bytes).expect("sound");
    let page = Page::open(&model, config(), "a test", LOOPBACK.into(), None).expect("it opens");
    let address = page.address();
    beside_turns(&page, || attack(address, &page));
}

/// An open Foxglove server, attacked beside a worker.
fn attack_foxglove(origins: &[&str], attack: impl FnOnce(SocketAddr) + Send) {
    let origins = origins.iter().map(|origin| (*origin).to_owned()).collect();
    let listen = Listen { address: LOOPBACK.into(), origins };
    let foxglove = Foxglove::open(config(), Some(&listen), None).expect("it opens");
    let address = SocketAddr::from(([127, 0, 0, 1], foxglove.port().expect("a server")));
    beside_turns(&foxglove, || attack(address));
}

/// The head of a request to change to a web socket, without `Host` and `Origin`.
fn upgrade(path: &str) -> String {
    format!(
        "GET {path} HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n"
    )
}

/// The status that a server answers an upgrade with; the connection is ended then.
fn status(address: SocketAddr, path: &str, headers: &str) -> u16 {
    let mut stream = connect_from(1, address);
    write!(stream, "{}{headers}\r\n", upgrade(path)).expect("sent");
    let mut first = [0; 12];
    stream.read_exact(&mut first).expect("an answer");
    String::from_utf8_lossy(&first[9..]).parse().expect("a status")
}

/// A viewer of the page from 127.0.0.`last`.
fn viewer(last: u8, address: SocketAddr) -> Result<WebSocket<TcpStream>, u16> {
    match tungstenite::client(format!("ws://{address}/live"), connect_from(last, address)) {
        Ok((socket, _)) => Ok(socket),
        Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(response))) => {
            Err(response.status().as_u16())
        }
        // A connection that ends without an answer.
        Err(_) => Err(0),
    }
}

/// Heads of senders that no server may answer with a stream, and the status that they get.
fn foreign(own: &str) -> Vec<(String, u16)> {
    let host = format!("Host: {own}\r\n");
    vec![
        (format!("{host}Origin: http://evil.example\r\n"), 403),
        (format!("{host}Origin: foo://{own}\r\n"), 403),
        (format!("{host}Origin: null\r\n"), 403),
        (format!("{host}Origin: file://\r\n"), 403),
        (format!("{host}Origin: https://app.foxglove.dev.evil.example\r\n"), 403),
        (format!("{host}Origin: http://{own}\r\nOrigin: http://evil.example\r\n"), 400),
        (format!("{host}{host}"), 400),
        (format!("{host}Host: evil.example\r\n"), 400),
        ("Host: evil.example\r\n".into(), 403),
        ("Host: evil.example\r\nOrigin: http://evil.example\r\n".into(), 403),
        (String::new(), 400),
    ]
}

/// No page of another web site reads the live page.
///
/// Foreign and malformed `Origin` and `Host`, two of either, foreign schemes, DNS rebinding.
#[test]
fn the_live_page_refuses_foreign_senders() {
    attack_page(|address, _| {
        for (headers, refused) in foreign(&address.to_string()) {
            assert_eq!(status(address, "/live", &headers), refused, "{headers}");
        }
        let own = format!("Host: {address}\r\nOrigin: http://{address}\r\n");
        assert_eq!(status(address, "/live", &own), 101, "the page itself");
    });
}

/// No page of another web site reads the Foxglove server.
///
/// The same heads as for the live page, an origin that only looks like Foxglove's, and one that was not named.
#[test]
fn the_foxglove_server_refuses_foreign_senders() {
    attack_foxglove(&["http://own.example"], |address| {
        for (headers, refused) in foreign(&address.to_string()) {
            assert_eq!(status(address, "/", &headers), refused, "{headers}");
        }
        for origin in ["https://app.foxglove.dev", "http://own.example"] {
            let known = format!("Host: localhost:{}\r\nOrigin: {origin}\r\n", address.port());
            assert_eq!(status(address, "/", &known), 101, "{origin}");
        }
        assert_eq!(status(address, "/", &format!("Host: {address}\r\n")), 101, "a program");
    });
}

/// The SDK's own server, which checks nobody, is not at an address that a page can guess.
///
/// Every listening port of this process on 127.0.0.1 is asked; only the gate may answer.
#[test]
fn the_foxglove_server_has_no_second_entrance() {
    attack_foxglove(&[], |address| {
        let table = std::fs::read_to_string("/proc/net/tcp").expect("Linux");
        let ports = table.lines().skip(1).filter_map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            let (ip, port) = fields.get(1)?.split_once(':')?;
            let listens = fields.get(3) == Some(&"0A") && matches!(ip, "0100007F" | "00000000");
            u16::from_str_radix(port, 16).ok().filter(|_| listens)
        });
        let mut asked = 0;
        for port in ports {
            let at = SocketAddr::from(([127, 0, 0, 1], port));
            let Ok(mut stream) = TcpStream::connect(at) else { continue };
            stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
            let _sent = write!(stream, "{}Host: {at}\r\nOrigin: http://evil.example\r\n\r\n", upgrade("/"));
            let mut answer = [0; 512];
            let length = stream.read(&mut answer).unwrap_or(0);
            let text = String::from_utf8_lossy(&answer[..length]).into_owned();
            assert!(!text.contains("foxglove.sdk"), "port {port} answers a foreign page: {text}");
            asked += u32::from(port == address.port());
        }
        assert_eq!(asked, 1, "the gate itself is among them");
    });
}

/// A head of more than 8 KiB is refused at the byte.
///
/// A head of 9000 bytes that arrives in one piece.
#[test]
fn a_long_head_is_refused() {
    attack_page(|address, _| {
        let head = format!("GET / HTTP/1.1\r\nHost: {address}\r\nX: {}\r\n", "y".repeat(8950));
        assert_eq!(ask(address, &head).0, 431);
    });
}

/// Connections that send nothing, or a byte at a time, keep nobody from loading the page.
///
/// 64 silent and 64 trickling connections that come again whenever they are closed; 20 page loads from the same address.
#[test]
fn held_connections_keep_nobody_out() {
    attack_page(|address, _| {
        let over = std::sync::atomic::AtomicBool::new(false);
        let loads = std::thread::scope(|scope| {
            for trickles in (0..128).map(|number| number % 2 == 0) {
                let over = &over;
                std::thread::Builder::new()
                    .stack_size(128 * 1024)
                    .spawn_scoped(scope, move || {
                        while !over.load(Ordering::Relaxed) {
                            let Ok(mut stream) = TcpStream::connect(address) else { continue };
                            let _short = stream.set_read_timeout(Some(Duration::from_millis(100)));
                            let mut byte = [0];
                            while !over.load(Ordering::Relaxed) {
                                if trickles && stream.write_all(b"G").is_err() {
                                    break;
                                }
                                if matches!(stream.read(&mut byte), Ok(0)) {
                                    break;
                                }
                            }
                            std::thread::sleep(Duration::from_millis(20));
                        }
                    })
                    .expect("a thread");
            }
            std::thread::sleep(Duration::from_millis(500));
            let head = format!("GET / HTTP/1.1\r\nHost: {address}\r\n");
            let loads: Vec<_> = (0..20)
                .map(|_| {
                    let begun = Instant::now();
                    (ask(address, &head).0, begun.elapsed())
                })
                .collect();
            over.store(true, Ordering::Relaxed);
            loads
        });
        let good =
            loads.iter().filter(|(status, took)| *status == 200 && *took < Duration::from_secs(2)).count();
        assert!(good >= 19, "{good} of 20 page loads: {loads:?}");
    });
}

/// A viewer that only pings loses its place within six seconds.
///
/// Sockets that ping every 200 ms and never say that they took a frame hold all places of their address.
#[test]
fn pings_do_not_keep_a_place() {
    attack_page(|address, _| {
        let mut held: Vec<_> = (0..VIEWERS_EACH).map(|_| viewer(1, address).expect("let in")).collect();
        let begun = Instant::now();
        while !held.is_empty() && begun.elapsed() < Duration::from_secs(20) {
            held.retain_mut(|socket| socket.send(Message::Ping(b"x".to_vec().into())).is_ok());
            std::thread::sleep(Duration::from_millis(200));
        }
        let took = begun.elapsed();
        assert!(held.is_empty() && took < Duration::from_secs(8), "{} hold on after {took:?}", held.len());
        let mut newcomer = viewer(1, address).expect("there is room again");
        taken(&mut newcomer, 0, 60);
        assert!(frame(&mut newcomer).is_some());
    });
}

/// Viewers of one address leave room for a viewer of another.
///
/// Well-behaved viewers of two addresses take every place; a third address gets in, and the fullest one gives way.
#[test]
fn a_new_address_finds_room() {
    attack_page(|address, page| {
        let mut held: Vec<_> = (0..VIEWERS_EACH).map(|_| viewer(1, address).expect("let in")).collect();
        assert_eq!(viewer(1, address).err(), Some(503), "its share is taken");
        held.extend((held.len()..VIEWERS_MAX).map(|_| viewer(2, address).expect("let in")));
        for last in 3..6 {
            let mut newcomer = viewer(last, address).expect("a new address");
            taken(&mut newcomer, 0, 60);
            assert!(frame(&mut newcomer).is_some(), "127.0.0.{last}");
            held.push(newcomer);
        }
        assert!(page.counters().came.load(Ordering::Relaxed) >= VIEWERS_MAX as u64 + 3);
    });
}

/// Readers of the Unix socket cannot use up the descriptors of the process.
///
/// 300 readers that read nothing: 32 are kept, the others get one line that says why.
#[test]
fn silent_readers_do_not_use_up_descriptors() {
    let path = std::env::temp_dir().join(format!("meniscus-attack-{}.sock", std::process::id()));
    let bytes = blob();
    let header = Model::load(&bytes).expect("sound").header.clone();
    let (outlet, publisher) =
        Publisher::start(&[Destination::Unix(path.clone())], &header, 0.0, 0).expect("it opens");
    let mut readers: Vec<_> = (0..300)
        .map(|_| {
            let reader = UnixStream::connect(&path).expect("it listens");
            reader.set_read_timeout(Some(Duration::from_millis(500))).expect("a timeout");
            reader
        })
        .collect();
    let counters = std::sync::Arc::clone(&outlet.counters);
    let begun = Instant::now();
    let refused = || counters.readers_refused.load(Ordering::Relaxed) as usize;
    while refused() < 300 - READERS_MAX && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(refused(), 300 - READERS_MAX);
    let mut words = String::new();
    readers[299].read_to_string(&mut words).expect("a line, then the end");
    assert!(words.contains("32 readers are connected, which is the limit"), "{words}");
    // Whoever goes makes room for another, although no record has found that out yet.
    readers.clear();
    let mut late = UnixStream::connect(&path).expect("it listens");
    late.set_read_timeout(Some(Duration::from_millis(300))).expect("a timeout");
    let kept = late.read(&mut [0; 16]).expect_err("kept, and no record comes").kind();
    assert!(matches!(kept, std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut), "{kept}");
    drop(outlet);
    publisher.finish();
}
