//! Gate before the SDK's WebSocket server, which answers every web page by itself.
//!
//! ```text
//! client --> gate at the public address: head, Host, Origin, places --> SDK's server at a hidden loopback address
//! ```
//! The SDK looks at neither `Origin` nor `Host`. Its server therefore listens at a random address of 127.0.0.0/8 and a random
//! port: 39 bits that no page can try out. The gate passes on the bytes of those that it lets in, and nothing else.

use crate::listener::{
    HEAD_WITHIN, HeadFault, Hosts, Limits, Place, Places, SenderFault, Senders, TimedStream,
};
use crate::listener::{check_sender, read};
use std::io::{self, Write};
use std::net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// Origins of Foxglove's own web application.
const FOXGLOVE: [&str; 2] = ["https://app.foxglove.dev", "https://studio.foxglove.dev"];

/// Limits on connections.
const LIMITS: Limits = Limits { connections: 64, connections_each: 32, guests: 16, guests_each: 12 };

/// Longest time for a refusal.
const PATIENCE: Duration = Duration::from_secs(2);

/// Address of the server, and the pages that may connect to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Listen {
    /// Address; a loopback one.
    pub address: SocketAddr,
    /// Origins besides Foxglove's own.
    pub origins: Vec<String>,
}

impl From<SocketAddr> for Listen {
    fn from(address: SocketAddr) -> Self {
        Self { address, origins: Vec::new() }
    }
}

/// Everything that a connection needs.
struct Desk {
    inner: SocketAddr,
    origins: Vec<String>,
    places: Arc<Places>,
    closing: AtomicBool,
}

/// The open gate; dropping it lets nobody in any more.
pub(super) struct Gate {
    address: SocketAddr,
    desk: Arc<Desk>,
    acceptor: Option<JoinHandle<()>>,
}

/// Returns a loopback address that nobody can guess.
pub(super) fn hidden_address() -> io::Result<IpAddr> {
    let mut bytes = [0; 3];
    getrandom::fill(&mut bytes).map_err(|error| io::Error::other(error.to_string()))?;
    let [a, b, c] = bytes;
    // Neither 127.0.0.x, which is known, nor a network's own or broadcast address.
    Ok(Ipv4Addr::new(127, a.max(1), b, c.clamp(1, 254)).into())
}

impl Gate {
    /// Opens the gate of `listen` before the server at `inner`.
    pub(super) fn open(listen: &Listen, inner: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind(listen.address)?;
        let address = listener.local_addr()?;
        let origins = listen.origins.iter().cloned().chain(FOXGLOVE.map(str::to_owned)).collect();
        let closing = AtomicBool::new(false);
        let desk = Arc::new(Desk { inner, origins, places: Places::new(LIMITS), closing });
        let own = Arc::clone(&desk);
        let acceptor = Some(spawn(move || accept(&listener, &own))?);
        Ok(Self { address, desk, acceptor })
    }

    /// Returns the port that is listened at.
    pub(super) fn port(&self) -> u16 {
        self.address.port()
    }
}

impl Drop for Gate {
    fn drop(&mut self) {
        self.desk.closing.store(true, Ordering::Release);
        // A connection of our own wakes the acceptor, which then sees that the gate closes.
        let woken = TcpStream::connect_timeout(&self.address, Duration::from_secs(1)).is_ok();
        if let Some(acceptor) = self.acceptor.take().filter(|_| woken) {
            // A thread that panicked has said so.
            let _ = acceptor.join();
        }
    }
}

fn spawn(work: impl FnOnce() + Send + 'static) -> io::Result<JoinHandle<()>> {
    std::thread::Builder::new().name("foxglove gate".into()).stack_size(256 * 1024).spawn(work)
}

fn accept(listener: &TcpListener, desk: &Arc<Desk>) {
    for stream in listener.incoming() {
        if desk.closing.load(Ordering::Acquire) {
            break;
        }
        let Ok(stream) = stream else {
            // Out of file descriptors, perhaps: trying at once again would only burn the processor.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        let stream = Arc::new(stream);
        let Some(place) = desk.places.enter(&stream) else { continue };
        let own = Arc::clone(desk);
        // Where no thread can be had, the closure is dropped, and the place with it.
        let _started = spawn(move || serve(&stream, &place, &own));
    }
}

/// One connection: let in and passed on until either side ends, or refused.
fn serve(stream: &Arc<TcpStream>, place: &Place, desk: &Desk) {
    let mut timed = TimedStream::new(Arc::clone(stream), HEAD_WITHIN);
    place.await_request(&timed);
    let head = read(&mut timed);
    place.ask();
    let refused = match head {
        Err(HeadFault::Malformed) => (400, "This is no request that the server knows."),
        Err(HeadFault::TooLong) => (431, "The request's head is longer than 8 KiB."),
        Err(HeadFault::Slow) => (408, "The request took longer than 5 seconds."),
        Ok(head) => {
            let senders = Senders { hosts: Hosts::ThisMachine, origins: &desk.origins };
            match check_sender(&head.request, senders) {
                Err(SenderFault::Malformed) => {
                    (400, "A request needs exactly one Host and at most one Origin.")
                }
                Err(SenderFault::Host) => {
                    (403, "This name for the machine is not known: use ws://localhost:PORT.")
                }
                Err(SenderFault::Origin) => {
                    (403, "This page may not connect. --foxglove-origin names further pages that may.")
                }
                Ok(()) if place.stay().is_none() => (503, "As many are connected as the server allows."),
                Ok(()) => {
                    // A side that fails ends the connection, and says so to nobody.
                    let _ended = pass_on(stream, desk.inner, &head.bytes);
                    return;
                }
            }
        }
    };
    let (status, words) = refused;
    timed.allow(PATIENCE);
    let length = words.len();
    let answer = format!(
        "HTTP/1.1 {status} Refused\r\nContent-Type: text/plain\r\nContent-Length: {length}\r\nConnection: close\r\n\r\n{words}"
    );
    // A client that has gone meanwhile needs no answer.
    let _sent = timed.write_all(answer.as_bytes());
}

/// Passes bytes between `stream` and the server at `inner`, `first` before all others, until either side ends.
fn pass_on(stream: &Arc<TcpStream>, inner: SocketAddr, first: &[u8]) -> io::Result<()> {
    let server = Arc::new(TcpStream::connect(inner)?);
    server.set_nodelay(true)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(None)?;
    stream.set_write_timeout(None)?;
    (&*server).write_all(first)?;
    let (from, to) = (Arc::clone(&server), Arc::clone(stream));
    let back = spawn(move || copy(&from, &to))?;
    copy(stream, &server);
    // The thread ends with the streams; one that panicked has said so.
    let _ = back.join();
    Ok(())
}

/// Copies bytes until an end or an error, then ends both streams.
fn copy(mut from: &TcpStream, mut to: &TcpStream) {
    let _copied = io::copy(&mut from, &mut to);
    let _ended = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}
