//! Every turn of a run in histograms, every miss with what it was and what it led to.

use super::pace::{Film, Handed};
use super::steal::Steal;
use hdrhistogram::Histogram;
use meniscus::runtime::Stages;
use meniscus_service::live::Log;
use meniscus_service::timed_turn::TimedTurn;

/// Longest time that the histogram distinguishes, microseconds: a minute.
const LONGEST_US: u64 = 60_000_000;

/// Time after a miss in which lost frames are counted to it, s.
const AFTER_S: f64 = 0.5;

/// The name of a stage, and its time, microseconds.
type Stage = (&'static str, fn(&Stages) -> u64);

/// The stages of a turn.
const STAGES: [Stage; 5] = [
    ("surface", |s| s.surface_us),
    ("predict", |s| s.predict_us),
    ("encode", |s| s.encode_us),
    ("correct", |s| s.correct_us),
    ("field", |s| s.field_us),
];

/// A turn that ended after the next frame was due.
#[derive(Clone, Debug, PartialEq)]
pub struct Miss {
    /// Since the first frame, s.
    pub at_s: f64,
    /// From when the frame's last payload was due to the end of its turn, microseconds.
    pub latency_us: u64,
    /// Of that: until the payload was handed over.
    pub late_us: u64,
    /// Of that: from there until the worker had begun.
    pub waited_us: u64,
    /// Of that: the turn.
    pub ran_us: u64,
    /// The longest stage of the turn, with its time.
    pub longest: (&'static str, u64),
    /// Whether the full field was written.
    pub field_fresh: bool,
    /// Frames of the half second behind it that never had a turn.
    pub lost_after: usize,
    /// Processor time that the host took meanwhile, ms.
    pub stolen_ms: f64,
}

/// The books of a run.
#[derive(Clone, Debug)]
pub struct Tally {
    /// From when a frame's last payload was due to the end of its turn, microseconds.
    pub latency_us: Histogram<u64>,
    /// The turn alone, from the payload in hand to its end.
    pub turn_us: Histogram<u64>,
    /// Frames that were sent, the first seconds left out.
    pub frames: usize,
    /// Of these: without a turn of their own.
    pub lost: usize,
    /// Turns without the full field.
    pub shed: usize,
    /// Allocations of all turns.
    pub allocations: u64,
    /// Turns that were late.
    pub misses: Vec<Miss>,
}

impl Tally {
    /// The books of `shots` and the `log` of their turns, but for the first `settled` frames.
    ///
    /// # Panics
    /// Never: a histogram from 1 us to a minute with three digits can be had.
    #[must_use]
    pub fn new(shots: &[Handed], log: &Log, settled: usize, deadline_us: u64, steal: &Steal) -> Self {
        let histogram = || Histogram::new_with_bounds(1, LONGEST_US, 3).expect("bounds that are in order");
        let mut turns: Vec<Option<&TimedTurn>> = vec![None; shots.len()];
        for logged in &log.turns {
            let Some(stamp) = logged.turn.stamp else { continue };
            if let Some(slot) = turns.get_mut(Film::frame_at(stamp.captured.0)) {
                *slot = Some(logged);
            }
        }
        let mut tally = Self {
            latency_us: histogram(),
            turn_us: histogram(),
            frames: shots.len().saturating_sub(settled),
            lost: 0,
            shed: 0,
            allocations: 0,
            misses: Vec::new(),
        };
        let Some(first) = shots.first() else { return tally };
        let interval_s = 1e-6 * deadline_us as f64;
        let after = (AFTER_S / interval_s).round() as usize;
        for (frame, (shot, turn)) in shots.iter().zip(&turns).enumerate().skip(settled) {
            let Some(logged) = turn else {
                tally.lost += 1;
                continue;
            };
            let latency_us = micros(logged.ended - shot.due);
            tally.latency_us.saturating_record(latency_us.max(1));
            tally.turn_us.saturating_record(logged.turn_us.max(1));
            tally.shed += usize::from(!logged.turn.estimate.field_fresh);
            tally.allocations += logged.allocations;
            if latency_us > deadline_us {
                let late_us = micros(shot.sent - shot.due);
                let stages = &logged.turn.estimate.stages;
                let longest = STAGES.map(|(name, stage)| (name, stage(stages)));
                let behind = turns.get(frame + 1..).unwrap_or_default();
                tally.misses.push(Miss {
                    at_s: (shot.due - first.due).as_secs_f64(),
                    latency_us,
                    late_us,
                    waited_us: latency_us.saturating_sub(late_us).saturating_sub(logged.turn_us),
                    ran_us: logged.turn_us,
                    longest: longest.into_iter().max_by_key(|(_, us)| *us).unwrap_or_default(),
                    field_fresh: logged.turn.estimate.field_fresh,
                    lost_after: behind.iter().take(after).filter(|turn| turn.is_none()).count(),
                    stolen_ms: steal.around_ms(shot.due, logged.ended),
                });
            }
        }
        tally
    }

    /// Frames that had no turn in time: late ones and those without any.
    #[must_use]
    pub fn missed(&self) -> usize {
        self.misses.len() + self.lost
    }

    /// Latency that a share of the turns stayed within, microseconds; NaN of no turns.
    #[must_use]
    pub fn within_us(&self, share: f64) -> f64 {
        if self.latency_us.is_empty() { f64::NAN } else { self.latency_us.value_at_quantile(share) as f64 }
    }
}

fn micros(time: std::time::Duration) -> u64 {
    u64::try_from(time.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::blob::Model;
    use meniscus::runtime::{Estimator, Memory, Turn, TurnInput};
    use meniscus::units::Micros;
    use meniscus::usb::frame::Stamp;
    use std::time::{Duration, Instant};

    /// A turn that was handed over 100 us after it was due and took 400 us, but for the given delay.
    fn logged(shot: &Handed, frame: usize, delay_us: u64) -> TimedTurn {
        let bytes = meniscus_platform::files::AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let mut clock = meniscus_platform::clock::Monotonic::start();
        let estimate =
            Estimator::new(&model).turn(&mut Memory::default(), TurnInput::default(), &mut clock, &mut []);
        let captured = Micros(Film::captured_us(frame));
        let stamp = Some(Stamp { sequence: frame as u32, captured });
        let turn = Turn { time: captured, stamp, profile: None, estimate };
        TimedTurn {
            ended: shot.sent + Duration::from_micros(400 + delay_us),
            latency_us: 400 + delay_us,
            turn_us: 400,
            ..TimedTurn::untimed(turn)
        }
    }

    #[test]
    fn late_and_lost_frames_are_distinguished() {
        let begun = Instant::now();
        let shots: Vec<Handed> = (0..20)
            .map(|frame| {
                let due = begun + Duration::from_micros(16_667 * frame);
                Handed { due, sent: due + Duration::from_micros(100) }
            })
            .collect();
        let mut log = Log::with_room(20);
        // Frame 7 waits 20 ms for a processor, 8 and 9 are lost of it; the first five are not counted.
        for frame in (0..20).filter(|frame| ![2, 8, 9].contains(frame)) {
            log.turns.push(logged(&shots[frame], frame, if frame == 7 { 20_000 } else { 0 }));
        }
        let tally = Tally::new(&shots, &log, 5, 16_667, &Steal::default());
        assert_eq!((tally.frames, tally.lost, tally.missed()), (15, 2, 3));
        assert_eq!(tally.latency_us.len(), 13);
        assert!((tally.within_us(0.5) - 500.0).abs() < 1.0);
        assert_eq!(tally.misses.len(), 1);
        let miss = &tally.misses[0];
        assert_eq!((miss.late_us, miss.waited_us, miss.ran_us, miss.lost_after), (100, 20_000, 400, 2));
        assert!((miss.at_s - 7.0 / 60.0).abs() < 1e-4);
        assert!(Tally::new(&[], &log, 5, 16_667, &Steal::default()).within_us(0.5).is_nan());
    }
}
