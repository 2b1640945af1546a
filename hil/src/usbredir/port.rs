//! The port that QEMU holds out: requests in, answers out, the device's clock.

use super::shape;
use super::wire::{self, Control, Message, kind, status};
use crate::device::{Device, Ending, Event, INTERRUPT, Reply};
use crate::standard_requests;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// Request from QEMU.
#[derive(Clone, Debug)]
pub struct Request(Message);

/// Reads the next request; blocks until there is one.
///
/// # Errors
/// The socket's error, and [`io::ErrorKind::InvalidData`] for what is no message.
pub fn read(link: &mut UnixStream) -> io::Result<Request> {
    Message::read(link).map(Request)
}

/// Counts of bus events since the camera was plugged in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Times it was on the bus.
    pub connected: u32,
    /// Configurations that were set.
    pub configured: u32,
    /// Resets of the port.
    pub resets: u32,
    /// Requests that were taken back while they waited.
    pub cancelled: u32,
    /// Requests that were taken back when their answer was on its way.
    pub cancelled_late: u32,
    /// Halts that were cleared.
    pub halts_cleared: u32,
    /// Those of them that a stall had come before.
    pub stalls_cleared: u32,
    /// Reads that ended in a stall.
    pub stalled: u32,
    /// Reads that brought bytes.
    pub filled: u32,
    /// Payloads that found no read.
    pub unread: u32,
}

/// A read that waits.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    number: u64,
    endpoint: u8,
    length: usize,
}

/// The camera at QEMU's port.
pub struct Redirected {
    link: UnixStream,
    begun: Instant,
    greeted: bool,
    device: Option<Device>,
    shown: bool,
    /// QEMU has not yet said that the device is gone.
    leaving: bool,
    configuration: u8,
    status_wanted: bool,
    waiting: VecDeque<Waiting>,
    /// Endpoints that stall whatever is asked of them.
    halted: Vec<u8>,
    silent: Vec<(u64, Control)>,
    counts: Counts,
}

impl Redirected {
    /// Greets QEMU.
    ///
    /// # Errors
    /// The socket's error.
    pub fn new(mut link: UnixStream) -> io::Result<Self> {
        link.write_all(&Message::hello().bytes())?;
        Ok(Self {
            link,
            begun: Instant::now(),
            greeted: false,
            device: None,
            shown: false,
            leaving: false,
            configuration: 0,
            status_wanted: false,
            waiting: VecDeque::new(),
            halted: Vec::new(),
            silent: Vec::new(),
            counts: Counts::default(),
        })
    }

    /// Puts a camera into the port; it comes and goes as its trouble says.
    pub fn plug(&mut self, device: Device) {
        (self.device, self.begun, self.counts) = (Some(device), Instant::now(), Counts::default());
    }

    /// Takes it out.
    ///
    /// # Errors
    /// The socket's error.
    pub fn unplug(&mut self) -> io::Result<Counts> {
        self.device = None;
        self.pump()?;
        Ok(self.counts)
    }

    fn now_us(&self) -> u64 {
        u64::try_from(self.begun.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    fn send(&mut self, message: &Message) -> io::Result<()> {
        self.link.write_all(&message.bytes())
    }

    /// Time until something can be due.
    #[must_use]
    pub fn wait(&self) -> Duration {
        const LOOK: Duration = Duration::from_millis(5);
        let due = self.device.as_ref().and_then(Device::next_us);
        due.map_or(LOOK, |at_us| Duration::from_micros(at_us.saturating_sub(self.now_us())).min(LOOK))
    }

    /// Plugs, unplugs and payloads that are due.
    ///
    /// # Errors
    /// The socket's error.
    pub fn pump(&mut self) -> io::Result<()> {
        let now_us = self.now_us();
        let seen = self.device.as_ref().and_then(|device| device.seen(now_us));
        match (seen, self.shown) {
            (None, true) => {
                (self.shown, self.leaving, self.status_wanted) = (false, true, false);
                self.waiting.clear();
                self.halted.clear();
                self.silent.clear();
                self.send(&Message::new(kind::DISCONNECT, 0, vec![]))?;
            }
            (Some(seen), false) if self.greeted && !self.leaving => {
                let configuration = self.device.as_ref().map_or(vec![], |device| device.enumerated(now_us));
                (self.shown, self.configuration) = (true, 0);
                self.counts.connected += 1;
                for message in shape::connect(&seen, &configuration) {
                    self.send(&message)?;
                }
            }
            _ => {}
        }
        while let Some(event) = self.device.as_mut().and_then(|device| device.due(now_us)) {
            self.deliver(event)?;
        }
        Ok(())
    }

    fn deliver(&mut self, event: Event) -> io::Result<()> {
        let answer = match event.what {
            Ok(_) => status::SUCCESS,
            Err(Ending::Stall) => status::STALL,
            Err(Ending::Overflow) => status::BABBLE,
            Err(Ending::TimedOut) => status::TIMED_OUT,
            Err(Ending::Error | Ending::Cancelled) => status::IO_ERROR,
        };
        let bytes = event.what.unwrap_or_default();
        if event.endpoint == INTERRUPT {
            let packet = wire::interrupt(0, INTERRUPT, answer, &bytes);
            return if self.status_wanted { self.send(&packet) } else { Ok(()) };
        }
        if answer == status::STALL {
            self.halted.push(event.endpoint);
            return self.refuse();
        }
        let mut rest = &bytes[..];
        // What is longer than a read goes on in the next one, as packets on a bus do.
        loop {
            let place = self.waiting.iter().position(|waiting| waiting.endpoint == event.endpoint);
            let Some(read) = place.and_then(|place| self.waiting.remove(place)) else {
                self.counts.unread += 1;
                return Ok(());
            };
            let (now, behind) = rest.split_at(rest.len().min(read.length));
            self.counts.filled += u32::from(answer == status::SUCCESS);
            self.send(&wire::bulk(read.number, read.endpoint, answer, now))?;
            rest = behind;
            if rest.is_empty() {
                return Ok(());
            }
        }
    }

    /// Ends the reads of halted endpoints.
    fn refuse(&mut self) -> io::Result<()> {
        while let Some(place) = self.waiting.iter().position(|read| self.halted.contains(&read.endpoint)) {
            let Some(read) = self.waiting.remove(place) else { break };
            self.counts.stalled += 1;
            self.send(&wire::bulk(read.number, read.endpoint, status::STALL, &[]))?;
        }
        Ok(())
    }

    /// Takes a request of QEMU's.
    ///
    /// # Errors
    /// The socket's error.
    pub fn take(&mut self, Request(message): Request) -> io::Result<()> {
        let (number, first) = (message.number, message.byte(0));
        let answer = |kind, body: &[u8]| Message::new(kind, number, body.to_vec());
        match message.kind {
            kind::HELLO => self.greeted = true,
            kind::DISCONNECT_ACK => self.leaving = false,
            kind::RESET => {
                self.counts.resets += 1;
                let now_us = self.now_us();
                // A device that does not hear it says nothing to that; neither does the protocol.
                let _heard = self.device.as_mut().is_some_and(|device| device.reset(now_us));
            }
            kind::SET_CONFIGURATION => {
                self.configuration = first;
                self.counts.configured += 1;
                self.send(&answer(kind::CONFIGURATION, &[status::SUCCESS, first]))?;
            }
            kind::GET_CONFIGURATION => {
                let set = self.configuration;
                self.send(&answer(kind::CONFIGURATION, &[status::SUCCESS, set]))?;
            }
            // Every interface has one setting.
            kind::SET_ALTERNATE | kind::GET_ALTERNATE => {
                let known = if message.byte(1) == 0 { status::SUCCESS } else { status::STALL };
                self.send(&answer(kind::ALTERNATE, &[known, first, 0]))?;
            }
            kind::START_INTERRUPT | kind::STOP_INTERRUPT => {
                self.status_wanted = message.kind == kind::START_INTERRUPT;
                self.send(&answer(kind::INTERRUPT_STATUS, &[status::SUCCESS, first]))?;
            }
            kind::CANCEL => self.cancel(number)?,
            kind::BULK if first & 0x80 != 0 => {
                let length = wire::bulk_length(&message);
                self.waiting.push_back(Waiting { number, endpoint: first, length });
                self.refuse()?;
            }
            kind::CONTROL => self.control(&message)?,
            // What else there is, this device's endpoints do not have.
            _ => {}
        }
        self.pump()
    }

    fn cancel(&mut self, number: u64) -> io::Result<()> {
        let read = self.waiting.iter().position(|waiting| waiting.number == number);
        let read = read.and_then(|place| self.waiting.remove(place));
        let silent = self.silent.iter().position(|(known, _)| *known == number);
        let silent = silent.map(|place| self.silent.swap_remove(place));
        match (read, silent) {
            (Some(read), _) => {
                self.counts.cancelled += 1;
                self.send(&wire::bulk(number, read.endpoint, status::CANCELLED, &[]))
            }
            (None, Some((_, control))) => {
                self.counts.cancelled += 1;
                self.send(&control.answer(number, status::CANCELLED, 0, &[]))
            }
            (None, None) => {
                self.counts.cancelled_late += 1;
                Ok(())
            }
        }
    }

    fn control(&mut self, message: &Message) -> io::Result<()> {
        let Some((control, sent)) = Control::read(message) else { return Ok(()) };
        let (now_us, number, setup) = (self.now_us(), message.number, control.setup);
        let [of, request, low, high, unit, index, ..] = setup;
        let Some(device) = &mut self.device else {
            return self.send(&control.answer(number, status::IO_ERROR, 0, &[]));
        };
        let Some(seen) = device.seen(now_us) else {
            return self.send(&control.answer(number, status::IO_ERROR, 0, &[]));
        };
        let reply = match standard_requests::answer(&seen, setup) {
            Some(bytes) => Reply::Data(bytes),
            None if (of, request, high) == (0x80, 6, 2) && self.configuration == 0 => {
                Reply::Data(device.enumerated(now_us))
            }
            None => device.control(now_us, [of, request, low, high, unit, index], sent),
        };
        if (of, request, low, high) == (0x02, 1, 0, 0) {
            self.counts.halts_cleared += 1;
            self.counts.stalls_cleared += u32::from(self.halted.contains(&unit));
            self.halted.retain(|endpoint| *endpoint != unit);
        }
        let answer = match reply {
            Reply::Data(bytes) if of & 0x80 != 0 => {
                let bytes = &bytes[..bytes.len().min(control.length())];
                control.answer(number, status::SUCCESS, bytes.len(), bytes)
            }
            Reply::Data(_) | Reply::Done => control.answer(number, status::SUCCESS, control.length(), &[]),
            Reply::Stall => control.answer(number, status::STALL, 0, &[]),
            Reply::Gone => control.answer(number, status::IO_ERROR, 0, &[]),
            // The kernel takes it back when its time is up.
            Reply::Silence => {
                self.silent.push((number, control));
                return Ok(());
            }
        };
        self.send(&answer)
    }
}
