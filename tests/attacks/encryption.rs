//! Attacks from the network between a browser and the encrypted page (`run --view --tls`). The clients are curl and openssl.

use crate::optional::skip;
use crate::support::{Scratch, meniscus_command};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// A run with an encrypted page; it ends with this value.
struct Encrypted {
    child: Child,
    /// Address and port.
    authority: String,
    /// The fingerprint that it printed.
    fingerprint: String,
}

impl Encrypted {
    /// Starts `run --view` at a port of its own with more `arguments`.
    fn start(folder: &Path, arguments: &[&str]) -> Self {
        let mut child = meniscus_command()
            .args(["run", "--view", "--listen", "127.0.0.1:0", "--out", "out"])
            .args(arguments)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let mut lines = BufReader::new(child.stderr.take().expect("piped")).lines().map_while(Result::ok);
        let mut value = |start: &str| {
            let line = lines.by_ref().find_map(|line| line.strip_prefix(start).map(str::to_owned));
            line.unwrap_or_else(|| panic!("no line '{start}'"))
        };
        let url = value("live page: https://");
        let fingerprint = value("SHA-256 of its certificate: ");
        std::thread::spawn(move || lines.for_each(drop));
        let authority = url.split('/').next().expect("an authority").to_owned();
        Self { child, authority, fingerprint }
    }

    /// Writes the certificate that the page shows as PEM to `to`; returns its fingerprint by openssl.
    fn certificate(&self, to: &Path) -> String {
        let shown = tool("openssl", &["s_client", "-connect", &self.authority]).stdout;
        std::fs::write(to, shown).expect("written");
        let path = to.to_str().expect("text");
        let printed = tool("openssl", &["x509", "-in", path, "-noout", "-fingerprint", "-sha256"]).stdout;
        let printed = String::from_utf8_lossy(&printed).trim().to_owned();
        printed.split_once('=').expect("a fingerprint").1.to_owned()
    }
}

impl Drop for Encrypted {
    fn drop(&mut self) {
        let _gone = self.child.kill();
        let _waited = self.child.wait();
    }
}

fn tool(name: &str, arguments: &[&str]) -> Output {
    Command::new(name).args(arguments).stdin(Stdio::null()).output().expect("it starts")
}

/// Whether a tool is missing; the test is skipped then, and fails in CI.
fn missing() -> bool {
    let absent = ["curl", "openssl"].into_iter().find(|name| {
        Command::new(name).arg("version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err()
    });
    absent.inspect(|name| skip(name)).is_some()
}

/// Writes a self-signed certificate for 127.0.0.1 and its key as openssl makes them.
fn make_certificate(folder: &Path, name: &str) {
    let (certificate, key) = (format!("{name}.pem"), format!("{name}.key"));
    let words = "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=board -addext subjectAltName=IP:127.0.0.1";
    let status = Command::new("openssl")
        .args(words.split(' '))
        .args(["-out", &certificate, "-keyout", &key])
        .current_dir(folder)
        .stderr(Stdio::null())
        .status();
    assert!(status.expect("openssl").success());
}

/// Passes everything on between clients and `to`, and keeps it.
fn listen_in(to: SocketAddr) -> (SocketAddr, Arc<Mutex<Vec<u8>>>) {
    let listener = TcpListener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).expect("a port");
    let (address, heard) = (listener.local_addr().expect("an address"), Arc::new(Mutex::new(Vec::new())));
    let kept = Arc::clone(&heard);
    std::thread::spawn(move || {
        for client in listener.incoming().flatten() {
            let server = TcpStream::connect(to).expect("the page");
            let pairs = [
                (client.try_clone().expect("a copy"), server.try_clone().expect("a copy")),
                (server, client),
            ];
            for (mut from, mut into) in pairs {
                let kept = Arc::clone(&kept);
                std::thread::spawn(move || {
                    let mut part = [0; 4096];
                    while let Ok(length @ 1..) = from.read(&mut part) {
                        kept.lock().expect("kept").extend_from_slice(&part[..length]);
                        if into.write_all(&part[..length]).is_err() {
                            break;
                        }
                    }
                    let _gone = into.shutdown(std::net::Shutdown::Write);
                });
            }
        }
    });
    (address, heard)
}

/// Whoever listens between browser and page learns neither the token nor the page.
///
/// A proxy that keeps every byte of a page load with the token in the address.
#[test]
fn a_listener_learns_neither_token_nor_page() {
    if missing() {
        return;
    }
    let scratch = Scratch::new("listener");
    let token = "0123456789abcdefghij";
    std::fs::write(scratch.0.join("token"), token).expect("written");
    make_certificate(&scratch.0, "a");
    let words = ["--tls-cert", "a.pem", "--tls-key", "a.key", "--token-file", "token"];
    let page = Encrypted::start(&scratch.0, &words);
    let (between, heard) = listen_in(page.authority.parse().expect("an address"));
    let certificate = scratch.0.join("a.pem");
    let url = format!("https://{between}/?token={token}");
    let loaded = tool("curl", &["-sS", "--cacert", certificate.to_str().expect("text"), &url]);
    let body = String::from_utf8_lossy(&loaded.stdout).into_owned();
    assert!(loaded.status.success() && body.contains("<title>"), "{loaded:?}");
    let heard = heard.lock().expect("kept");
    let contains = |words: &[u8]| heard.windows(words.len()).any(|part| part == words);
    assert!(heard.len() > body.len(), "the proxy has heard {} bytes", heard.len());
    assert!(!contains(token.as_bytes()) && !contains(b"<title>") && !contains(b"GET /"));
}

/// Somebody between who has another certificate is found out by the printed fingerprint.
///
/// A second page in the place of the first: another fingerprint, and curl refuses it by certificate and by public key.
#[test]
fn another_certificate_is_found_out() {
    if missing() {
        return;
    }
    let scratch = Scratch::new("between");
    let [own, other] = ["own", "other"].map(|name| {
        let folder = scratch.0.join(name);
        std::fs::create_dir(&folder).expect("a folder");
        Encrypted::start(&folder, &["--tls"])
    });
    let [known, foreign] = ["known.pem", "foreign.pem"].map(|name| scratch.0.join(name));
    assert_eq!(own.certificate(&known), own.fingerprint, "openssl reads what the run has printed");
    assert_eq!(other.certificate(&foreign), other.fingerprint);
    assert_ne!(own.fingerprint, other.fingerprint);
    let pin = |certificate: &Path| {
        let line = format!(
            "openssl x509 -in '{}' -pubkey -noout | openssl pkey -pubin -outform der | openssl dgst -sha256 -binary | base64",
            certificate.display()
        );
        let output = tool("sh", &["-c", &line]);
        format!("sha256//{}", String::from_utf8_lossy(&output.stdout).trim())
    };
    let (path, pin) = (known.to_str().expect("text"), pin(&known));
    for (page, good) in [(&own, true), (&other, false)] {
        let url = format!("https://{}/", page.authority);
        for words in [["--cacert", path], ["--pinnedpubkey", &pin]] {
            // With a pin the chain need not be known.
            let lenient = if words[0] == "--pinnedpubkey" { "-ksS" } else { "-sS" };
            let loaded = tool("curl", &[lenient, words[0], words[1], &url]);
            let said = String::from_utf8_lossy(&loaded.stderr).into_owned();
            assert_eq!(loaded.status.success(), good, "{words:?} {url}: {said}");
            assert_eq!(loaded.stdout.is_empty(), !good, "{words:?} {url}");
        }
    }
}

/// An encrypted page answers nothing that is not encrypted, and nobody holds it by a handshake that never ends.
///
/// A plain request; 64 connections that send half a handshake and come again; page loads beside them.
#[test]
fn plain_requests_and_held_handshakes_get_nothing() {
    if missing() {
        return;
    }
    let scratch = Scratch::new("handshakes");
    let page = Encrypted::start(&scratch.0, &["--tls"]);
    let address: SocketAddr = page.authority.parse().expect("an address");
    let mut plain = TcpStream::connect(address).expect("it listens");
    plain.set_read_timeout(Some(Duration::from_secs(20))).expect("a timeout");
    write!(plain, "GET / HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("sent");
    let mut answer = Vec::new();
    let _closed = plain.read_to_end(&mut answer);
    // An alert of TLS at the most.
    assert!(answer.len() < 16 && !answer.starts_with(b"HTTP"), "{answer:?}");
    let over = std::sync::atomic::AtomicBool::new(false);
    let good = std::thread::scope(|scope| {
        for _ in 0..64 {
            scope.spawn(|| {
                while !over.load(std::sync::atomic::Ordering::Relaxed) {
                    let Ok(mut stream) = TcpStream::connect(address) else { continue };
                    let _short = stream.set_read_timeout(Some(Duration::from_millis(500)));
                    // A record of 512 bytes of a handshake, of which ten come.
                    let _sent = stream.write_all(&[0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3]);
                    while !over.load(std::sync::atomic::Ordering::Relaxed) {
                        if matches!(stream.read(&mut [0]), Ok(0)) {
                            break;
                        }
                    }
                    std::thread::sleep(Duration::from_millis(20));
                }
            });
        }
        std::thread::sleep(Duration::from_millis(500));
        let url = format!("https://{address}/");
        let load = || {
            let begun = Instant::now();
            let loaded = tool("curl", &["-ksS", "--max-time", "5", &url]);
            loaded.status.success() && !loaded.stdout.is_empty() && begun.elapsed() < Duration::from_secs(3)
        };
        let good = (0..10).filter(|_| load()).count();
        over.store(true, std::sync::atomic::Ordering::Relaxed);
        good
    });
    assert!(good >= 9, "{good} of 10 page loads");
}

/// Certificates and keys that cannot guard a page are refused before the run, each with its reason.
///
/// The key of another certificate, files in the wrong places, an empty file, one that is not there, a device.
#[test]
fn wrong_certificates_and_keys_are_refused() {
    if missing() {
        return;
    }
    let scratch = Scratch::new("certificates");
    make_certificate(&scratch.0, "a");
    make_certificate(&scratch.0, "b");
    std::fs::write(scratch.0.join("empty"), "").expect("written");
    for (certificate, key, words) in [
        ("a.pem", "b.key", "the key is not that of the certificate"),
        ("a.key", "a.key", "it has no part -----BEGIN CERTIFICATE-----"),
        ("a.pem", "a.pem", "it has no part -----BEGIN PRIVATE KEY-----"),
        ("empty", "a.key", "it has no part -----BEGIN CERTIFICATE-----"),
        ("nowhere", "a.key", "there is no such file"),
        ("/dev/zero", "a.key", "a device, a pipe or a socket"),
    ] {
        let output = meniscus_command()
            .args(["run", "--view", "--listen", "127.0.0.1:0", "--tls-cert", certificate, "--tls-key", key])
            .current_dir(&scratch.0)
            .output()
            .expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(words), "{certificate}, {key}: {said}");
        assert!(!said.contains("live page"), "{said}");
    }
}
