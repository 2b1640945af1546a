//! The look at the camera: connected to, and its frames counted.

use meniscus::usb::uvc::Stream;
use meniscus_usb::buffer::Buffer;
use meniscus_usb::camera::{CameraError, CameraHealth, Connected, Note, Session, Settings, Sink};
use meniscus_usb::transport::Transport;
use std::time::{Duration, Instant};

/// Time for which frames are counted.
const COUNTING: Duration = Duration::from_secs(2);

/// Findings about the camera.
#[derive(Default)]
pub(crate) struct Camera {
    pub(crate) connected: Option<Connected>,
    pub(crate) rate_hz: f64,
    pub(crate) health: CameraHealth,
    pub(crate) transfers_mb: f64,
    pub(crate) error: Option<CameraError>,
    /// Errors that the camera reported.
    pub(crate) reported: Vec<Note>,
}

/// Connects and counts frames.
pub(super) fn look(transport: impl Transport, settings: Settings) -> Camera {
    let mut session = match Session::connect(transport, settings) {
        Ok(session) => session,
        Err(error) => return Camera { rate_hz: f64::NAN, error: Some(error), ..Camera::default() },
    };
    let mut count = Count::new(session.buffer_bytes());
    let error = session.stream(&mut count).err();
    let transfers = session.plan().streams.iter().map(|stream| 4 * stream.transfer_bytes()).sum::<usize>();
    Camera {
        connected: Some(session.connected().clone()),
        rate_hz: count.rate_hz(),
        health: session.health(),
        transfers_mb: transfers as f64 / f64::from(1 << 20),
        error,
        reported: count.reported,
    }
}

/// Counts depth payloads from the first one on.
struct Count {
    spare: Vec<Buffer>,
    begun: Instant,
    first: Option<Instant>,
    last: Option<Instant>,
    depth: u32,
    reported: Vec<Note>,
}

impl Count {
    fn new(bytes: usize) -> Self {
        let spare = (0..4).map(|_| Buffer::new(bytes)).collect();
        Self { spare, begun: Instant::now(), first: None, last: None, depth: 0, reported: Vec::new() }
    }

    fn rate_hz(&self) -> f64 {
        let time = self.first.zip(self.last).map(|(first, last)| (last - first).as_secs_f64());
        time.map_or(0.0, |time| f64::from(self.depth.saturating_sub(1)) / time.max(1e-3))
    }
}

impl Sink for Count {
    fn wanted(&mut self) -> bool {
        // A camera that brings nothing has the session's patience, and two seconds to start.
        self.first.map_or(self.begun.elapsed() < 8 * COUNTING, |first| first.elapsed() < COUNTING)
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop()
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        if stream == Stream::Depth {
            let now = Instant::now();
            self.first.get_or_insert(now);
            self.last = Some(now);
            self.depth += 1;
        }
        self.spare.push(payload);
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, note: Note) {
        if matches!(note, Note::Reported(_)) {
            self.reported.push(note);
        }
    }
}
