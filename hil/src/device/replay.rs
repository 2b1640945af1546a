//! Control answers and payload headers recorded from another camera.

use super::Reply;
use crate::camera::Stream;
use crate::payload::{COUNTER_AT, FID, FLAGS_AT};
use std::collections::HashMap;

/// One control request and its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ControlExchange {
    /// Setup packet without its length.
    pub setup: [u8; 6],
    /// Bytes sent.
    pub sent: Vec<u8>,
    /// Bytes that came.
    pub answer: Vec<u8>,
    /// Whether the request failed.
    pub failed: bool,
}

/// The other camera.
#[derive(Clone, Debug, Default)]
pub struct Replay {
    /// idVendor.
    pub vendor: u16,
    /// idProduct.
    pub product: u16,
    /// Serial number string.
    pub serial: String,
    /// Whether it was on USB 2.
    pub usb2: bool,
    /// Headers of the first payloads, depth and infrared.
    pub headers: [Vec<Vec<u8>>; 2],
    answers: Vec<(ControlExchange, Vec<u8>)>,
    sent: HashMap<[u8; 4], Vec<u8>>,
    /// The answer behind the last one that was given: the same question may have another answer later.
    next: usize,
}

impl Replay {
    /// Takes requests in the order in which they were made. What an answer means depends on what was
    /// sent to the same control before, as for the hardware monitor.
    #[must_use]
    pub fn saying(mut self, said: Vec<ControlExchange>) -> Self {
        let mut sent: HashMap<[u8; 4], Vec<u8>> = HashMap::new();
        for said in said {
            let control = control_of(said.setup);
            if said.setup[0] & 0x80 == 0 {
                sent.insert(control, said.sent.clone());
            }
            let before = sent.get(&control).cloned().unwrap_or_default();
            if !said.failed {
                self.answers.push((said, before));
            }
        }
        self
    }

    /// Answers a request; `None` for one that the other camera never heard.
    pub(super) fn control(&mut self, setup: [u8; 6], sent: &[u8]) -> Option<Reply> {
        let control = control_of(setup);
        if setup[0] & 0x80 == 0 {
            self.sent.insert(control, sent.to_vec());
        }
        let before = self.sent.get(&control).cloned().unwrap_or_default();
        let onwards = (self.next..self.answers.len()).chain(0..self.next);
        let mut same = onwards.filter(|at| self.answers[*at].0.setup == setup);
        let exact = same.clone().find(|at| self.answers[*at].1 == before);
        let at = exact.or_else(|| same.next())?;
        self.next = at + 1;
        let (said, _) = &self.answers[at];
        Some(if setup[0] & 0x80 == 0 { Reply::Done } else { Reply::Data(said.answer.clone()) })
    }

    /// A payload with the other camera's header: the first ones as they were, the later ones with the last
    /// header's time, counter and frame identifier moved on.
    pub(super) fn payload(&self, stream: Stream, shot: u64, own: Vec<u8>) -> Vec<u8> {
        let headers = &self.headers[usize::from(stream != Stream::Depth)];
        let Some(last) = headers.len().checked_sub(1) else { return own };
        let at = usize::try_from(shot).unwrap_or(last).min(last);
        let mut header = headers[at].clone();
        let beyond = shot.saturating_sub(last as u64);
        if beyond > 0 {
            let add = |header: &mut Vec<u8>, at: usize, more: u64| {
                if let Some(Some(field)) = header.get_mut(at..).map(<[u8]>::first_chunk_mut) {
                    *field = u32::from_le_bytes(*field).wrapping_add(more as u32).to_le_bytes();
                }
            };
            add(&mut header, 2, super::shot_time_us(beyond));
            add(&mut header, 6, super::shot_time_us(beyond));
            add(&mut header, COUNTER_AT, beyond);
            if beyond % 2 == 1
                && let Some(flags) = header.get_mut(FLAGS_AT)
            {
                *flags ^= FID;
            }
        }
        let pixels = own.get(crate::payload::HEADER_LENGTH..).unwrap_or(&[]);
        [&header[..], pixels].concat()
    }
}

/// wValue and wIndex: which control of which unit.
fn control_of(setup: [u8; 6]) -> [u8; 4] {
    [setup[2], setup[3], setup[4], setup[5]]
}
