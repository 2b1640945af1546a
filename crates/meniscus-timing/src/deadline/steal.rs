//! Time that the host of a virtual machine gave to somebody else, as the kernel tells it, ten times a second.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Pause between two readings.
const PAUSE: Duration = Duration::from_millis(100);

/// Readings: when, time stolen, time altogether, of all processors, in ticks of 10 ms.
#[derive(Clone, Debug, Default)]
pub struct Steal {
    readings: Vec<(Instant, u64, u64)>,
}

impl Steal {
    /// Reads until `ended`.
    pub fn watch(ended: &AtomicBool) -> Self {
        let mut readings = Vec::with_capacity(1 << 15);
        while !ended.load(Ordering::Relaxed) {
            if let Some((stolen, all)) = std::fs::read_to_string("/proc/stat").ok().as_deref().and_then(ticks)
            {
                readings.push((Instant::now(), stolen, all));
            }
            std::thread::sleep(PAUSE);
        }
        Self { readings }
    }

    /// Share of the processors' time; `None` where the kernel does not tell.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        let ((_, first, from), (_, last, to)) = (self.readings.first()?, self.readings.last()?);
        (to > from).then(|| (last - first) as f64 / (to - from) as f64)
    }

    /// Milliseconds stolen from all processors in the readings around `from` to `to`.
    #[must_use]
    pub fn around_ms(&self, from: Instant, to: Instant) -> f64 {
        let before = self.readings.iter().rev().find(|reading| reading.0 <= from).or(self.readings.first());
        let after = self.readings.iter().find(|reading| reading.0 >= to).or(self.readings.last());
        before.zip(after).map_or(0.0, |(before, after)| 10.0 * after.1.saturating_sub(before.1) as f64)
    }
}

/// Ticks stolen and altogether, from the first line of `/proc/stat` (proc(5): user nice system idle iowait irq softirq
/// steal).
fn ticks(stat: &str) -> Option<(u64, u64)> {
    let numbers = stat.lines().next()?.strip_prefix("cpu ")?;
    let numbers: Vec<u64> = numbers.split_whitespace().take(8).filter_map(|word| word.parse().ok()).collect();
    let stolen = *numbers.get(7)?;
    Some((stolen, numbers.iter().sum()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kernels_line_is_understood() {
        assert_eq!(ticks("cpu  10 1 5 80 2 0 1 7 0 0\ncpu0 1 2"), Some((7, 106)));
        assert_eq!(ticks("cpu  10 1 5 80\n"), None);
        assert_eq!(ticks("intr 5"), None);
    }

    #[test]
    fn what_was_stolen_is_that_of_the_readings_around() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let readings = vec![(at(0), 5, 100), (at(100), 5, 120), (at(200), 9, 140), (at(300), 9, 160)];
        let steal = Steal { readings };
        assert_eq!(steal.around_ms(at(120), at(180)), 40.0);
        assert_eq!(steal.around_ms(at(220), at(280)), 0.0);
        assert_eq!(steal.around_ms(at(10), at(1000)), 40.0);
        assert!((steal.share().expect("a share") - 4.0 / 60.0).abs() < 1e-12);
        assert_eq!(Steal::default().share(), None);
    }
}
