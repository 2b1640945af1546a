//! The fault injector: wraps a source and damages its payloads, seeded, so that a fault replays.

use crate::camera::{Payload, Shot, Source, Stream};
use crate::fault_list::{FaultKind, FaultList, When};
use crate::payload::{COUNTER_AT, EOF, ERR, FID, FLAGS_AT, HEADER_LENGTH};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Delay of a late payload: more than two frame intervals.
const LATE_US: u64 = 40_000;
/// Payloads of a split frame.
const PARTS: usize = 4;

/// A source with faults.
#[derive(Clone, Debug)]
pub struct FaultInjector<S> {
    inner: S,
    faults: FaultList,
    random: ChaCha8Rng,
    shot: u64,
    skipped: u32,
    held: Vec<Payload>,
}

impl<S> FaultInjector<S> {
    /// Wraps `inner`; the same seed gives the same faults.
    #[must_use]
    pub fn new(inner: S, faults: FaultList, seed: u64) -> Self {
        let random = ChaCha8Rng::seed_from_u64(seed);
        Self { inner, faults, random, shot: 0, skipped: 0, held: Vec::new() }
    }

    /// The source behind the faults.
    pub(crate) fn inner_mut(&mut self) -> &mut S {
        &mut self.inner
    }

    /// Lets a fault strike the next shot.
    pub(crate) fn strike_next(&mut self, kind: FaultKind) {
        self.faults.0.push((kind, When::Shot(self.shot)));
    }

    fn strikes(&mut self, when: When) -> bool {
        match when {
            When::Share(share) => self.random.random_bool(share),
            When::Shot(shot) => shot == self.shot,
        }
    }

    /// The faults that strike this time, each drawn once.
    fn draw(&mut self, of_camera: bool) -> Vec<FaultKind> {
        let faults = self.faults.0.clone();
        let candidates = faults.into_iter().filter(|(kind, _)| (*kind == FaultKind::Gap) == of_camera);
        candidates.filter(|(_, when)| self.strikes(*when)).map(|(kind, _)| kind).collect()
    }

    /// One payload after the faults: none, one or several.
    fn damage(&mut self, mut payload: Payload) -> Vec<Payload> {
        let mut copies = 1;
        let mut split = false;
        for kind in self.draw(false) {
            match kind {
                FaultKind::Drop => copies = 0,
                FaultKind::Tear if payload.bytes.len() > HEADER_LENGTH + 1 => {
                    let end = self.random.random_range(HEADER_LENGTH + 1..payload.bytes.len());
                    payload.bytes.truncate(end);
                }
                FaultKind::Late => payload.arrival_us += LATE_US,
                FaultKind::Fid => change(&mut payload, FLAGS_AT, |flags| flags ^ FID),
                FaultKind::Eof => change(&mut payload, FLAGS_AT, |flags| flags & !EOF),
                FaultKind::Err => change(&mut payload, FLAGS_AT, |flags| flags | ERR),
                FaultKind::Length0 => change(&mut payload, 0, |_| 0),
                FaultKind::Length2 => change(&mut payload, 0, |_| 2),
                FaultKind::Length200 => {
                    change(&mut payload, 0, |_| 200);
                    payload.bytes.truncate(150);
                }
                FaultKind::Duplicate => copies *= 2,
                FaultKind::Split => split = true,
                FaultKind::NoInfrared if payload.stream != Stream::Depth => copies = 0,
                FaultKind::Overlong => payload.bytes.extend([0; 64]),
                FaultKind::Empty => payload.bytes.clear(),
                FaultKind::Tear | FaultKind::NoInfrared | FaultKind::Gap => {}
            }
        }
        let parts = if split { in_parts(&payload) } else { vec![payload] };
        std::iter::repeat_n(parts, copies).flatten().collect()
    }
}

impl<S: Source> Source for FaultInjector<S> {
    fn expose(&mut self, shot: &Shot<'_>) -> Vec<Payload> {
        let fresh = self.inner.expose(shot);
        if self.draw(true).contains(&FaultKind::Gap) {
            self.skipped += self.random.random_range(1..=5);
        }
        let now_us = fresh.iter().map(|payload| payload.arrival_us).max().unwrap_or(shot.captured_us);
        for mut payload in fresh {
            shift_counter(&mut payload.bytes, self.skipped);
            let damaged = self.damage(payload);
            self.held.extend(damaged);
        }
        self.shot += 1;
        let (mut due, held): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.held).into_iter().partition(|payload| payload.arrival_us <= now_us);
        self.held = held;
        due.sort_by_key(|payload| payload.arrival_us);
        due
    }
}

/// Changes one byte, if an earlier fault has left it there.
fn change(payload: &mut Payload, at: usize, how: impl Fn(u8) -> u8) {
    if let Some(byte) = payload.bytes.get_mut(at) {
        *byte = how(*byte);
    }
}

/// Adds `skipped` to the frame counter.
fn shift_counter(bytes: &mut [u8], skipped: u32) {
    if let Some(Some(field)) = bytes.get_mut(COUNTER_AT..).map(<[u8]>::first_chunk_mut) {
        *field = u32::from_le_bytes(*field).wrapping_add(skipped).to_le_bytes();
    }
}

/// The same frame in several payloads, the last one with the end-of-frame bit of the original.
fn in_parts(payload: &Payload) -> Vec<Payload> {
    let Some((header, pixels)) = payload.bytes.split_at_checked(HEADER_LENGTH) else {
        return vec![payload.clone()];
    };
    let chunks = pixels.chunks(pixels.len().div_ceil(PARTS).max(1));
    let last = chunks.len().saturating_sub(1);
    chunks
        .enumerate()
        .map(|(index, chunk)| {
            let mut bytes = [header, chunk].concat();
            if index < last {
                bytes[FLAGS_AT] &= !EOF;
            }
            Payload { bytes, ..payload.clone() }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, CameraSettings};

    fn run(faults: &str, seed: u64, shots: u64) -> Vec<Payload> {
        let settings = CameraSettings { width: 8, height: 4, ..CameraSettings::default() };
        let mut source = FaultInjector::new(Camera::new(settings), faults.parse().unwrap(), seed);
        let (depth, infrared) = ([1; 64], [2; 32]);
        let shot = |shot| Shot::infrared(&depth, &infrared, shot * 16_667);
        (0..shots).flat_map(|index| source.expose(&shot(index))).collect()
    }

    #[test]
    fn the_same_seed_gives_the_same_faults() {
        let faults = "drop:0.2,tear:0.2,late:0.1,gap:0.1";
        assert_eq!(run(faults, 1, 50), run(faults, 1, 50));
        assert_ne!(run(faults, 1, 50), run(faults, 2, 50));
    }

    #[test]
    fn a_late_payload_comes_with_a_later_shot_in_the_order_of_arrival() {
        let payloads = run("late@1", 1, 6);
        assert_eq!(payloads.len(), 12);
        assert!(payloads.is_sorted_by_key(|payload| payload.arrival_us));
        let counters: Vec<u8> = payloads.iter().step_by(2).map(|payload| payload.bytes[COUNTER_AT]).collect();
        assert_eq!(counters, [1, 3, 4, 2, 5, 6]);
    }

    #[test]
    fn a_share_strikes_about_as_often_as_it_says() {
        let kept = run("drop:0.25", 3, 1000).len();
        assert!((1400..1600).contains(&kept), "{kept} of 2000");
    }
}
