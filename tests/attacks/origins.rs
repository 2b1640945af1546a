//! Attacks by pages of other web sites in the browser of somebody who may watch.

use crate::pages::{attack_foxglove, attack_page, status, upgrade};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

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
