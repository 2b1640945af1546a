//! Reference first: what the reduced model is off by in recordings of a liquid that is known.

use super::fit::fit;
use super::noise::{Noise, rest_noise};
use super::offsets::Offsets;
use super::predict::{Known, SHARED, predict};
use super::problem::Problem;
use super::record::{Quantity, Record};
use super::split::Split;
use crate::fit_cache::Kept;
use crate::reference_residual::Left;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Recordings of one known liquid in one glass, and what the baseline leaves of them.
#[derive(Clone, Debug)]
pub struct Group {
    /// What is known.
    pub known: Known,
    /// The recordings.
    pub records: Vec<Record>,
    /// The same as they are split when another group judges this one.
    pub split: Split,
    /// The baseline's numbers and lags that fit them best.
    theta: Vec<f64>,
    /// What these leave, by recording, channel and frame, m.
    left: Vec<Vec<Vec<f64>>>,
}

impl Group {
    /// Fits the baseline alone to `records`; with `lagging`, each has a clock of its own of this deviation.
    ///
    /// # Errors
    /// In words, when they cannot be fitted.
    pub fn new(known: Known, records: Vec<Record>, lagging: Option<f64>) -> Result<Self, String> {
        Self::keeping(known, records, lagging, &None)
    }

    /// The same with the fit in `kept`.
    ///
    /// # Errors
    /// In words, when they cannot be fitted.
    pub fn keeping(
        known: Known,
        records: Vec<Record>,
        lagging: Option<f64>,
        kept: &Option<Arc<Kept>>,
    ) -> Result<Self, String> {
        let blind = Calibration::blind(&records, lagging.unwrap_or(LAG_S));
        let problem = Problem::new(&records, known, &blind, 1.0)?.keeping(kept);
        let theta = fit(&problem, &problem.mean, &[], &[]).theta;
        let one = |(which, record): (usize, &Record)| {
            residuals(record, &predict(record, &known, &theta, theta[SHARED + which], &[]))
        };
        let left = records.iter().enumerate().map(one).collect();
        let split = Split::of(&records);
        Ok(Self { known, records, split, theta, left })
    }
}

/// What the references teach.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// Mean of the baseline's numbers.
    pub mean: [f64; SHARED],
    /// Their standard deviations.
    pub deviation: [f64; SHARED],
    /// Mean lag, s.
    pub lag_s: f64,
    /// Its standard deviation, s.
    pub lag_deviation_s: f64,
    /// Groups that it was learnt from.
    pub groups: usize,
    noise: BTreeMap<Quantity, Noise>,
    misfit: BTreeMap<Quantity, f64>,
    offsets: Offsets,
    left: Vec<Left>,
}

/// The prior of the baseline before any reference: linear theory, wide.
const MEAN: [f64; SHARED] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.5, -0.5, 0.5, -0.5];
const DEVIATION: [f64; SHARED] = [0.03, 0.1, 0.4, 0.6, 0.1, 0.4, 0.4, 1.0, 1.0, 1.0, 1.0];

/// Least deviations after calibration.
const FLOOR: [f64; SHARED] = [0.0015, 0.008, 0.012, 0.05, 0.004, 0.03, 0.03, 0.05, 0.05, 0.05, 0.05];

/// What a lag may be before references say, s, and the least deviation after, s.
const LAG_S: f64 = 0.004;
const LAG_FLOOR_S: f64 = 3e-4;

impl Calibration {
    /// What is believed without references: linear theory, wide, and a misfit of 5 % of the signal.
    #[must_use]
    pub fn blind(records: &[Record], lag_deviation_s: f64) -> Self {
        let mut misfit = BTreeMap::new();
        for quantity in [Quantity::Level, Quantity::Slope, Quantity::Bow, Quantity::Place, Quantity::Peak] {
            let signal = rms(records.iter().flat_map(|record| moving(record, quantity)));
            misfit.insert(quantity, if quantity == Quantity::Place { 1e-5 } else { 0.05 * signal.max(1e-5) });
        }
        Self {
            mean: MEAN,
            deviation: DEVIATION,
            lag_s: 0.0,
            lag_deviation_s,
            groups: 0,
            noise: rest_noise(records),
            misfit,
            offsets: Offsets::default(),
            left: Vec::new(),
        }
    }

    /// What `groups` teach for recordings whose rest shows the noise of `records`. With `lagging`, every
    /// recording has a clock of its own and nothing is learnt about the lag.
    #[must_use]
    pub fn from(groups: &[&Group], records: &[Record], lagging: Option<f64>) -> Self {
        let mut out = Self::blind(records, lagging.unwrap_or(LAG_S));
        if groups.is_empty() {
            return out;
        }
        let mut thetas = Vec::new();
        let mut lags = Vec::new();
        let mut lefts: Vec<Left> = Vec::new();
        let mut squares: BTreeMap<Quantity, (f64, f64)> = BTreeMap::new();
        for group in groups {
            lags.extend_from_slice(&group.theta[SHARED..]);
            for (record, left) in group.records.iter().zip(&group.left) {
                let left = left.clone();
                for (channel, left) in record.channels.iter().zip(&left) {
                    let sum = squares.entry(channel.quantity).or_default();
                    sum.0 += left.iter().map(|r| r * r).sum::<f64>();
                    sum.1 += left.len() as f64;
                }
                match lefts.iter_mut().find(|l| l.like.drive.same(&record.drive)) {
                    Some(known) => known.scatter.push(left),
                    None => lefts.push(Left { like: record.clone(), mean: Vec::new(), scatter: vec![left] }),
                }
            }
            thetas.push(group.theta[..SHARED].to_vec());
        }
        let groups_n = thetas.len() as f64;
        for i in 0..SHARED {
            let mean = thetas.iter().map(|t| t[i]).sum::<f64>() / groups_n;
            let spread =
                thetas.iter().map(|t| (t[i] - mean).powi(2)).sum::<f64>() / (groups_n - 1.0).max(1.0);
            let few = if thetas.len() < 2 { 0.25 * DEVIATION[i] } else { 0.0 };
            out.mean[i] = mean;
            out.deviation[i] =
                ((1.0 + 1.0 / groups_n) * spread + FLOOR[i].powi(2) + few * few).sqrt().min(DEVIATION[i]);
        }
        if lagging.is_none() {
            let mean = lags.iter().sum::<f64>() / lags.len() as f64;
            let spread =
                lags.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (lags.len() as f64 - 1.0).max(1.0);
            (out.lag_s, out.lag_deviation_s) = (mean, (spread + LAG_FLOOR_S * LAG_FLOOR_S).sqrt().min(LAG_S));
        }
        for (quantity, (sum, count)) in squares {
            out.misfit.insert(quantity, (sum / count.max(1.0)).sqrt());
        }
        out.offsets = Offsets::of(groups);
        out.left = lefts.into_iter().map(Left::centred).collect();
        out.see_noise_in_motion();
        out.left.iter_mut().for_each(Left::smooth);
        out.groups = thetas.len();
        out
    }

    /// What the references leave in the motion of `record`, where two or more went through it: in the motion
    /// that the glass was seen to make, where it was seen, otherwise in the stated one.
    #[must_use]
    pub fn matched(&self, record: &Record) -> Option<Left> {
        let kinds = |r: &Record| r.channels.iter().map(|c| c.quantity).collect::<Vec<_>>();
        let alike = |left: &&Left| left.scatter.len() > 1 && kinds(&left.like) == kinds(record);
        let seen = self.left.iter().filter(alike).filter_map(|left| Some((left, left.seen_in(record)?)));
        let nearest = seen.min_by(|(_, a), (_, b)| a.scale.ln().abs().total_cmp(&b.scale.ln().abs()));
        if let Some((left, way)) = nearest {
            return Some(left.moved(way));
        }
        self.left.iter().filter(alike).find(|left| left.like.drive.same(&record.drive)).cloned()
    }

    /// Noise of a channel.
    #[must_use]
    pub fn noise_of(&self, quantity: Quantity) -> Noise {
        self.noise.get(&quantity).copied().unwrap_or(Noise { sigma_m: 2e-4, memory: 0.3 })
    }

    /// What the model leaves in a motion that no reference went through, m.
    #[must_use]
    pub fn misfit_m(&self, quantity: Quantity) -> f64 {
        self.misfit.get(&quantity).copied().unwrap_or(5e-4)
    }

    /// Variance of the offset of a channel in one of `recordings` of a glass, m2.
    #[must_use]
    pub fn offset_m2(&self, quantity: Quantity, recordings: usize) -> f64 {
        self.offsets.variance_m2(quantity, recordings)
    }

    /// Raises the noise to what second differences of the references' scatter show while the liquid
    /// moves: `var(x_-1 - 2 x_0 + x_1) = 6 sigma^2` of white noise.
    fn see_noise_in_motion(&mut self) {
        let mut seen: BTreeMap<Quantity, (f64, f64)> = BTreeMap::new();
        for left in self.left.iter().filter(|left| left.scatter.len() > 1) {
            let lost = 1.0 - 1.0 / left.scatter.len() as f64;
            for scatter in &left.scatter {
                for (channel, series) in left.like.channels.iter().zip(scatter) {
                    let sum = seen.entry(channel.quantity).or_default();
                    for w in series.windows(3).skip(left.like.rest_frames) {
                        sum.0 += (w[0] - 2.0 * w[1] + w[2]).powi(2) / (6.0 * lost);
                        sum.1 += 1.0;
                    }
                }
            }
        }
        for (quantity, (sum, count)) in seen {
            if let Some(noise) = self.noise.get_mut(&quantity) {
                noise.sigma_m = noise.sigma_m.max((sum / f64::max(count, 1.0)).sqrt());
            }
        }
    }
}

/// Measured less expected, m; zero where nothing was seen.
fn residuals(record: &Record, expected: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let series = |channel: &super::record::Channel, expected: &Vec<f64>| {
        channel.value.iter().zip(expected).map(|(y, e)| y.map_or(0.0, |y| y - e)).collect()
    };
    record.channels.iter().zip(expected).map(|(c, e)| series(c, e)).collect()
}

/// What a channel shows while the liquid moves.
fn moving(record: &Record, quantity: Quantity) -> impl Iterator<Item = f64> + '_ {
    let of = move |c: &&super::record::Channel| c.quantity == quantity;
    let skip = record.rest_frames;
    record.channels.iter().filter(of).flat_map(move |c| c.value.iter().skip(skip).flatten().copied())
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(s, n), x| (s + x * x, n + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}
