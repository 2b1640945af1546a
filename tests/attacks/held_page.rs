//! Attacks that hold the live page: its connections, its places, its patience.

use crate::pages::{attack_page, viewer};
use crate::server::{ask, frame, taken};
use meniscus_ui::page::{VIEWERS_EACH, VIEWERS_MAX};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tungstenite::Message;

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
