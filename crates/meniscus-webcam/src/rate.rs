//! Rate of a stream by the times of its frames.

use std::collections::VecDeque;

/// Intervals that are looked at: a second or two.
const INTERVALS: usize = 45;
/// Share of the agreed rate below which it is called fallen.
const FALLEN: f64 = 0.75;

/// Times of the last frames.
#[derive(Debug, Default)]
pub(crate) struct Rate {
    times_us: VecDeque<u64>,
    said: bool,
}

impl Rate {
    /// Takes the time of a frame; the rate in hertz when it has fallen below the agreed one, once.
    pub(crate) fn fallen(&mut self, captured_us: u64, agreed_hz: f64) -> Option<f64> {
        self.times_us.push_back(captured_us);
        if self.times_us.len() <= INTERVALS {
            return None;
        }
        let first = self.times_us.pop_front()?;
        let hz = INTERVALS as f64 / (captured_us.saturating_sub(first).max(1) as f64 * 1e-6);
        let fallen = hz < FALLEN * agreed_hz;
        let news = fallen && !self.said;
        self.said = fallen;
        news.then_some(hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_that_falls_is_said_once_and_again_after_it_was_whole() {
        let (mut rate, mut time, mut said) = (Rate::default(), 0, Vec::new());
        for (frames, interval_us) in [(90, 33_333), (200, 66_667), (200, 33_333), (100, 66_667)] {
            for _ in 0..frames {
                time += interval_us;
                said.extend(rate.fallen(time, 30.0));
            }
        }
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said.iter().all(|hz| (20.0..22.5).contains(hz)), "{said:?}");
    }
}
