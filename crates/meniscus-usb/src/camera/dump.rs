//! The dump: what a camera said at its first connection, as one JSON object that a simulated camera replays.
//!
//! ```json
//! { "format": 1, "program": "meniscus 0.1.0",
//!   "vendor": 32902, "product": 2823, "serial": "...", "port": "2-1", "speed": "USB 3, 5 Gbit/s or more",
//!   "controls": [ { "request_type": 161, "request": 129, "value": 256, "index": 1,
//!                   "sent": "", "answer": "0100...", "error": null } ],
//!   "depth": [ { "arrival_us": 1234, "bytes": 614632, "header": "e88f..." } ], "infrared": [ ] }
//! ```
//!
//! Every control request from opening to the start of the streams stands in `controls`, in its order:
//! the configuration descriptor (request 6, value 0x0200), the hardware monitor's commands (`sent`) and
//! their answers, probe and commit. Bytes are hexadecimal. `depth` and `infrared` hold the headers of the
//! first ten payloads. Serial numbers are in it; images are not.

use super::error::CameraError;
use super::session::Session;
use super::settings::Settings;
use super::sink::{Note, Sink};
use crate::buffer::Buffer;
use crate::transport::{Completion, Listed, NotQueued, Pipe, Transport, UsbError};
use meniscus::usb::uvc::Stream;
use meniscus::usb::uvc::request::Setup;
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Headers that are kept, a stream.
const HEADERS: usize = 10;
/// Payloads after which the dump ends even if one stream has brought none.
const PAYLOADS: usize = 120;

/// One control request.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DumpedControl {
    /// bmRequestType.
    pub request_type: u8,
    /// bRequest.
    pub request: u8,
    /// wValue.
    pub value: u16,
    /// wIndex.
    pub index: u16,
    /// Bytes sent.
    #[serde(with = "hexadecimal")]
    pub sent: Vec<u8>,
    /// Bytes that came.
    #[serde(with = "hexadecimal")]
    pub answer: Vec<u8>,
    /// Why it failed, if it did.
    pub error: Option<String>,
}

/// One payload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DumpedFrame {
    /// When it was there, microseconds since the first one of either stream.
    pub arrival_us: u64,
    /// Bytes of the payload.
    pub bytes: usize,
    /// Its header, as long as its first byte says.
    #[serde(with = "hexadecimal")]
    pub header: Vec<u8>,
}

/// Everything that was said.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Dump {
    /// Version of this format: 1.
    pub format: u32,
    /// Which program wrote it.
    pub program: String,
    /// idVendor.
    pub vendor: u16,
    /// idProduct.
    pub product: u16,
    /// Serial number that USB shows.
    pub serial: Option<String>,
    /// Bus and port path.
    pub port: String,
    /// Link speed, in words.
    pub speed: String,
    /// Control requests in their order.
    pub controls: Vec<DumpedControl>,
    /// First payloads of the depth stream.
    pub depth: Vec<DumpedFrame>,
    /// First payloads of the infrared stream.
    pub infrared: Vec<DumpedFrame>,
}

/// Connects, streams until ten payloads of each stream have come, and writes down what was said.
/// The second part says why it ended early, if it did: what was said until then is kept.
pub fn dump(transport: impl Transport, settings: Settings) -> (Dump, Option<CameraError>) {
    let mut controls = Vec::new();
    let mut devices = Vec::new();
    let witness = Witness { inner: transport, controls: &mut controls, opened: &mut devices };
    let mut headers = Headers::default();
    let ended =
        Session::connect(witness, settings).and_then(|mut session| session.stream(&mut headers)).err();
    let mut dump = Dump {
        format: 1,
        program: concat!("meniscus ", env!("CARGO_PKG_VERSION")).into(),
        controls,
        depth: headers.depth,
        infrared: headers.infrared,
        ..Dump::default()
    };
    if let Some(device) = devices.pop() {
        let Listed { port, vendor, product, serial, speed } = device;
        dump = Dump { port, vendor, product, serial, speed: speed.to_string(), ..dump };
    }
    (dump, ended)
}

/// Keeps the headers of the first payloads.
#[derive(Default)]
struct Headers {
    depth: Vec<DumpedFrame>,
    infrared: Vec<DumpedFrame>,
    seen: usize,
    begun: Option<std::time::Instant>,
    spare: Vec<Buffer>,
}

impl Sink for Headers {
    fn wanted(&mut self) -> bool {
        self.seen < PAYLOADS && (self.depth.len() < HEADERS || self.infrared.len() < HEADERS)
    }

    fn spare(&mut self) -> Option<Buffer> {
        self.spare.pop().or_else(|| Some(Buffer::new(640 * 480 * 2 + 1024)))
    }

    fn deliver(&mut self, stream: Stream, payload: Buffer) -> bool {
        self.seen += 1;
        let begun = *self.begun.get_or_insert_with(std::time::Instant::now);
        let frames = match stream {
            Stream::Depth => &mut self.depth,
            Stream::Outline => &mut self.infrared,
        };
        if frames.len() < HEADERS {
            let length = payload.first().map_or(0, |length| usize::from(*length)).min(payload.len());
            frames.push(DumpedFrame {
                arrival_us: u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX),
                bytes: payload.len(),
                header: payload[..length].to_vec(),
            });
        }
        self.spare.push(payload);
        true
    }

    fn dropped(&mut self) {}

    fn note(&mut self, _: Note) {}
}

/// A transport that writes down every control request.
struct Witness<'d, T> {
    inner: T,
    controls: &'d mut Vec<DumpedControl>,
    opened: &'d mut Vec<Listed>,
}

impl<T> Witness<'_, T> {
    fn write_down<R>(&mut self, setup: Setup, sent: &[u8], answer: &[u8], ended: &Result<R, UsbError>) {
        let Setup { request_type, request, value, index } = setup;
        let error = ended.as_ref().err().map(UsbError::to_string);
        let (sent, answer) = (sent.to_vec(), answer.to_vec());
        self.controls.push(DumpedControl { request_type, request, value, index, sent, answer, error });
    }
}

impl<T: Transport> Transport for Witness<'_, T> {
    fn control_in(&mut self, setup: Setup, into: &mut [u8], timeout: Duration) -> Result<usize, UsbError> {
        let ended = self.inner.control_in(setup, into, timeout);
        let length = ended.unwrap_or(0).min(into.len());
        self.write_down(setup, &[], &into[..length], &ended);
        ended
    }

    fn control_out(&mut self, setup: Setup, bytes: &[u8], timeout: Duration) -> Result<(), UsbError> {
        let ended = self.inner.control_out(setup, bytes, timeout);
        self.write_down(setup, bytes, &[], &ended);
        ended
    }

    fn open(&mut self, device: &Listed) -> Result<(), UsbError> {
        self.opened.push(device.clone());
        self.inner.open(device)
    }

    fn now(&mut self) -> Duration {
        self.inner.now()
    }

    fn pause(&mut self, time: Duration) {
        self.inner.pause(time);
    }

    fn list(&mut self) -> Result<Vec<Listed>, UsbError> {
        self.inner.list()
    }

    fn close(&mut self) {
        self.inner.close();
    }

    fn claim(&mut self, interface: u8) -> Result<(), UsbError> {
        self.inner.claim(interface)
    }

    fn clear_halt(&mut self, endpoint: u8) -> Result<(), UsbError> {
        self.inner.clear_halt(endpoint)
    }

    fn submit(&mut self, pipe: Pipe, endpoint: u8, buffer: Buffer) -> Result<(), NotQueued> {
        self.inner.submit(pipe, endpoint, buffer)
    }

    fn reap(&mut self, wait: Duration) -> Option<Completion> {
        self.inner.reap(wait)
    }

    fn cancel(&mut self) {
        self.inner.cancel();
    }

    fn in_flight(&self) -> usize {
        self.inner.in_flight()
    }

    fn reset(&mut self) -> Result<(), UsbError> {
        self.inner.reset()
    }
}

/// Bytes as two digits each.
mod hexadecimal {
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::Serializer;

    pub(super) fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        serializer.serialize_str(&digits)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<u8>, D::Error> {
        let text = String::deserialize(deserializer)?;
        let wrong = || D::Error::custom("bytes must be pairs of hexadecimal digits");
        if !text.is_ascii() || !text.len().is_multiple_of(2) {
            return Err(wrong());
        }
        let pair = |at| u8::from_str_radix(&text[at..at + 2], 16).map_err(|_| wrong());
        (0..text.len()).step_by(2).map(pair).collect()
    }
}
