//! The request blocks of one camera: control requests answered at once, reads kept until something is due.

use super::wire::{self, Command, HEADER, status};
use crate::device::{Device, Ending, Event, Reply};
use crate::standard_requests;
use std::collections::{HashMap, VecDeque};
use std::io::{self, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Instant, SystemTime};

/// Offset of the frame counter in a payload's header.
const COUNTER_AT: usize = crate::payload::COUNTER_AT;

/// A payload on its way, as the camera's side saw it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    /// When, by the machine's clock.
    pub at: SystemTime,
    /// Its endpoint.
    pub endpoint: u8,
    /// The frame counter in its header; 0 where there is none.
    pub counter: u32,
    /// Whether a read was waiting for it.
    pub read: bool,
}

/// Observations of the camera's side, independent of the reader.
#[derive(Clone, Debug, Default)]
pub struct Witness {
    /// Payloads in the order of their time.
    pub sent: Vec<Sent>,
    /// When the camera was attached to the port, each time.
    pub attached: Vec<SystemTime>,
    /// When it left.
    pub left: Vec<SystemTime>,
    /// Port resets that the kernel made.
    pub resets: u32,
}

/// A read that waits.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    number: u32,
    endpoint: u8,
    length: usize,
}

/// The camera, its clock and what waits for it. Everything here is under one lock, the answers to the kernel
/// included: an unlink's answer has to say truly whether the block's own answer has gone out.
#[derive(Debug)]
pub(super) struct Bus {
    pub(super) device: Device,
    pub(super) begun: Instant,
    /// The kernel's end, while the camera is plugged in.
    pub(super) link: Option<UnixStream>,
    pub(super) witness: Witness,
    waiting: VecDeque<Waiting>,
    /// Rests of payloads that have begun, by endpoint.
    begun_payloads: HashMap<u8, Vec<u8>>,
    configured: bool,
}

impl Bus {
    pub(super) fn new(device: Device) -> Self {
        Self {
            device,
            begun: Instant::now(),
            link: None,
            witness: Witness::default(),
            waiting: VecDeque::new(),
            begun_payloads: HashMap::new(),
            configured: false,
        }
    }

    pub(super) fn now_us(&self) -> u64 {
        u64::try_from(self.begun.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    /// The camera is plugged in at the other end of `link`.
    pub(super) fn plug(&mut self, link: UnixStream) {
        (self.configured, self.link) = (false, Some(link));
        self.waiting.clear();
        self.begun_payloads.clear();
        self.witness.attached.push(SystemTime::now());
    }

    /// The camera is gone.
    pub(super) fn unplug(&mut self) {
        if let Some(link) = self.link.take() {
            // The kernel may have closed it already.
            let _closed = link.shutdown(std::net::Shutdown::Both);
            self.witness.left.push(SystemTime::now());
        }
        self.waiting.clear();
        self.begun_payloads.clear();
    }

    fn write(&mut self, header: &[u8; HEADER], bytes: &[u8]) {
        let Some(link) = &mut self.link else { return };
        // A kernel that has gone is noticed by the reader of this socket.
        let _gone = link.write_all(header).and_then(|()| link.write_all(bytes));
    }

    /// Takes one command of the kernel; `sent` has the bytes of an outgoing one.
    pub(super) fn take(&mut self, command: Command, sent: &[u8]) {
        match command {
            Command::Submit { number, endpoint: 0x00 | 0x80, length, setup } => {
                self.control(number, length, setup, sent);
            }
            Command::Submit { number, endpoint, length, .. } => {
                self.waiting.push_back(Waiting { number, endpoint, length });
                if let Some(rest) = self.begun_payloads.remove(&endpoint) {
                    self.fill(endpoint, &rest);
                }
            }
            Command::Unlink { number, other } => {
                let place = self.waiting.iter().position(|waiting| waiting.number == other);
                let found = place.and_then(|place| self.waiting.remove(place)).is_some();
                self.write(&wire::unlinked(number, if found { status::UNLINKED } else { 0 }), &[]);
            }
        }
    }

    fn control(&mut self, number: u32, length: usize, setup: [u8; 8], sent: &[u8]) {
        let now_us = self.now_us();
        let [request_type, request, low, high, unit, index, ..] = setup;
        let Some(seen) = self.device.seen(now_us) else { return };
        // Reading the device descriptor of a configured device is how the kernel begins after a port reset.
        if self.configured && (request_type, request, high) == (0x80, 6, 1) {
            self.configured = false;
            self.witness.resets += 1;
            if !self.device.reset(now_us) {
                return self.write(&wire::submitted(number, status::PROTOCOL, 0), &[]);
            }
        }
        if let Some(bytes) = standard_requests::answer(&seen, setup) {
            self.configured |= (request_type, request) == (0, 9);
            return self.answer(number, length, request_type, &bytes);
        }
        if (request_type, request, high) == (0x80, 6, 2) && !self.configured {
            let bytes = self.device.enumerated(now_us);
            return self.answer(number, length, request_type, &bytes);
        }
        match self.device.control(now_us, [request_type, request, low, high, unit, index], sent) {
            Reply::Data(bytes) => self.answer(number, length, request_type, &bytes),
            Reply::Done => self.write(&wire::submitted(number, 0, length), &[]),
            Reply::Stall => self.write(&wire::submitted(number, status::PIPE, 0), &[]),
            // A plug that is pulled in the middle of a request is seen by a host controller at once.
            Reply::Gone => self.write(&wire::submitted(number, status::PROTOCOL, 0), &[]),
            // The kernel will unlink it when its time is up.
            Reply::Silence => {
                self.waiting.push_back(Waiting { number, endpoint: 0, length });
            }
        }
    }

    /// Ends a control request well: at most `length` bytes inwards, all of them outwards.
    fn answer(&mut self, number: u32, length: usize, request_type: u8, bytes: &[u8]) {
        let inwards = request_type & 0x80 != 0;
        let bytes = if inwards { &bytes[..bytes.len().min(length)] } else { &[] };
        let done = if inwards { bytes.len() } else { length };
        self.write(&wire::submitted(number, 0, done), bytes);
    }

    /// Hands out what the device has due by now.
    pub(super) fn pump(&mut self) {
        while let Some(event) = self.device.due(self.now_us()) {
            self.deliver(event);
        }
    }

    fn deliver(&mut self, event: Event) {
        let read = self.waiting.iter().any(|waiting| waiting.endpoint == event.endpoint);
        let counter = event.what.as_ref().ok().and_then(|bytes| bytes.get(COUNTER_AT..)?.first_chunk());
        let counter = counter.map_or(0, |bytes| u32::from_le_bytes(*bytes));
        self.witness.sent.push(Sent { at: SystemTime::now(), endpoint: event.endpoint, counter, read });
        match event.what {
            // While the kernel has not taken the payload before, this one is lost in the camera.
            Ok(_) if self.begun_payloads.contains_key(&event.endpoint) => {}
            Ok(bytes) => self.fill(event.endpoint, &bytes),
            Err(ending) => {
                let status = match ending {
                    Ending::Error | Ending::Cancelled => status::PROTOCOL,
                    Ending::Stall => status::PIPE,
                    Ending::Overflow => status::OVERFLOW,
                    Ending::TimedOut => status::TIMED_OUT,
                };
                if let Some(waiting) = self.next(event.endpoint) {
                    self.write(&wire::submitted(waiting.number, status, 0), &[]);
                }
            }
        }
    }

    fn next(&mut self, endpoint: u8) -> Option<Waiting> {
        let place = self.waiting.iter().position(|waiting| waiting.endpoint == endpoint)?;
        self.waiting.remove(place)
    }

    /// A payload into the block that waits; what is longer than the block goes on in the next one, as packets
    /// on a bus do. Without a block it is lost; one that has begun waits for more, as a bus makes a device wait.
    fn fill(&mut self, endpoint: u8, mut bytes: &[u8]) {
        let whole = bytes.len();
        while let Some(waiting) = self.next(endpoint) {
            let (now, rest) = bytes.split_at(bytes.len().min(waiting.length));
            self.write(&wire::submitted(waiting.number, 0, now.len()), now);
            bytes = rest;
            if bytes.is_empty() {
                return;
            }
        }
        if bytes.len() < whole {
            self.begun_payloads.insert(endpoint, bytes.to_vec());
        }
    }
}

/// Reads one command with the bytes that follow it.
pub(super) fn receive(link: &mut impl Read) -> io::Result<(Command, Vec<u8>)> {
    let mut header = [0; HEADER];
    link.read_exact(&mut header)?;
    let command = Command::read(&header)
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidData, "no command of USB/IP"))?;
    let outwards = match command {
        Command::Submit { endpoint, length, .. } if endpoint & 0x80 == 0 => length,
        _ => 0,
    };
    let mut bytes = vec![0; outwards];
    link.read_exact(&mut bytes)?;
    Ok((command, bytes))
}
