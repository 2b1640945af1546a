//! Comparison of simulated with measured channels: weighted by the noise, nuisances of each recording projected out.
//!
//! ```text
//! y = s(p) + N n + e      e ~ N(0, sigma^2)      n ~ N(0, prior)
//! columns of N: an offset of each channel, ds/dt (lag of the clock), a share of the control variate
//! ```
//! With `A = [N/sigma; 1/prior]` and `A = QR`, the vector `(1 - Q Q^T) [v/sigma; 0]` has the squared norm that is left of a
//! series v when the nuisances are fitted. All further algebra is on such vectors.

use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Values by channel and frame, m.
pub type Series = Vec<Vec<f64>>;

/// Standard deviation of the share by which the control variate may be wrong: the simulator's error in the reference liquid
/// is not exactly that in the liquid in question.
const CONTROL_SHARE: f64 = 0.3;

/// Measured channel.
#[derive(Clone, Debug)]
pub struct ObservedChannel {
    /// Values, m; none where it was not measured.
    pub value: Vec<Option<f64>>,
    /// Standard deviation of the noise, m.
    pub sigma_m: f64,
    /// Standard deviation of a constant offset, m.
    pub offset_m: f64,
}

/// Measured recording.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Name, for people.
    pub name: String,
    /// Seconds between frames.
    pub interval_s: f64,
    /// Standard deviation of the lag of its clock, s.
    pub lag_s: f64,
    /// Channels.
    pub channels: Vec<ObservedChannel>,
}

/// Map from the channels of one recording to weighted numbers without nuisances.
#[derive(Clone, Debug)]
pub struct Projection {
    /// Channel and frame of each number that was measured.
    index: Vec<(usize, usize)>,
    weight: Vec<f64>,
    q: DMatrix<f64>,
    measured: Vec<f64>,
}

impl Projection {
    /// Returns the map for `observed`, with the lag's derivative taken from the simulated `like` and the share of `control`.
    #[must_use]
    pub fn new(observed: &Observed, like: &Series, control: Option<&Series>) -> Self {
        let mut index = Vec::new();
        let mut weight = Vec::new();
        let mut measured = Vec::new();
        for (c, channel) in observed.channels.iter().enumerate() {
            for (f, value) in channel.value.iter().enumerate() {
                if let Some(value) = value {
                    index.push((c, f));
                    weight.push(1.0 / channel.sigma_m);
                    measured.push(*value);
                }
            }
        }
        let mut columns: Vec<(Vec<f64>, f64)> = Vec::new();
        for (c, channel) in observed.channels.iter().enumerate() {
            let column = index.iter().map(|(of, _)| f64::from(u8::from(*of == c))).collect();
            columns.push((column, channel.offset_m));
        }
        let slope = |(c, f): &(usize, usize)| {
            let series = &like[*c];
            let (before, after) = (f.saturating_sub(1), (f + 1).min(series.len() - 1));
            (series[after] - series[before]) / ((after - before).max(1) as f64 * observed.interval_s)
        };
        columns.push((index.iter().map(slope).collect(), observed.lag_s));
        if let Some(control) = control {
            columns.push((index.iter().map(|(c, f)| control[*c][*f]).collect(), CONTROL_SHARE));
        }
        // A nuisance that is known exactly has no column.
        columns.retain(|(_, deviation)| *deviation > 0.0);
        let rows = index.len() + columns.len();
        let mut a = DMatrix::zeros(rows, columns.len());
        for (j, (column, deviation)) in columns.iter().enumerate() {
            for (i, value) in column.iter().enumerate() {
                a[(i, j)] = value * weight[i];
            }
            a[(index.len() + j, j)] = 1.0 / deviation;
        }
        Self { index, weight, q: a.qr().q(), measured }
    }

    /// Returns the numbers of a recording, those of the nuisances' priors included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.q.nrows()
    }

    /// Returns whether nothing was measured.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Returns how many numbers were measured.
    #[must_use]
    pub fn measured(&self) -> usize {
        self.index.len()
    }

    /// Returns the measured channels.
    #[must_use]
    pub fn data(&self) -> DVector<f64> {
        self.project(self.measured.iter().copied())
    }

    /// Returns a simulated `series`.
    #[must_use]
    pub fn reduce(&self, series: &Series) -> DVector<f64> {
        self.project(self.index.iter().map(|(c, f)| series[*c][*f]))
    }

    fn project(&self, values: impl Iterator<Item = f64>) -> DVector<f64> {
        let mut v = DVector::zeros(self.len());
        for ((slot, value), weight) in v.iter_mut().zip(values).zip(&self.weight) {
            *slot = value * weight;
        }
        let inside = &self.q * self.q.tr_mul(&v);
        v - inside
    }

    /// Returns the numbers of each channel, as ranges that count from `first`.
    pub fn channels(&self, first: usize) -> impl Iterator<Item = Range<usize>> + '_ {
        let mut begin = 0;
        std::iter::from_fn(move || {
            let (channel, _) = self.index.get(begin)?;
            let end = begin + self.index[begin..].iter().take_while(|(c, _)| c == channel).count();
            let range = first + begin..first + end;
            begin = end;
            Some(range)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_and_lags_within_their_priors_vanish_and_others_stay() {
        let wave = |f: usize| (0.4 * f as f64).sin() * 1e-3;
        let series: Series = vec![(0..200).map(wave).collect()];
        let observed = |shift: f64, offset: f64| Observed {
            name: "a".into(),
            interval_s: 1.0 / 60.0,
            lag_s: 0.01,
            channels: vec![ObservedChannel {
                value: (0..200)
                    .map(|f| Some((0.4 * (f as f64 - 60.0 * shift)).sin() * 1e-3 + offset))
                    .collect(),
                sigma_m: 1e-5,
                offset_m: 1e-3,
            }],
        };
        let left = |observed: &Observed| {
            let projection = Projection::new(observed, &series, None);
            (projection.data() - projection.reduce(&series)).norm_squared() / 200.0
        };
        // Unprojected, the offset alone would leave 1e4 for each number and the lag 29.
        assert!(left(&observed(0.0, 1e-3)) < 0.02, "{}", left(&observed(0.0, 1e-3)));
        assert!(left(&observed(0.0003, 0.0)) < 0.02, "{}", left(&observed(0.0003, 0.0)));
        // A tenth more of amplitude is none of them.
        let mut louder = observed(0.0, 0.0);
        louder.channels[0].value.iter_mut().flatten().for_each(|z| *z *= 1.1);
        assert!(left(&louder) > 40.0, "{}", left(&louder));
    }
}
