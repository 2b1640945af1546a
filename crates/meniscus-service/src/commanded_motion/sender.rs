//! Senders of datagrams: which one is listened to, and how much of it.
//!
//! A sender is named by `A`: the address of a socket, or the identifier of a ROS 2 publisher.
//!
//! One sender has the word at a time: the first one whose datagram is good. Another one gets it when the first has been silent
//! for a while, or when the camera has denied what it said. Its samples are taken up to a rate, so that no flood, not even its
//! own, pushes the samples out that a turn needs.

use super::datagram::Datagram;
use std::net::IpAddr;

/// Silence after which another sender may have the word, s.
const SILENCE_S: f64 = 1.0;
/// Samples of a second at most, and those that may come at once: a receiver that was held up gets them in bursts.
const RATE_HZ: f64 = 1_100.0;
const BURST: f64 = 64.0;
/// Senders that the camera has denied and that are remembered, and for how long, s: another one may have the word meanwhile.
const DENIED: usize = 8;
const DENIED_S: f64 = 5.0;

/// Receiver of messages for a person.
pub type Say = Box<dyn Fn(&str) + Send>;

/// Sender that is expected.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedSender {
    /// Its address; any, where `None`.
    pub address: Option<IpAddr>,
    /// Word that each datagram begins with.
    pub token: Option<String>,
}

/// Verdict on a datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// It is a sample.
    Sample,
    /// It is of a sender that has not the word.
    Stranger,
    /// Its number does not follow: a repeated or late datagram.
    Repeated,
    /// It is one too many.
    Flood,
}

/// The sender that has the word.
#[derive(Clone, Copy, Debug)]
struct Speaker<A> {
    address: A,
    heard_s: f64,
    number: Option<u64>,
    /// Samples that may come now.
    budget: f64,
}

/// Whoever is listened to.
#[derive(Debug)]
pub(super) struct Floor<A> {
    speaker: Option<Speaker<A>>,
    /// Senders that were denied, and when.
    denied: [Option<(A, f64)>; DENIED],
    next_denied: usize,
}

impl<A: Copy + PartialEq> Default for Floor<A> {
    fn default() -> Self {
        Self { speaker: None, denied: [None; DENIED], next_denied: 0 }
    }
}

impl<A: Copy + PartialEq> Floor<A> {
    /// Returns the name of the sender that has the word.
    pub(super) fn speaker(&self) -> Option<A> {
        self.speaker.map(|speaker| speaker.address)
    }

    /// Whether the speaker has been silent for so long at `now_s` that another one may have the word.
    pub(super) fn is_open(&self, now_s: f64) -> bool {
        self.speaker.is_none_or(|speaker| now_s - speaker.heard_s > SILENCE_S)
    }

    /// Takes the word from a speaker that the camera has denied at `now_s`. It may come back, and be compared again.
    pub(super) fn deny(&mut self, now_s: f64) {
        if let Some(speaker) = self.speaker.take() {
            self.denied[self.next_denied] = Some((speaker.address, now_s));
            self.next_denied = (self.next_denied + 1) % DENIED;
        }
    }

    /// Judges a good datagram of `from` at `now_s`.
    pub(super) fn hear(&mut self, from: A, datagram: &Datagram, now_s: f64) -> Heard {
        let new = Speaker { address: from, heard_s: now_s, number: None, budget: BURST };
        let is_denied = |(address, since_s): &(A, f64)| *address == from && now_s - since_s < DENIED_S;
        if self.is_open(now_s) && self.denied.iter().flatten().any(is_denied) {
            return Heard::Stranger;
        }
        if self.is_open(now_s) && self.speaker() != Some(from) {
            self.speaker = Some(new);
        }
        let open = self.is_open(now_s);
        let Some(speaker) = self.speaker.as_mut().filter(|speaker| speaker.address == from) else {
            return Heard::Stranger;
        };
        if open {
            // A sender that was started again begins its numbers anew.
            *speaker = new;
        }
        if speaker.number.is_some() && datagram.number <= speaker.number {
            return Heard::Repeated;
        }
        speaker.budget = (speaker.budget + RATE_HZ * (now_s - speaker.heard_s)).min(BURST);
        (speaker.heard_s, speaker.number) = (now_s, datagram.number);
        if speaker.budget < 1.0 {
            return Heard::Flood;
        }
        speaker.budget -= 1.0;
        Heard::Sample
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::SocketAddr;

    fn of(port: u16) -> SocketAddr {
        ([127, 0, 0, 1], port).into()
    }

    fn plain(number: Option<u64>) -> Datagram {
        Datagram { number, acceleration: 0.0 }
    }

    #[test]
    fn one_sender_has_the_word_until_it_is_silent() {
        let mut floor = Floor::default();
        assert_eq!(floor.hear(of(1), &plain(None), 0.0), Heard::Sample);
        assert_eq!(floor.hear(of(2), &plain(None), 0.5), Heard::Stranger);
        assert_eq!(floor.hear(of(1), &plain(None), 0.9), Heard::Sample);
        assert_eq!(floor.hear(of(2), &plain(None), 1.5), Heard::Stranger);
        assert_eq!(floor.hear(of(2), &plain(None), 2.0), Heard::Sample, "the first one was silent");
        assert_eq!(floor.hear(of(1), &plain(None), 2.1), Heard::Stranger);
        floor.deny(2.15);
        assert_eq!(floor.hear(of(2), &plain(None), 2.2), Heard::Stranger, "the camera has denied it");
        assert_eq!(floor.hear(of(1), &plain(None), 2.3), Heard::Sample);
        assert_eq!(floor.hear(of(2), &plain(None), 7.2), Heard::Sample, "it may try again");
    }

    #[test]
    fn numbers_rise_once_there_are_some() {
        let mut floor = Floor::default();
        for (number, heard) in [
            (Some(5), Heard::Sample),
            (Some(5), Heard::Repeated),
            (Some(4), Heard::Repeated),
            (None, Heard::Repeated),
            (Some(9), Heard::Sample),
        ] {
            assert_eq!(floor.hear(of(1), &plain(number), 0.1), heard, "{number:?}");
        }
        assert_eq!(floor.hear(of(1), &plain(Some(1)), 2.0), Heard::Sample, "started again");
    }

    #[test]
    fn a_flood_is_thinned_to_the_rate() {
        let mut floor = Floor::default();
        let taken =
            (0..100_000).filter(|k| floor.hear(of(1), &plain(None), f64::from(*k) * 1e-5) == Heard::Sample);
        let taken = taken.count();
        assert!((1_000..1_200).contains(&taken), "{taken} in a second");
        let mut floor = Floor::default();
        let all = (0..1000).all(|k| floor.hear(of(1), &plain(None), f64::from(k) * 1e-3) == Heard::Sample);
        assert!(all, "1 kHz is taken whole");
    }
}
