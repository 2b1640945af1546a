//! Attackers of a running program, until they have to stop.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::Scope;
use std::time::Duration;

/// Connections that hold the page.
const HOLDERS: usize = 64;
/// Readers of the Unix socket that read nothing.
const READERS: usize = 300;
/// Senders of false accelerations.
const FLOODERS: u8 = 2;
/// Pause of each sender between two datagrams: 4,000 a second, sixteen times those of a robot.
const FLOOD_EVERY: Duration = Duration::from_micros(250);
/// Pause of a holder that was put out, before it comes again: attackers run on the same processors, and are not to take them.
const COME_AGAIN: Duration = Duration::from_millis(50);
/// Stack of an attacker's thread.
const STACK: usize = 128 * 1024;

/// Doors of the program.
#[derive(Clone, Debug)]
pub(super) struct Doors {
    pub(super) page: SocketAddr,
    pub(super) foxglove: SocketAddr,
    pub(super) motion: SocketAddr,
    pub(super) socket: PathBuf,
}

/// Attackers' counts, and the word to stop.
#[derive(Debug, Default)]
pub(super) struct Attack {
    pub(super) over: AtomicBool,
    /// Connections, requests and datagrams.
    pub(super) attempts: AtomicU64,
    /// Foreign pages that Foxglove's server let in.
    pub(super) let_in: AtomicU64,
}

impl Attack {
    fn goes_on(&self) -> bool {
        !self.over.load(Ordering::Relaxed)
    }

    fn count(&self) {
        self.attempts.fetch_add(1, Ordering::Relaxed);
    }

    /// Starts all attackers.
    pub(super) fn start<'s>(&'s self, scope: &'s Scope<'s, '_>, doors: &'s Doors) -> std::io::Result<()> {
        let thread = || std::thread::Builder::new().stack_size(STACK);
        for _ in 0..HOLDERS {
            thread().spawn_scoped(scope, || self.hold_page(doors.page))?;
        }
        for last in 1..=FLOODERS {
            thread().spawn_scoped(scope, move || self.flood(doors.motion, last))?;
        }
        thread().spawn_scoped(scope, || self.hold_socket(doors))?;
        thread().spawn_scoped(scope, || self.intrude(doors.foxglove))?;
        Ok(())
    }

    /// A connection that says nothing, and comes again whenever it is closed.
    fn hold_page(&self, page: SocketAddr) {
        while self.goes_on() {
            std::thread::sleep(COME_AGAIN);
            let Ok(mut stream) = TcpStream::connect(page) else { continue };
            self.count();
            let _short = stream.set_read_timeout(Some(Duration::from_millis(200)));
            let mut byte = [0];
            while self.goes_on() && !matches!(stream.read(&mut byte), Ok(0)) {}
        }
    }

    /// Readers that take nothing; those that are put out come again.
    fn hold_socket(&self, doors: &Doors) {
        let mut readers: Vec<UnixStream> = Vec::new();
        while self.goes_on() {
            readers.retain_mut(|reader| {
                let closed = reader.set_nonblocking(true).is_err() || reader.write(&[0]).is_err();
                !closed
            });
            while readers.len() < READERS {
                let Ok(reader) = UnixStream::connect(&doors.socket) else { break };
                self.count();
                readers.push(reader);
            }
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Accelerations of 150 and -150 m/s2 in turn.
    fn flood(&self, motion: SocketAddr, last: u8) {
        let Ok(socket) = UdpSocket::bind(SocketAddr::from(([127, 0, 0, last], 0))) else { return };
        let mut sign = 1.0;
        while self.goes_on() {
            let _nobody_listens = socket.send_to(format!("{}", 150.0 * sign).as_bytes(), motion);
            self.count();
            sign = -sign;
            std::thread::sleep(FLOOD_EVERY);
        }
    }

    /// A web page of somebody else that asks for Foxglove's stream twenty times a second.
    fn intrude(&self, foxglove: SocketAddr) {
        let request = format!(
            "GET / HTTP/1.1\r\nHost: {foxglove}\r\nOrigin: https://elsewhere.example\r\nUpgrade: websocket\r\n\
             Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        while self.goes_on() {
            if let Ok(mut stream) = TcpStream::connect(foxglove) {
                self.count();
                let _short = stream.set_read_timeout(Some(Duration::from_millis(500)));
                let mut head = [0; 12];
                let answered =
                    stream.write_all(request.as_bytes()).and_then(|()| stream.read_exact(&mut head));
                if answered.is_ok() && head.ends_with(b"101") {
                    self.let_in.fetch_add(1, Ordering::Relaxed);
                }
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}
