//! Thread that listens for datagrams.

use super::datagram::{Datagram, LONGEST, read};
use super::denial::Denials;
use super::frame;
use super::sender::{ExpectedSender, Floor, Heard, Say};
use super::stamped_wire::{StampedSink, StampedWire};
use super::{Inner, MotionCounters};
use crate::clock_map::ClockMap;
use std::io::Result;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Interval at which the listener checks whether it is still wanted.
const PAUSE: Duration = Duration::from_millis(100);

/// Everything that the thread needs.
pub(super) struct Listener {
    /// Where it listens.
    pub(super) address: SocketAddr,
    /// Sender that is expected.
    pub(super) expected: ExpectedSender,
    /// Clock of the samples.
    pub(super) clock: ClockMap,
    /// The samples.
    pub(super) inner: Arc<Mutex<Inner>>,
    /// Counters of the datagrams.
    pub(super) counters: Arc<MotionCounters>,
    /// The run has ended.
    pub(super) ended: Arc<AtomicBool>,
    /// Receiver of messages.
    pub(super) say: Say,
}

/// Opens a socket at `address` whose reads end by themselves.
pub(super) fn bind(address: SocketAddr) -> Result<UdpSocket> {
    let socket = UdpSocket::bind(address)?;
    socket.set_read_timeout(Some(PAUSE))?;
    Ok(socket)
}

impl Listener {
    /// Listens until the run ends.
    pub(super) fn run(self, socket: UdpSocket) {
        let (mut socket, mut floor, mut room) = (socket, Floor::default(), [0; LONGEST]);
        let mut stamped = StampedWire::new(self.clock);
        // The address as it was chosen: a socket that is opened anew has to have the same port.
        let address = socket.local_addr().unwrap_or(self.address);
        let (mut bound_to, mut denials) = (None, Denials::default());
        while !self.ended.load(Ordering::Relaxed) {
            if let Ok((length, from)) = socket.recv_from(&mut room) {
                self.take(&mut floor, &mut stamped, room.get(..length).unwrap_or(&[]), from);
            }
            stamped.look(&self.counters.stamped, &self.say);
            if denials.look(&self.counters, &self.say) {
                floor.deny(self.clock.seconds(Instant::now()));
            }
            // A socket that is connected gets nothing of others, so that their flood does not fill its queue.
            let now_s = self.clock.seconds(Instant::now());
            let wanted = floor.speaker().filter(|_| !floor.is_open(now_s));
            if wanted != bound_to {
                match wanted {
                    Some(speaker) if socket.connect(speaker).is_ok() => bound_to = wanted,
                    Some(_) => {}
                    None => {
                        // Only a new socket hears everybody again. The old one has to go first: it holds the port.
                        drop(socket);
                        let Some(open) = self.reopen(address) else { return };
                        (socket, bound_to) = (open, None);
                    }
                }
            }
        }
    }

    /// Opens the socket again; `None` when the run ends meanwhile.
    fn reopen(&self, address: SocketAddr) -> Option<UdpSocket> {
        while !self.ended.load(Ordering::Relaxed) {
            if let Ok(socket) = bind(address) {
                return Some(socket);
            }
            std::thread::sleep(PAUSE);
        }
        None
    }

    /// Takes one datagram.
    fn take(&self, floor: &mut Floor<SocketAddr>, stamped: &mut StampedWire, bytes: &[u8], from: SocketAddr) {
        let now_s = self.clock.seconds(Instant::now());
        let counters = &self.counters;
        let from_ip = from.ip().to_canonical();
        if self.expected.address.is_some_and(|address| address.to_canonical() != from_ip) {
            counters.strangers.fetch_add(1, Ordering::Relaxed);
            return;
        }
        let token = self.expected.token.as_deref();
        if let Some(frame) = frame::read(bytes, token) {
            let heard = frame.map(|frame| (frame, floor.hear(from, &Datagram::WITHOUT_NUMBER, now_s)));
            let sink = StampedSink { inner: &self.inner, counters: &self.counters, say: &self.say };
            return stamped.take(&sink, heard);
        }
        let Some(datagram) = read(bytes, token) else {
            counters.refused.fetch_add(1, Ordering::Relaxed);
            return;
        };
        let counter = match floor.hear(from, &datagram, now_s) {
            Heard::Sample => {
                // The worker never panics with it in its hands.
                let Ok(mut inner) = self.inner.lock() else { return };
                inner.samples.push((now_s, datagram.acceleration));
                inner.is_stamped = false;
                &counters.samples
            }
            Heard::Stranger => &counters.strangers,
            Heard::Repeated => &counters.refused,
            Heard::Flood => &counters.flooded,
        };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}
