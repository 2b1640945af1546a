//! Calibration of the reduced model by recordings of known liquids: prior, noise, offsets and model error.

use super::group::Group;
use super::held_line::HeldLine;
use super::noise::{Noise, rest_noise};
use super::offsets::Offsets;
use super::predict::SHARED;
use super::reference_residual::ReferenceResidual;
use super::trend::ViscosityTrend;
use crate::recordings::record::{Channel, Quantity, Record};
use crate::recordings::stated::Known;
use meniscus_numerics::statistics::rms;
use std::collections::BTreeMap;

/// Prior of the baseline and covariances of its error, learnt from references.
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
    /// Groups of references.
    pub groups: usize,
    noise: BTreeMap<Quantity, Noise>,
    misfit: BTreeMap<Quantity, f64>,
    offsets: Offsets,
    residuals: Vec<ReferenceResidual>,
}

/// Standard deviation of the share of the contact line that is held: it is set by the references, see `held_line`, and not fitted.
const SETTLED: f64 = 1e-3;

/// Mean and standard deviation of the baseline's numbers without references: linear theory and the second order of deep liquid, wide.
const MEAN: [f64; SHARED] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.62, -0.02, 0.80, 0.26, 0.0, 1.0];
const DEVIATION: [f64; SHARED] = [0.03, 0.1, 0.4, 0.6, 0.1, 0.4, 0.4, 1.0, 1.0, 1.0, 1.0, 1e-4, SETTLED];

/// Smallest standard deviations after calibration.
const FLOOR: [f64; SHARED] =
    [0.0015, 0.008, 0.012, 0.05, 0.004, 0.03, 0.03, 0.05, 0.05, 0.05, 0.05, 2e-5, SETTLED];

/// Standard deviation of a lag without references, s, and the smallest one after calibration, s.
pub(crate) const LAG_S: f64 = 0.004;
const LAG_FLOOR_S: f64 = 3e-4;

impl Calibration {
    /// Returns the calibration without references: linear theory, wide, and a model error of 5 % of the signal.
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
            residuals: Vec::new(),
        }
    }

    /// Returns the calibration by `groups` for recordings of the liquid `known` whose rest frames show the noise of `records`.
    ///
    /// What references of other viscosities differ by is a line in the logarithm of the viscosity, see `trend`.
    ///
    /// With `own_clocks_s`, every recording has a clock of its own and nothing is learnt about the lag.
    #[must_use]
    pub fn from(groups: &[&Group], known: &Known, records: &[Record], own_clocks_s: Option<f64>) -> Self {
        let mut out = Self::blind(records, own_clocks_s.unwrap_or(LAG_S));
        if groups.is_empty() {
            return out;
        }
        out.learn_baseline(groups, known);
        if own_clocks_s.is_none() {
            out.learn_lag(groups);
        }
        out.learn_residuals(groups, known);
        out.offsets = Offsets::of(groups);
        out.raise_noise();
        out.residuals.iter_mut().for_each(ReferenceResidual::smooth);
        out.groups = groups.len();
        out
    }

    /// Sets mean and deviation of the shared numbers: `s^2 = (1 + leverage) var + floor^2`, wider after a single group.
    fn learn_baseline(&mut self, groups: &[&Group], known: &Known) {
        let trend = ViscosityTrend::new(&viscosities(groups), known.viscosity_pa_s);
        let held = HeldLine::of(groups);
        let numbers_of: Vec<Vec<f64>> = groups.iter().map(|group| held.numbers(group)).collect();
        for i in 0..SHARED {
            let numbers: Vec<f64> = numbers_of.iter().map(|theta| theta[i]).collect();
            let line = trend.split(&numbers);
            let spread = line.left.iter().map(|e| e * e).sum::<f64>() / trend.freedom();
            let few = if groups.len() < 2 { 0.25 * DEVIATION[i] } else { 0.0 };
            self.mean[i] = line.value;
            self.deviation[i] =
                ((1.0 + trend.leverage()) * spread + FLOOR[i].powi(2) + few * few).sqrt().min(DEVIATION[i]);
        }
    }

    /// Sets mean and deviation of the lag.
    fn learn_lag(&mut self, groups: &[&Group]) {
        let lags: Vec<f64> = groups.iter().flat_map(|group| &group.theta[SHARED..]).copied().collect();
        let mean = lags.iter().sum::<f64>() / lags.len() as f64;
        let spread =
            lags.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (lags.len() as f64 - 1.0).max(1.0);
        self.lag_s = mean;
        self.lag_deviation_s = (spread + LAG_FLOOR_S * LAG_FLOOR_S).sqrt().min(LAG_S);
    }

    /// Collects the residuals of `groups` by motion, and their size by channel.
    fn learn_residuals(&mut self, groups: &[&Group], known: &Known) {
        let mut residuals: Vec<ReferenceResidual> = Vec::new();
        let mut squares: BTreeMap<Quantity, (f64, f64)> = BTreeMap::new();
        let of_records = groups.iter().flat_map(|group| {
            let mu = group.known.viscosity_pa_s;
            group.records.iter().zip(&group.residual_m).map(move |(record, left)| (record, left, mu))
        });
        for (record, residual_m, mu) in of_records {
            for (channel, series) in record.channels.iter().zip(residual_m) {
                let sum = squares.entry(channel.quantity).or_default();
                sum.0 += series.iter().map(|r| r * r).sum::<f64>();
                sum.1 += series.len() as f64;
            }
            let scatter = residual_m.clone();
            match residuals.iter_mut().find(|known| known.like.drive.same(&record.drive)) {
                Some(known) => {
                    known.scatter.push(scatter);
                    known.viscosities_pa_s.push(mu);
                }
                None => residuals.push(ReferenceResidual {
                    like: record.clone(),
                    mean: Vec::new(),
                    scatter: vec![scatter],
                    viscosities_pa_s: vec![mu],
                    leverage: 1.0,
                }),
            }
        }
        for (quantity, (sum, count)) in squares {
            self.misfit.insert(quantity, (sum / count.max(1.0)).sqrt());
        }
        self.residuals = residuals.into_iter().map(|one| one.centred(known.viscosity_pa_s)).collect();
    }

    /// Returns the residual of two or more references in the motion of `record`: the tracked motion, or the stated one
    /// where the glass was not tracked.
    #[must_use]
    pub fn matched(&self, record: &Record) -> Option<ReferenceResidual> {
        let kinds = |r: &Record| r.channels.iter().map(|c| c.quantity).collect::<Vec<_>>();
        let alike =
            |known: &&ReferenceResidual| known.scatter.len() > 1 && kinds(&known.like) == kinds(record);
        let tracked =
            self.residuals.iter().filter(alike).filter_map(|known| Some((known, known.alignment(record)?)));
        let nearest = tracked.min_by(|(_, a), (_, b)| a.scale.ln().abs().total_cmp(&b.scale.ln().abs()));
        if let Some((known, alignment)) = nearest {
            return Some(known.aligned(alignment));
        }
        self.residuals.iter().filter(alike).find(|known| known.like.drive.same(&record.drive)).cloned()
    }

    /// Returns the noise of a channel.
    #[must_use]
    pub fn noise_of(&self, quantity: Quantity) -> Noise {
        self.noise.get(&quantity).copied().unwrap_or(Noise { sigma_m: 2e-4, correlation: 0.3 })
    }

    /// Returns the model error in a motion that no reference made, m.
    #[must_use]
    pub fn misfit_m(&self, quantity: Quantity) -> f64 {
        self.misfit.get(&quantity).copied().unwrap_or(5e-4)
    }

    /// Returns the variance of the offset of a channel in one of `recordings` of a glass, m2.
    #[must_use]
    pub fn offset_m2(&self, quantity: Quantity, recordings: usize) -> f64 {
        self.offsets.variance_m2(quantity, recordings)
    }

    /// Raises the noise to what second differences of the references' scatter show while the liquid
    /// moves: `var(x_-1 - 2 x_0 + x_1) = 6 sigma^2` of white noise.
    fn raise_noise(&mut self) {
        let mut seen: BTreeMap<Quantity, (f64, f64)> = BTreeMap::new();
        for known in self.residuals.iter().filter(|known| known.scatter.len() > 1) {
            let lost = 1.0 - 1.0 / known.scatter.len() as f64;
            for scatter in &known.scatter {
                for (channel, series) in known.like.channels.iter().zip(scatter) {
                    let sum = seen.entry(channel.quantity).or_default();
                    for w in series.windows(3).skip(known.like.rest_frames) {
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

/// Returns the viscosity of each of `groups`, Pa s.
fn viscosities(groups: &[&Group]) -> Vec<f64> {
    groups.iter().map(|group| group.known.viscosity_pa_s).collect()
}

/// Returns the values of a channel while the liquid moves.
fn moving(record: &Record, quantity: Quantity) -> impl Iterator<Item = f64> + '_ {
    let of = move |c: &&Channel| c.quantity == quantity;
    let skip = record.rest_frames;
    record.channels.iter().filter(of).flat_map(move |c| c.value.iter().skip(skip).flatten().copied())
}
