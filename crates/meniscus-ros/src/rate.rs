//! Thinning of a stream that comes 60 times a second.

/// Half a frame interval, us: a turn that is this early is the one that is due.
const EARLY_US: f64 = 8_333.0;

/// Instants at which something is due, on the camera's clock.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rate {
    next_us: f64,
}

impl Rate {
    /// Returns whether something is due at `now_us`, `rate_hz` times a second; never at a rate of 0.
    pub(crate) fn due(&mut self, now_us: u64, rate_hz: f64) -> bool {
        if rate_hz <= 0.0 {
            return false;
        }
        let (now, period) = (now_us as f64, 1e6 / rate_hz);
        // A clock that began anew, or a rate that has grown, leaves the next instant too far ahead.
        self.next_us = self.next_us.min(now + period);
        if now + EARLY_US < self.next_us {
            return false;
        }
        // Behind a gap nothing is made up for.
        self.next_us = (self.next_us + period).max(now + period - EARLY_US);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(turns: impl Iterator<Item = u64>, rate_hz: f64) -> usize {
        let mut rate = Rate::default();
        turns.filter(|turn| rate.due(turn * 50_000 / 3, rate_hz)).count()
    }

    #[test]
    fn rates_are_those_that_are_set() {
        for (rate_hz, due) in [(60.0, 600), (30.0, 300), (10.0, 100), (7.0, 70), (0.0, 0)] {
            let is = count(1000..1600, rate_hz);
            assert!(is.abs_diff(due) <= 1, "{rate_hz}: {is}");
        }
        assert_eq!(count((0..300).chain(600..900), 60.0), 600, "a gap of five seconds");
        assert_eq!(count((100_000..100_300).chain(0..300), 60.0), 599, "a clock that begins anew costs one");
    }
}
