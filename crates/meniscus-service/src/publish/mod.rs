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
use meniscus::blob::{FieldGroup, Header, KnownGroups};
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::runtime::output::{HostTime, Packet};
use meniscus::units::Micros;
use meniscus_platform::handoff::Handoff;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
pub use targets::READERS_MAX;
use targets::{Readers, Targets};

/// First byte of a field frame. `F` was a frame without number, host time and groups.
pub const FIELD_KIND: u8 = b'G';

/// Records between worker and publisher: a second.
const QUEUE: usize = 64;

/// Time that the publisher waits for a record before it looks for new readers.
const PATIENCE: Duration = Duration::from_millis(50);

/// Field of a turn, as it goes out.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FieldFrame {
    /// [`FIELD_KIND`].
    pub kind: u8,
    /// Number of the packet of the same turn.
    pub number: u64,
    /// Instant of its turn on the camera's clock.
    pub time: Micros,
    /// The same instant on the host's clock.
    pub host: Option<HostTime>,
    /// Groups that `field` has. A group that the model is not valid for is left out.
    pub groups: KnownGroups,
    /// q, v, e, sigma, tau of every tracer as far as `groups` has them, group after group, SI units.
    pub field: Vec<f32>,
}

impl FieldFrame {
    /// Returns a frame with room for the groups that the model of `header` knows, of a full field of `field_len` numbers.
    #[must_use]
    pub fn room(header: &Header, field_len: usize) -> Self {
        let groups = header.known();
        let field = vec![0.0; groups_len(field_len, groups)];
        Self { kind: FIELD_KIND, number: 0, time: Micros(0), host: None, groups, field }
    }

    /// Takes the full `field` of the turn of `packet`.
    pub fn take(&mut self, packet: &Packet, field: &[f32]) {
        (self.number, self.time, self.host) = (packet.number, packet.time, packet.host);
        copy_groups(field, self.groups, &mut self.field);
    }
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
    /// Readers beyond [`READERS_MAX`].
    pub readers_refused: AtomicU64,
}

/// A record on its way to the publisher.
#[derive(Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "the worker allocates no box, and the queue's room is made once"
)]
enum Outgoing {
    /// Packet of a turn that ended then: its latency counts up to leaving.
    Turn(Packet, Instant),
    /// Another record, in its bytes.
    Whole(Vec<u8>),
}

/// End for records of another kind than a turn's, from threads that are not the worker's.
#[derive(Clone, Debug)]
pub struct RecordOutlet {
    queue: SyncSender<Outgoing>,
    counters: Arc<PublishCounters>,
}

impl RecordOutlet {
    /// Queues a record in its bytes for Unix sockets and UDP; without room it is left out and counted.
    pub fn send(&self, record: Vec<u8>) {
        if self.queue.try_send(Outgoing::Whole(record)).is_err() {
            self.counters.queue_full.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Bytes that are a record already.
struct Whole<'b>(&'b [u8]);

impl serde::Serialize for Whole<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        // A tuple has no length before it.
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|byte| serde::ser::SerializeTuple::serialize_element(&mut bytes, byte))?;
        serde::ser::SerializeTuple::end(bytes)
    }
}

/// The worker's end.
#[derive(Debug)]
pub struct PublishOutlet {
    queue: SyncSender<Outgoing>,
    slot: Arc<Handoff<FieldFrame>>,
    header: Header,
    field_len: usize,
    /// Number of the next packet.
    number: u64,
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
        let (timed, field) = (record.logged, record.field);
        let packet = Packet { host: timed.host, ..Packet::of(&timed.turn, self.number, &self.header) };
        // A packet that is left out keeps its number: the gap tells readers of it.
        self.number += 1;
        if self.queue.try_send(Outgoing::Turn(packet, timed.ended)).is_err() {
            self.counters.queue_full.fetch_add(1, Ordering::Relaxed);
        }
        if timed.turn.estimate.field_fresh && field.len() == self.field_len {
            self.slot.offer(|frame| frame.take(&packet, field));
        }
    }
}

/// Returns a packet as it leaves now: its latency counts the time since its turn `ended`, too.
fn leaving(packet: &Packet, ended: Instant) -> Packet {
    let waited_us = u64::try_from(ended.elapsed().as_micros()).unwrap_or(u64::MAX);
    let host =
        packet.host.map(|host| HostTime { latency_us: host.latency_us.saturating_add(waited_us), ..host });
    Packet { host, ..*packet }
}

/// Numbers of one tracer in all groups.
const TRACER: usize = {
    let [q, v, e, sigma, tau] = GROUP_COMPONENTS;
    q + v + e + sigma + tau
};

/// Returns the share of a full field of `field_len` numbers that `groups` has.
fn groups_len(field_len: usize, groups: KnownGroups) -> usize {
    let tracers = field_len / TRACER;
    let sizes = FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS);
    sizes.filter(|(group, _)| groups.contains(*group)).map(|(_, components)| tracers * components).sum()
}

/// Copies the groups of a full field that `groups` has, one behind the other.
fn copy_groups(field: &[f32], groups: KnownGroups, out: &mut [f32]) {
    let tracers = field.len() / TRACER;
    let (mut rest, mut room) = (field, out);
    for (group, components) in FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS) {
        let (part, behind) = rest.split_at(tracers * components);
        rest = behind;
        if groups.contains(group) {
            let (place, left) = room.split_at_mut(part.len());
            place.copy_from_slice(part);
            room = left;
        }
    }
}

impl PublishOutlet {
    /// Returns an end for records of another kind; the publisher lasts until it is dropped, too.
    #[must_use]
    pub fn records(&self) -> RecordOutlet {
        RecordOutlet { queue: self.queue.clone(), counters: Arc::clone(&self.counters) }
    }
}

impl Publisher {
    /// Opens `destinations` and starts to publish estimates of the model of `header`. The field goes `field_hz` times a
    /// second to those who read a Unix socket, never if that is 0; `field_len` is the length of the full one.
    ///
    /// # Errors
    /// What is wrong with the first destination that cannot be opened, and what to do.
    pub fn start(
        destinations: &[Destination],
        header: &Header,
        field_hz: f64,
        field_len: usize,
    ) -> Result<(PublishOutlet, Self), DestinationError> {
        let counters = Arc::new(PublishCounters::default());
        let targets = Targets::open(destinations, Arc::clone(&counters))?;
        let (queue, records) = sync_channel(QUEUE);
        let slot = Arc::new(Handoff::new(FieldFrame::room(header, field_len)));
        let shared = Arc::clone(&slot);
        let every = (field_hz > 0.0).then(|| Duration::from_secs_f64(1.0 / field_hz));
        let thread = std::thread::Builder::new().name("publisher".into());
        let thread = thread.spawn(move || publish(targets, &records, &shared, every)).map_err(|error| {
            DestinationError::new("the publisher's thread", error.to_string(), "free memory")
        })?;
        let outlet = PublishOutlet { queue, slot, header: header.clone(), field_len, number: 0, counters };
        Ok((outlet, Self(thread)))
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
    records: &Receiver<Outgoing>,
    slot: &Handoff<FieldFrame>,
    every: Option<Duration>,
) {
    let mut due = Instant::now();
    let mut asked = false;
    loop {
        let record = records.recv_timeout(PATIENCE);
        targets.welcome();
        match record {
            Ok(Outgoing::Turn(packet, ended)) => targets.send(&leaving(&packet, ended), Readers::All),
            Ok(Outgoing::Whole(bytes)) => targets.send(&Whole(&bytes), Readers::Network),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_that_the_model_is_not_valid_for_are_left_out() {
        // Two tracers: six numbers of q, six of v, two of e, six of sigma, six of tau.
        let field: Vec<f32> = (0..2 * TRACER).map(|number| number as f32).collect();
        let groups = KnownGroups::NONE
            .with(FieldGroup::Velocity)
            .with(FieldGroup::ShearStress)
            .with(FieldGroup::Surface);
        let mut part = vec![-1.0; groups_len(field.len(), groups)];
        copy_groups(&field, groups, &mut part);
        assert_eq!(part, [6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 20.0, 21.0, 22.0, 23.0, 24.0, 25.0]);
        assert_eq!(groups_len(field.len(), KnownGroups::ALL), field.len());
        assert_eq!(groups_len(field.len(), KnownGroups::NONE), 0);
    }
}
