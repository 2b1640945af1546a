//! A number that depends on the amplitude of a speed: a table over logarithms, straight lines between.

use crate::math::{exp, ln};

/// Speeds of the table, and its ends, m/s.
const SPEEDS: usize = 24;
pub(super) const SLOWEST_M_S: f64 = 1e-4;
const FASTEST_M_S: f64 = 3.0;

/// The table. Below its slowest speed and above its fastest it is constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpeedTable {
    values: [f64; SPEEDS],
    /// Whether all of them are the same.
    constant: bool,
}

impl SpeedTable {
    /// `of` at every speed of the table (m/s).
    #[must_use]
    pub(crate) fn new(of: impl Fn(f64) -> f64) -> Self {
        let step = ln(FASTEST_M_S / SLOWEST_M_S) / (SPEEDS - 1) as f64;
        let values = core::array::from_fn(|i| of(SLOWEST_M_S * exp(step * i as f64)));
        Self { values, constant: false }
    }

    /// The same number at every speed.
    #[must_use]
    pub(crate) fn constant(value: f64) -> Self {
        Self { values: [value; SPEEDS], constant: true }
    }

    /// The number at `speed` (m/s).
    #[must_use]
    pub(crate) fn at(&self, speed: f64) -> f64 {
        let last = self.values.last().copied().unwrap_or(0.0);
        if self.constant {
            return last;
        }
        let span = ln(FASTEST_M_S / SLOWEST_M_S);
        let place = (ln(speed.max(SLOWEST_M_S) / SLOWEST_M_S) / span * (SPEEDS - 1) as f64).max(0.0);
        let low = (place as usize).min(SPEEDS - 2);
        let pair = self.values.get(low).zip(self.values.get(low + 1));
        pair.map_or(last, |(a, b)| a + (b - a) * (place - low as f64).min(1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_its_speeds_it_follows_a_power_and_beyond_them_it_stays() {
        let table = SpeedTable::new(|v| libm::pow(v, -1.0 / 3.0));
        for speed in [2e-4, 0.013, 0.4, 2.9] {
            let wanted = libm::pow(speed, -1.0 / 3.0);
            assert!((table.at(speed) / wanted - 1.0).abs() < 0.006, "{speed}: {}", table.at(speed));
        }
        assert_eq!(table.at(0.0), table.at(SLOWEST_M_S));
        assert_eq!(table.at(9.0), table.at(FASTEST_M_S));
        assert_eq!(SpeedTable::constant(2.5).at(0.3), 2.5);
    }
}
