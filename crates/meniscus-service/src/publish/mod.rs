//! Estimates for others, while the turn goes on: over a Unix socket, UDP or a serial line.
//!
//! ```text
//! worker --PublishOutlet (never waits)--> queue --> publisher's thread --> unix sockets, UDP, serial
//!        '--copy of the field, when one is due and nobody holds the slot--^
//! ```
//! A record is what `firmware-config/SPEC.md` calls an output frame, or a field frame; its first byte says
//! which. A datagram is one record; on a stream each record is stuffed by COBS (Cheshire and Baker 1999) and
//! ends with a zero byte, so that a reader that joins in the middle finds the next one. Whoever reads too
//! slowly loses records, counted, and holds up nobody.

mod destination;
mod stream;
mod targets;

pub use destination::{Destination, DestinationError};

use crate::sink::{TurnRecord, TurnSink};
use meniscus::runtime::output::{OUTPUT_VERSION, Packet};
use meniscus::units::Micros;
use meniscus_platform::handoff::Handoff;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use targets::{Readers, Targets};

/// First byte of a field frame.
pub const FIELD_KIND: u8 = b'F';

/// Records between worker and publisher: a second.
const QUEUE: usize = 64;

/// How long the publisher waits for a record before it looks for new readers.
const PATIENCE: Duration = Duration::from_millis(50);

/// The full field, as it goes out.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FieldFrame {
    /// [`FIELD_KIND`].
    pub kind: u8,
    /// Instant of its turn, in the camera's time.
    pub time: Micros,
    /// q, v, e, sigma, tau of every tracer, group after group, SI units.
    pub field: Vec<f32>,
}

/// Counters of the records.
#[derive(Debug, Default)]
pub struct PublishCounters {
    /// Records written, to each reader.
    pub sent: AtomicU64,
    /// Records that the publisher had no time for.
    pub queue_full: AtomicU64,
    /// Records that a reader had no room for.
    pub reader_slow: AtomicU64,
    /// Readers that have gone.
    pub readers_gone: AtomicU64,
}

/// The worker's end.
#[derive(Debug)]
pub struct PublishOutlet {
    queue: SyncSender<Packet>,
    slot: Arc<Handoff<FieldFrame>>,
    field_len: usize,
    /// Counters of the records.
    pub counters: Arc<PublishCounters>,
}

/// The publisher's thread; dropping its [`PublishOutlet`] ends it.
#[derive(Debug)]
pub struct Publisher(JoinHandle<()>);

impl TurnSink for PublishOutlet {
    /// Queues the turn's packet: without room the record is left out and counted. The field is copied only when one is
    /// due and the publisher does not hold the slot.
    fn accept(&mut self, record: &TurnRecord<'_>) {
        let (turn, field) = (&record.logged.turn, record.field);
        let sequence = turn.stamp.map(|stamp| stamp.sequence);
        let packet = Packet { version: OUTPUT_VERSION, time: turn.time, sequence, estimate: turn.estimate };
        if self.queue.try_send(packet).is_err() {
            self.counters.queue_full.fetch_add(1, Ordering::Relaxed);
        }
        if turn.estimate.field_fresh && field.len() == self.field_len {
            self.slot.offer(|frame| {
                frame.time = turn.time;
                frame.field.copy_from_slice(field);
            });
        }
    }
}

impl Publisher {
    /// Opens `destinations` and starts to publish; the full field goes `field_hz` times a second to those
    /// who read a Unix socket, never if that is 0. `field_len` is its length.
    ///
    /// # Errors
    /// What is wrong with the first destination that cannot be opened, and what to do.
    pub fn start(
        destinations: &[Destination],
        field_hz: f64,
        field_len: usize,
    ) -> Result<(PublishOutlet, Self), DestinationError> {
        let counters = Arc::new(PublishCounters::default());
        let targets = Targets::open(destinations, Arc::clone(&counters))?;
        let (queue, records) = sync_channel(QUEUE);
        let empty = FieldFrame { kind: FIELD_KIND, time: Micros(0), field: vec![0.0; field_len] };
        let slot = Arc::new(Handoff::new(empty));
        let shared = Arc::clone(&slot);
        let every = (field_hz > 0.0).then(|| Duration::from_secs_f64(1.0 / field_hz));
        let thread = std::thread::Builder::new().name("publisher".into());
        let thread = thread.spawn(move || publish(targets, &records, &shared, every)).map_err(|error| {
            DestinationError::new("the publisher's thread", error.to_string(), "free memory")
        })?;
        Ok((PublishOutlet { queue, slot, field_len, counters }, Self(thread)))
    }

    /// Waits until all that was handed over is out, or refused; the [`PublishOutlet`] has to be gone.
    pub fn finish(self) {
        // A thread that panicked has said so; the run it belongs to is over.
        let _ = self.0.join();
    }
}

/// The publisher's loop.
fn publish(
    mut targets: Targets,
    records: &Receiver<Packet>,
    slot: &Handoff<FieldFrame>,
    every: Option<Duration>,
) {
    let mut due = Instant::now();
    let mut asked = false;
    loop {
        let record = records.recv_timeout(PATIENCE);
        targets.welcome();
        match record {
            Ok(packet) => targets.send(&packet, Readers::All),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        let Some(every) = every else { continue };
        if asked && slot.answered() {
            asked = false;
            slot.with(|frame| targets.send(frame, Readers::Sockets));
        }
        if !asked && Instant::now() >= due {
            due = (due + every).max(Instant::now());
            asked = true;
            slot.ask();
        }
    }
    targets.flush();
}
