//! The simulated camera below the transport: a bus with one device, in virtual time or in real time.
//!
//! In virtual time nothing sleeps: waiting moves the clock. In real time the same events happen when
//! their time has come, so that a program can run on it.

use meniscus::usb::uvc::request::Setup;
use meniscus_hil::device::{Device, Ending, Reply, Trouble};
use meniscus_usb::buffer::Buffer;
use meniscus_usb::transport::{Completion, Listed, NotQueued, Pipe, Speed, Status, Transport, UsbError};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Port of the camera.
const PORT: &str = "2-1";
/// Time of a control request that is answered.
const CONTROL: Duration = Duration::from_micros(100);

/// The bus.
#[derive(Debug)]
pub struct SimulatedBus {
    device: Device,
    now: Duration,
    /// `now` in microseconds, for whoever does not hold the bus.
    watched_us: Arc<AtomicU64>,
    /// When the clock began, if it is to keep real time.
    real: Option<Instant>,
    opened: Option<Duration>,
    queued: Vec<(u8, Buffer)>,
    ended: VecDeque<Completion>,
    /// Cancelled transfers do not come back until the device is closed.
    stuck: bool,
    /// Payloads that found no transfer queued.
    pub unread: u64,
}

impl SimulatedBus {
    /// A bus in virtual time.
    #[must_use]
    pub fn new(device: Device) -> Self {
        let (queued, ended) = (Vec::new(), VecDeque::new());
        let (now, watched_us) = (Duration::ZERO, Arc::default());
        Self { device, now, watched_us, real: None, opened: None, queued, ended, stuck: false, unread: 0 }
    }

    /// The same in real time, from now on.
    #[must_use]
    pub fn in_real_time(mut self) -> Self {
        self.real = Some(Instant::now());
        self
    }

    /// Returns the device.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Returns the time of the bus in microseconds, which a sink reads while the session holds the bus.
    #[must_use]
    pub fn watch(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.watched_us)
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.now.as_micros()).unwrap_or(u64::MAX)
    }

    /// Moves the clock, and waits for it in real time.
    fn move_to(&mut self, time: Duration) {
        self.now = self.now.max(time);
        self.watched_us.store(self.now_us(), Ordering::Relaxed);
        if let Some(begun) = self.real {
            std::thread::sleep((begun + self.now).saturating_duration_since(Instant::now()));
        }
    }

    /// Real time that has passed outside of this bus has passed inside too.
    fn catch_up(&mut self) {
        if let Some(begun) = self.real {
            self.now = self.now.max(begun.elapsed());
        }
    }

    /// Whether the device is open and has not left the bus since.
    fn alive(&self) -> Result<(), UsbError> {
        let opened = self.opened.ok_or(UsbError::NoDevice)?;
        let left = self.device.left_us(self.now_us()).map(Duration::from_micros);
        if left.is_some_and(|left| left >= opened) { Err(UsbError::NoDevice) } else { Ok(()) }
    }

    fn control(&mut self, setup: Setup, sent: &[u8], timeout: Duration) -> Result<Vec<u8>, UsbError> {
        self.catch_up();
        self.run_to(self.now + CONTROL);
        self.alive()?;
        let ([value, selector], [index, unit]) = (setup.value.to_le_bytes(), setup.index.to_le_bytes());
        let packet = [setup.request_type, setup.request, value, selector, index, unit];
        match self.device.control(self.now_us(), packet, sent) {
            Reply::Data(bytes) => Ok(bytes),
            Reply::Done => Ok(Vec::new()),
            Reply::Stall => Err(UsbError::Stall),
            Reply::Gone => Err(UsbError::NoDevice),
            Reply::Silence => {
                self.run_to(self.now + timeout);
                Err(UsbError::Timeout)
            }
        }
    }

    /// Lets the device work until `time`.
    fn run_to(&mut self, time: Duration) {
        while self.step(time) {}
        self.move_to(time);
    }

    /// The next event up to `time`, if there is one.
    fn step(&mut self, time: Duration) -> bool {
        let until_us = u64::try_from(time.as_micros()).unwrap_or(u64::MAX);
        let Some(event) = self.device.due(until_us) else { return false };
        self.move_to(Duration::from_micros(event.at_us));
        let place = self.queued.iter().position(|(endpoint, _)| *endpoint == event.endpoint);
        let Some(place) = place.filter(|_| self.alive().is_ok()) else {
            self.unread += 1;
            return true;
        };
        let (endpoint, mut buffer) = self.queued.remove(place);
        let status = match event.what {
            Ok(bytes) if buffer.fill_from(&bytes) => Status::Completed,
            Ok(_) | Err(Ending::Overflow) => Status::Overflow,
            Err(Ending::Error) => Status::Error,
            Err(Ending::Stall) => Status::Stall,
            Err(Ending::TimedOut) => Status::TimedOut,
            Err(Ending::Cancelled) => Status::Cancelled,
        };
        if status != Status::Completed {
            buffer.set_filled(0);
        }
        self.ended.push_back(Completion { endpoint, status, buffer });
        true
    }

    /// Ends everything that is queued.
    fn end_all(&mut self, status: Status) {
        if self.stuck {
            return;
        }
        for (endpoint, mut buffer) in self.queued.drain(..) {
            buffer.set_filled(0);
            self.ended.push_back(Completion { endpoint, status, buffer });
        }
    }

    fn has(&self, trouble: Trouble) -> bool {
        self.device.trouble() == Some(trouble)
    }
}

impl Transport for SimulatedBus {
    fn now(&mut self) -> Duration {
        self.catch_up();
        self.now
    }

    fn pause(&mut self, time: Duration) {
        self.catch_up();
        self.run_to(self.now + time);
    }

    fn list(&mut self) -> Result<Vec<Listed>, UsbError> {
        self.catch_up();
        let seen = self.device.seen(self.now_us());
        let listed = seen.map(|seen| Listed {
            port: PORT.into(),
            vendor: seen.vendor,
            product: seen.product,
            serial: Some(seen.serial),
            speed: if seen.usb2 { Speed::High } else { Speed::Super },
        });
        Ok(listed.into_iter().collect())
    }

    fn open(&mut self, _: &Listed) -> Result<(), UsbError> {
        self.close();
        self.device.seen(self.now_us()).ok_or(UsbError::NoDevice)?;
        if matches!(self.device.trouble(), Some(Trouble::Denied(_))) && self.device.strike() {
            return Err(UsbError::Access);
        }
        if self.has(Trouble::OpenRace) && self.device.strike() {
            return Err(UsbError::Io);
        }
        self.opened = Some(self.now + Duration::from_micros(1));
        Ok(())
    }

    fn close(&mut self) {
        self.queued.clear();
        self.ended.clear();
        self.stuck = false;
        self.opened = None;
    }

    fn control_in(&mut self, setup: Setup, into: &mut [u8], timeout: Duration) -> Result<usize, UsbError> {
        let bytes = self.control(setup, &[], timeout)?;
        into.iter_mut().zip(&bytes).for_each(|(to, from)| *to = *from);
        Ok(bytes.len().min(into.len()))
    }

    fn control_out(&mut self, setup: Setup, bytes: &[u8], timeout: Duration) -> Result<(), UsbError> {
        self.control(setup, bytes, timeout).map(drop)
    }

    fn claim(&mut self, _: u8) -> Result<(), UsbError> {
        self.alive()?;
        let busy = matches!(self.device.trouble(), Some(Trouble::Busy(_))) && self.device.strike();
        if busy { Err(UsbError::Busy) } else { Ok(()) }
    }

    fn clear_halt(&mut self, endpoint: u8) -> Result<(), UsbError> {
        // As a real host controller does it: an endpoint with transfers in flight is refused.
        if self.queued.iter().any(|(queued, _)| *queued == endpoint) {
            return Err(UsbError::Io);
        }
        let setup = Setup { request_type: 0x02, request: 1, value: 0, index: endpoint.into() };
        self.control(setup, &[], Duration::from_secs(1)).map(drop)
    }

    fn submit(&mut self, _: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), NotQueued> {
        let error = match self.alive() {
            Err(error) => Some(error),
            Ok(()) => self.has(Trouble::NoMemory).then_some(UsbError::NoMemory),
        };
        if let Some(error) = error {
            return Err(NotQueued { error, buffer });
        }
        self.queued.push((endpoint, buffer));
        Ok(())
    }

    fn reap(&mut self, wait: Duration) -> Option<Completion> {
        self.catch_up();
        let deadline = self.now + wait;
        loop {
            if let Some(ended) = self.ended.pop_front() {
                return Some(ended);
            }
            let happened = self.step(deadline);
            if self.opened.is_some() && self.alive().is_err() {
                self.end_all(Status::NoDevice);
            }
            if !happened && self.ended.is_empty() {
                self.move_to(deadline);
                // The device may leave between two events.
                if self.opened.is_some() && self.alive().is_err() {
                    self.end_all(Status::NoDevice);
                }
                return self.ended.pop_front();
            }
        }
    }

    fn cancel(&mut self) {
        self.stuck |= self.has(Trouble::DrainStuck) && self.device.is_struck();
        self.end_all(Status::Cancelled);
    }

    fn in_flight(&self) -> usize {
        self.queued.len() + self.ended.len()
    }

    fn reset(&mut self) -> Result<(), UsbError> {
        self.alive()?;
        self.run_to(self.now + Duration::from_millis(156));
        if self.device.reset(self.now_us()) { Ok(()) } else { Err(UsbError::Timeout) }
    }
}
