//! The way from the camera's thread to the worker: payload buffers that go round.
//!
//! The camera takes a spare buffer, fills it and hands it over; the worker uses it and gives it back.
//! Nothing is allocated once the link stands. When the worker is so late that no buffer is spare,
//! the payload is dropped and counted: the newest data waits for nobody's old data.

use crate::buffer::Buffer;
use meniscus::usb::uvc::Stream;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::time::{Duration, Instant};

/// A payload in its buffer.
#[derive(Debug)]
pub struct Delivery {
    /// Which stream it belongs to.
    pub stream: Stream,
    /// Header and pixels.
    pub payload: Buffer,
    /// When it was handed over.
    pub arrived: Instant,
    /// Payloads dropped before it because no buffer was spare. Those that were dropped after it, while it waited, are not among
    /// them.
    pub dropped_before: u64,
}

/// The camera's end.
#[derive(Debug)]
pub struct CameraEnd {
    full: SyncSender<Delivery>,
    spare: Receiver<Buffer>,
    dropped: Arc<AtomicU64>,
}

/// The worker's end.
#[derive(Debug)]
pub struct WorkerEnd {
    full: Receiver<Delivery>,
    spare: SyncSender<Buffer>,
    dropped: Arc<AtomicU64>,
}

/// A look at each payload between camera and worker.
#[derive(Debug)]
pub struct Tap {
    full: Receiver<Delivery>,
    seen: SyncSender<Delivery>,
}

/// Result of a receive.
#[derive(Debug)]
pub enum Received {
    /// A payload.
    Payload(Delivery),
    /// Nothing until the time was up.
    Silence,
    /// The camera has gone and everything it sent has been received.
    Closed,
}

/// A link with `count` buffers of `size` bytes.
#[must_use]
pub fn link(count: usize, size: usize) -> (CameraEnd, WorkerEnd) {
    let (full_in, full_out) = sync_channel(count);
    let (spare_in, spare_out) = sync_channel(count);
    let worker = WorkerEnd { full: full_out, spare: spare_in, dropped: Arc::default() };
    for _ in 0..count {
        worker.give_back(Buffer::new(size));
    }
    (CameraEnd { full: full_in, spare: spare_out, dropped: Arc::clone(&worker.dropped) }, worker)
}

impl CameraEnd {
    /// Hands a copy of a payload over. `false` when the worker has gone.
    pub fn send(&self, stream: Stream, bytes: &[u8]) -> bool {
        match self.spare.try_recv() {
            Ok(buffer) => self.fill_and_hand_over(stream, bytes, buffer),
            Err(TryRecvError::Empty) => {
                self.drop_one();
                true
            }
            Err(TryRecvError::Disconnected) => false,
        }
    }

    /// The same, but waits for a spare buffer: no camera of the real world can.
    pub fn send_patiently(&self, stream: Stream, bytes: &[u8]) -> bool {
        self.spare.recv().is_ok_and(|buffer| self.fill_and_hand_over(stream, bytes, buffer))
    }

    fn fill_and_hand_over(&self, stream: Stream, bytes: &[u8], mut payload: Buffer) -> bool {
        if !payload.fill_from(bytes) {
            // Longer than any payload of this camera: an empty payload is counted as a loss behind the link.
            payload.set_filled(0);
        }
        self.hand_over(stream, payload)
    }

    /// A buffer that the worker has done with, if there is one.
    #[must_use]
    pub fn spare(&self) -> Option<Buffer> {
        self.spare.try_recv().ok()
    }

    /// Hands a filled buffer over, without a copy. `false` when the worker has gone.
    pub fn hand_over(&self, stream: Stream, payload: Buffer) -> bool {
        let dropped_before = self.dropped.load(Ordering::Relaxed);
        self.full.send(Delivery { stream, payload, arrived: Instant::now(), dropped_before }).is_ok()
    }

    /// Counts a payload that was dropped for want of a spare buffer.
    pub fn drop_one(&self) {
        self.dropped.fetch_add(1, Ordering::Relaxed);
    }
}

impl WorkerEnd {
    /// Waits for the next payload, at most until `deadline`.
    #[must_use]
    pub fn receive(&self, deadline: Instant) -> Received {
        let wait = deadline.saturating_duration_since(Instant::now()).max(Duration::from_micros(1));
        match self.full.recv_timeout(wait) {
            Ok(delivery) => Received::Payload(delivery),
            Err(RecvTimeoutError::Timeout) => Received::Silence,
            Err(RecvTimeoutError::Disconnected) => Received::Closed,
        }
    }

    /// Gives a buffer back for the next payload.
    pub fn give_back(&self, buffer: Buffer) {
        // There is room for every buffer; only a camera that has gone makes this fail.
        let _gone = self.spare.try_send(buffer);
    }

    /// Payloads dropped because no buffer was spare.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Returns the worker's end behind a thread `name` that sees each payload before the worker does. Order, arrival times and
    /// the buffers' round stay as they are.
    ///
    /// # Errors
    /// The error of the operating system on the thread.
    pub fn tapped(self, name: &str, body: impl FnOnce(Tap) + Send + 'static) -> std::io::Result<Self> {
        let Self { full, spare, dropped } = self;
        // Without room of its own: payloads that wait do so in front of it, where they are counted.
        let (seen_in, seen_out) = sync_channel(0);
        let tap = Tap { full, seen: seen_in };
        std::thread::Builder::new().name(name.into()).spawn(move || body(tap))?;
        Ok(Self { full: seen_out, spare, dropped })
    }
}

impl Tap {
    /// Waits for the next payload, shows it to `look` and hands it to the worker. `false` when the camera or the worker has
    /// gone.
    pub fn pass(&self, look: impl FnOnce(&Delivery)) -> bool {
        self.full.recv().is_ok_and(|delivery| {
            look(&delivery);
            self.seen.send(delivery).is_ok()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The payload that is waiting.
    fn waiting(worker: &WorkerEnd) -> Option<Delivery> {
        match worker.receive(Instant::now()) {
            Received::Payload(delivery) => Some(delivery),
            Received::Silence | Received::Closed => None,
        }
    }

    #[test]
    fn a_late_worker_costs_counted_payloads_and_nothing_else() {
        let (camera, worker) = link(2, 8);
        for k in 0..3 {
            assert!(camera.send(Stream::Depth, &[k]));
        }
        assert_eq!(worker.dropped(), 1);
        let delivery = waiting(&worker).expect("two are waiting");
        assert_eq!((&*delivery.payload, delivery.dropped_before), (&[0][..], 0), "the drop came after it");
        let place = delivery.payload.as_ptr();
        worker.give_back(delivery.payload);
        assert!(camera.send(Stream::Outline, &[9]));
        assert_eq!(waiting(&worker).expect("one is left").payload[..], [1]);
        let last = waiting(&worker).expect("the newest");
        assert_eq!((last.stream, last.payload.as_ptr()), (Stream::Outline, place), "the buffer goes round");
        assert_eq!(last.dropped_before, 1);
        assert!(matches!(worker.receive(Instant::now()), Received::Silence));
        drop(camera);
        assert!(matches!(worker.receive(Instant::now()), Received::Closed));
    }

    #[test]
    fn a_tap_sees_every_payload_before_the_worker_and_changes_none() {
        let (camera, worker) = link(2, 8);
        let seen = Arc::new(AtomicU64::new(0));
        let count = Arc::clone(&seen);
        let look = move |delivery: &Delivery| {
            count.fetch_add(u64::from(delivery.payload[0]), Ordering::Relaxed);
        };
        let tapped = worker.tapped("tap", move |tap| while tap.pass(&look) {});
        let worker = tapped.expect("a thread");
        let soon = || Instant::now() + Duration::from_secs(5);
        for k in 1..=5 {
            assert!(camera.send_patiently(Stream::Outline, &[k]));
            let Received::Payload(delivery) = worker.receive(soon()) else { std::panic!("payload {k}") };
            assert_eq!((&*delivery.payload, delivery.stream), (&[k][..], Stream::Outline));
            assert_eq!(seen.load(Ordering::Relaxed), (1..=u64::from(k)).sum::<u64>());
            worker.give_back(delivery.payload);
        }
        drop(camera);
        assert!(matches!(worker.receive(soon()), Received::Closed));
    }
}
