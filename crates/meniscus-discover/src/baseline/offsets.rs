//! Nuisance offsets of level, slope, bow and position, and their variances.
//!
//! The fill is poured, the glass is put down and the camera is put up once for all recordings of a glass, so an
//! offset belongs to the glass. With variance b of the glasses and w of the recordings of one glass, R
//! recordings that are weighed one by one have to be given
//! ```text
//! R b + w         each, so that their mean has the variance b + w/R that it truly has
//! b = (1 + 1/G) sum (m_g - m)^2/(G - 1),     m_g mean over the rest frames of glass g
//! ```
//! (one-way analysis of variance). References that were made with more care than the glass that is judged show
//! too little: a fill is stated to a quarter of a millimetre, and a table is level to three thousandths.

use super::group::Group;
use crate::recordings::record::{Channel, Quantity, Record};
use std::collections::BTreeMap;

/// Returns the standard deviations of glasses and of the recordings of one glass without references, m.
fn unseen_m(quantity: Quantity) -> [f64; 2] {
    match quantity {
        Quantity::Level => [LEAST_LEVEL_M, 2e-4],
        Quantity::Slope => [LEAST_SLOPE_M, 1e-4],
        Quantity::Bow => [1e-4, 5e-5],
        Quantity::Place => [0.0, 3e-4],
        Quantity::Peak => [0.0, 5e-4],
    }
}

/// Smallest standard deviation of a stated fill, m.
const LEAST_LEVEL_M: f64 = 2.5e-4;

/// Smallest standard deviation of the slope: the lean of a glass of 35 mm radius on a table, m at the wall.
const LEAST_SLOPE_M: f64 = 1e-4;

/// Smallest standard deviation of any other offset, m.
const LEAST_M: f64 = 2e-5;

/// Variances of offsets learnt from references: of glasses, and of the recordings of one glass, m2.
#[derive(Clone, Debug, Default)]
pub struct Offsets(BTreeMap<Quantity, [f64; 2]>);

impl Offsets {
    /// Returns the variances that the rest frames of `groups` show; none where there are fewer than three groups.
    #[must_use]
    pub fn of(groups: &[&Group]) -> Self {
        let mut out = BTreeMap::new();
        if groups.len() < 3 {
            return Self(out);
        }
        for quantity in [Quantity::Level, Quantity::Slope, Quantity::Bow] {
            let rests: Vec<Vec<f64>> = groups
                .iter()
                .map(|group| group.records.iter().filter_map(|r| rest_m(r, quantity)).collect())
                .filter(|rests: &Vec<f64>| !rests.is_empty())
                .collect();
            let count = rests.len() as f64;
            if rests.len() < 3 {
                continue;
            }
            let means: Vec<f64> = rests.iter().map(|r| r.iter().sum::<f64>() / r.len() as f64).collect();
            let mean = means.iter().sum::<f64>() / count;
            let glasses =
                (1.0 + 1.0 / count) * means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
            let within: f64 =
                rests.iter().zip(&means).flat_map(|(r, m)| r.iter().map(move |x| (x - m).powi(2))).sum();
            let free = rests.iter().map(|r| r.len() as f64 - 1.0).sum::<f64>();
            let least = match quantity {
                Quantity::Level => LEAST_LEVEL_M,
                Quantity::Slope => LEAST_SLOPE_M,
                _ => LEAST_M,
            };
            let recordings = if free > 0.0 { within / free } else { unseen_m(quantity)[1].powi(2) };
            out.insert(quantity, [glasses.max(least * least), recordings.max(LEAST_M * LEAST_M)]);
        }
        Self(out)
    }

    /// Variance that each of `recordings` of one glass is given, m2.
    #[must_use]
    pub fn variance_m2(&self, quantity: Quantity, recordings: usize) -> f64 {
        let unseen = || unseen_m(quantity).map(|m| m * m);
        let [glasses, single] = self.0.get(&quantity).copied().unwrap_or_else(unseen);
        recordings as f64 * glasses + single
    }
}

/// Returns the mean of a channel over the frames before the glass moves, m.
fn rest_m(record: &Record, quantity: Quantity) -> Option<f64> {
    let of = |channel: &&Channel| channel.quantity == quantity;
    let channel = record.channels.iter().find(of)?;
    let seen: Vec<f64> = channel.value.iter().take(record.rest_frames).flatten().copied().collect();
    (!seen.is_empty()).then(|| seen.iter().sum::<f64>() / seen.len() as f64)
}
