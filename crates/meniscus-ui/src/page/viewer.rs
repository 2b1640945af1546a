//! One viewer's web socket: the newest frame whenever the viewer has taken one of the last.
//!
//! ```text
//! viewer: wish ............ taken(1) . taken(2) ....      eight bytes each: the frame's number, the rate in Hz, the image
//! here:               1 2 3 ......... 4 ........ 5 .      at most WINDOW frames are on their way
//! ```
//! A viewer that is slow, or far, gets fewer frames and always new ones: what it has no room for is never queued.

use super::board::Board;
use super::wire::Wire;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Bytes, Message, WebSocket};

/// Frames on their way to a viewer at most: a twentieth of a second at the full rate.
const WINDOW: u32 = 3;

/// Longest message of a viewer, bytes: its own have eight.
const MESSAGE_MAX: usize = 64;

/// Time that the thread waits for a frame before it checks whether the page has closed.
const PATIENCE: Duration = Duration::from_millis(500);

/// Longest time for a viewer's next message, and for taking one of ours. Pings do not renew it.
const ANSWER_WITHIN: Duration = Duration::from_secs(5);

/// Pings and pongs between two messages of a viewer: a page sends none of its own accord.
const PINGS_MAX: usize = 64;

/// Highest rate, Hz.
const RATE_MAX: u8 = 60;

/// The viewer on `stream`; `rest` came behind its request.
pub(super) fn serve(stream: Wire, rest: Vec<u8>, board: &Board) {
    let limits = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_MAX))
        .max_frame_size(Some(MESSAGE_MAX))
        .write_buffer_size(0);
    let mut socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(limits));
    // Whatever ends it, the viewer has gone, or learns why it has to.
    let gone = show(&mut socket, board).is_none();
    if !gone {
        let frame = CloseFrame { code: CloseCode::Away, reason: "the run has ended".into() };
        socket.get_mut().allow(ANSWER_WITHIN);
        let _closed = socket.close(Some(frame)).and_then(|()| socket.flush());
    }
}

/// Wish of a viewer.
#[derive(Clone, Copy)]
struct Wish {
    /// Frames a second.
    rate: u8,
    /// Which image: 0 of the outline, 1 of the depth.
    image: usize,
}

/// A viewer's place among those who look at the depth image.
struct DepthViewer<'b> {
    count: &'b AtomicUsize,
    looks: bool,
}

impl DepthViewer<'_> {
    fn set(&mut self, looks: bool) {
        match (self.looks, looks) {
            (false, true) => self.count.fetch_add(1, Ordering::Relaxed),
            (true, false) => self.count.fetch_sub(1, Ordering::Relaxed),
            _ => 0,
        };
        self.looks = looks;
    }
}

impl Drop for DepthViewer<'_> {
    fn drop(&mut self) {
        self.set(false);
    }
}

/// Shows frames until the page closes, `Some`, or the viewer goes, `None`.
fn show(socket: &mut WebSocket<Wire>, board: &Board) -> Option<()> {
    let counters = &board.counters;
    let mut wanted = wish(socket)?;
    let mut depth = DepthViewer { count: &board.depth_viewers, looks: false };
    let (mut under_way, mut last, mut last_image, mut last_note) = (0, 0, 0, 0);
    let mut due = Instant::now();
    while !board.closing() {
        let before = board.number();
        while under_way >= WINDOW {
            wanted = wish(socket)?;
            under_way -= 1;
        }
        let passed = u64::from(board.number().saturating_sub(before));
        counters.left_out.fetch_add(passed.saturating_sub(1), Ordering::Relaxed);
        depth.set(wanted.image == 1);
        if let Some((number, note)) = board.note_after(last_note) {
            last_note = number;
            counters.bytes.fetch_add(note.len() as u64, Ordering::Relaxed);
            socket.get_mut().allow(ANSWER_WITHIN);
            socket.send(Message::text(note)).ok()?;
        }
        let Some((frame, images)) = board.newer(last, due, PATIENCE) else {
            // Nothing new: a ping finds out whether the viewer is still there.
            socket.get_mut().allow(ANSWER_WITHIN);
            socket.send(Message::Ping(Bytes::new())).ok()?;
            continue;
        };
        // A tenth early is on time: turns do not come to the microsecond.
        due = Instant::now() + Duration::from_micros(900_000 / u64::from(wanted.rate));
        last = frame.0;
        let mut send = |bytes: Bytes| {
            counters.bytes.fetch_add(bytes.len() as u64, Ordering::Relaxed);
            socket.get_mut().allow(ANSWER_WITHIN);
            socket.send(Message::Binary(bytes)).ok()
        };
        let [outline, of_depth] = images;
        let image = if wanted.image == 1 { of_depth } else { outline };
        if image.0 > last_image {
            last_image = image.0;
            send(image.1)?;
        }
        send(frame.1)?;
        counters.sent.fetch_add(1, Ordering::Relaxed);
        under_way += 1;
    }
    Some(())
}

/// The next message of the viewer, which says that it has taken a frame, at which rate it wants more, and with which image;
/// `None` when it has gone or says something else.
fn wish(socket: &mut WebSocket<Wire>) -> Option<Wish> {
    socket.get_mut().allow(ANSWER_WITHIN);
    for _ in 0..PINGS_MAX {
        match socket.read().ok()? {
            Message::Binary(bytes) => {
                let [.., rate, image, _, _] = *<&[u8; 8]>::try_from(&*bytes).ok()?;
                let known = (1..=RATE_MAX).contains(&rate) && image <= 1;
                return known.then_some(Wish { rate, image: usize::from(image) });
            }
            Message::Ping(_) | Message::Pong(_) => {}
            Message::Text(_) | Message::Close(_) | Message::Frame(_) => return None,
        }
    }
    None
}
