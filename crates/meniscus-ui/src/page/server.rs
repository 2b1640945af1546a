//! HTTP listener: one acceptor thread, one thread per connection, with limits.

use super::assets::Asset;
use super::board::Board;
use super::metrics::{KIND, metrics};
use super::request::{Gate, Refusal, Wanted};
use super::viewer;
use super::wire::Wire;
use super::{PageError, Tls};
use crate::listener::{HEAD_WITHIN, Limits, Place, Places, TimedStream, read};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tungstenite::Bytes;
use tungstenite::handshake::server::{create_response, write_response};
use tungstenite::http::{Response, StatusCode};

/// Viewers at a time.
pub const VIEWERS_MAX: usize = 16;

/// Viewers of one address.
pub const VIEWERS_EACH: usize = 12;

/// Limits on connections. One address has more places than viewers, so that its viewers keep none of its pages from loading.
const LIMITS: Limits =
    Limits { connections: 64, connections_each: 32, guests: VIEWERS_MAX, guests_each: VIEWERS_EACH };

/// Longest time for an answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time that the connections may take to end when the page closes.
const FAREWELL: Duration = Duration::from_secs(1);

/// Checks before the first byte of an answer.
pub(super) struct Front {
    /// Of requests.
    pub(super) gate: Gate,
    /// Of the connection.
    pub(super) tls: Option<Tls>,
}

/// Everything that a connection needs.
struct Desk {
    front: Front,
    bases: Bytes,
    board: Arc<Board>,
    places: Arc<Places>,
}

/// The listening side.
#[derive(Debug)]
pub(super) struct Server {
    address: SocketAddr,
    board: Arc<Board>,
    acceptor: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at `address`.
    pub(super) fn start(
        address: SocketAddr,
        front: Front,
        bases: Bytes,
        board: Arc<Board>,
    ) -> Result<Self, PageError> {
        let wrong = |error: std::io::Error| PageError::of_listening(address, &error);
        let listener = TcpListener::bind(address).map_err(wrong)?;
        let address = listener.local_addr().map_err(wrong)?;
        let desk = Arc::new(Desk { front, bases, board: Arc::clone(&board), places: Places::new(LIMITS) });
        let acceptor = spawn(move || accept(&listener, &desk))
            .map_err(|error| PageError::new("the page's thread", format!("{error}"), "free memory"))?;
        Ok(Self { address, board, acceptor: Some(acceptor) })
    }

    /// Where it listens; the port is the real one.
    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.board.close();
        // A connection of our own wakes the acceptor, which then sees that the page has closed.
        let mut own = self.address;
        if own.ip().is_unspecified() {
            own.set_ip(if own.is_ipv4() { [127, 0, 0, 1].into() } else { [0, 0, 0, 0, 0, 0, 0, 1].into() });
        }
        let woken = TcpStream::connect_timeout(&own, FAREWELL).is_ok();
        if let Some(acceptor) = self.acceptor.take().filter(|_| woken) {
            // A thread that panicked has said so.
            let _ = acceptor.join();
        }
    }
}

fn spawn(work: impl FnOnce() + Send + 'static) -> std::io::Result<JoinHandle<()>> {
    std::thread::Builder::new().name("page".into()).stack_size(256 * 1024).spawn(work)
}

/// Lets connections in until the page closes, and then waits a moment for them to end.
fn accept(listener: &TcpListener, desk: &Arc<Desk>) {
    for stream in listener.incoming() {
        if desk.board.closing() {
            break;
        }
        let Ok(stream) = stream else {
            // Out of file descriptors, perhaps: trying at once again would only burn the processor.
            std::thread::sleep(Duration::from_millis(50));
            continue;
        };
        let stream = Arc::new(stream);
        let Some(place) = desk.places.enter(&stream) else {
            desk.board.counters.refused.fetch_add(1, Ordering::Relaxed);
            if desk.front.tls.is_some() {
                // Words would need a handshake, and this thread waits for nobody.
                continue;
            }
            // A new socket has room for so few bytes: nothing is waited for.
            let mut stream = Wire::Plain(TimedStream::new(stream, Duration::from_millis(10)));
            respond(
                &mut stream,
                Refusal::Full.status(),
                "text/html; charset=utf-8",
                &explained(Refusal::Full),
            );
            continue;
        };
        let own = Arc::clone(desk);
        // Where no thread can be had, the closure is dropped, and the place with it.
        let _started = spawn(move || serve(stream, &place, &own));
    }
    let end = Instant::now() + FAREWELL;
    while desk.places.taken() > 0 && Instant::now() < end {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// One connection: one request, one answer, or a web socket.
fn serve(stream: Arc<TcpStream>, place: &Place, desk: &Desk) {
    if stream.set_nodelay(true).is_err() {
        return;
    }
    let stream = TimedStream::new(stream, HEAD_WITHIN);
    place.await_request(&stream);
    let wire = match &desk.front.tls {
        None => Some(Wire::Plain(stream)),
        Some(tls) => tls.wire(stream),
    };
    let Some(mut stream) = wire else { return };
    let head = read(&mut stream);
    place.ask();
    let answer = head.map_err(Refusal::from).and_then(|head| {
        let rest = head.rest().to_vec();
        Ok((desk.front.gate.admit(head.request)?, rest))
    });
    stream.allow(PATIENCE);
    let refused = match answer {
        Ok((Wanted::File(Asset { kind, bytes, .. }), _)) => {
            respond(&mut stream, StatusCode::OK, kind, bytes);
            return stream.finish();
        }
        Ok((Wanted::Model, _)) => {
            respond(&mut stream, StatusCode::OK, "application/octet-stream", &desk.bases);
            return stream.finish();
        }
        Ok((Wanted::Metrics, _)) => match metrics(&desk.board) {
            Some(text) => {
                respond(&mut stream, StatusCode::OK, KIND, text.as_bytes());
                return stream.finish();
            }
            None => Refusal::NoTurn,
        },
        Ok((Wanted::Live(request), rest)) => match create_response(&request) {
            Err(_) => Refusal::Malformed,
            Ok(_) if place.stay().is_none() => Refusal::Full,
            Ok(response) => {
                desk.board.viewers.fetch_add(1, Ordering::Relaxed);
                desk.board.counters.came.fetch_add(1, Ordering::Relaxed);
                if write_response(&mut stream, &response).is_ok() {
                    viewer::serve(stream, rest, &desk.board);
                }
                desk.board.viewers.fetch_sub(1, Ordering::Relaxed);
                return;
            }
        },
        Err(refusal) => refusal,
    };
    desk.board.counters.refused.fetch_add(1, Ordering::Relaxed);
    respond(&mut stream, refused.status(), "text/html; charset=utf-8", &explained(refused));
    // What the other side still sends is read for a moment, or the system would take the answer back.
    stream.finish();
    stream.allow(Duration::from_millis(200));
    let mut rest = [0; 4096];
    for _ in 0..16 {
        if !matches!(stream.read(&mut rest), Ok(1..)) {
            break;
        }
    }
}

/// A page for a person who was refused.
fn explained(refusal: Refusal) -> Vec<u8> {
    let (status, words) = (refusal.status(), refusal.words());
    let text = format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>meniscus: {status}</title>\
         <link rel=\"stylesheet\" href=\"/style.css\"><main class=\"refused\"><h1>{status}</h1><p>{words}</p></main></html>\n"
    );
    text.into_bytes()
}

/// Head and body. The page loads nothing from elsewhere, and nobody else may frame it or learn its address.
fn respond(stream: &mut Wire, status: StatusCode, kind: &str, body: &[u8]) {
    let response = Response::builder()
        .status(status)
        .header("Content-Type", kind)
        .header("Content-Length", body.len())
        .header("Connection", "close")
        .header("Cache-Control", "no-store")
        .header(
            "Content-Security-Policy",
            "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
        )
        .header("Referrer-Policy", "no-referrer")
        .header("X-Content-Type-Options", "nosniff")
        .body(());
    let Ok(response) = response else { return };
    let mut bytes = Vec::with_capacity(1024 + body.len());
    // Written in one piece; a browser that has gone meanwhile needs no answer.
    if write_response(&mut bytes, &response).is_ok() {
        bytes.extend_from_slice(body);
        let _sent = stream.write_all(&bytes).and_then(|()| stream.flush());
    }
}
