//! Stages of a training: name, stream of the seed, metric, checkpoint.
//!
//! A stage draws from stream [`StageInfo::stream`] of the run's seed, so that stages can be added, left out or reordered and
//! the others keep their numbers.

use meniscus_optim::progress::{Curve, Session};
use meniscus_optim::seed::derive_seed;
use serde::Serialize;

/// One stage of the training.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Bases, rest and scales of the field groups.
    Pod,
    /// Joint autoencoder.
    Autoencoder,
    /// Linear fit and its split into operators; its stream goes on through the camera noise of the filter stage.
    WarmStart,
    /// GRU encoder.
    Encoder,
    /// Roll-out training number k.
    Rollout(u64),
    /// Constant-gain filter on noisy readings.
    Filter,
    /// Runs behind the rendered camera that give the interval factors.
    Calibration,
    /// Runs behind the rendered camera that give errors and coverage.
    Evaluation,
    /// Soft net, a comparison.
    Soft,
    /// Sparse autoencoders, a comparison.
    Sparse,
}

/// Declaration of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageInfo {
    /// Name, as the report gives it.
    pub name: &'static str,
    /// Stream of the run's seed that the stage draws from; `None` where it draws nothing of its own.
    pub stream: Option<u64>,
    /// Figure that the stage is judged by, on the validation recordings.
    pub metric: &'static str,
    /// Whether the stage is an optimisation with a checkpoint of its own.
    pub checkpoint: bool,
}

/// First stream of the roll-out trainings: number k draws from stream 8 + k.
const FIRST_ROLLOUT: u64 = 8;

impl Stage {
    /// Declaration of the stage. The streams are part of the format of a result: another number is another model.
    #[must_use]
    pub fn info(self) -> StageInfo {
        const ROLLOUT: &str = "relative error of 2 s roll-outs with known motion";
        let declared = |name, stream, metric, checkpoint| StageInfo { name, stream, metric, checkpoint };
        match self {
            Self::Pod => declared("pod", None, "largest relative error of a truncated basis", false),
            Self::Autoencoder => {
                declared("autoencoder", Some(0), "relative error of the coefficients, mean over groups", true)
            }
            Self::WarmStart => declared("warm start", Some(1), ROLLOUT, false),
            Self::Encoder => declared("encoder", Some(2), "error of the readings in the latent metric", true),
            Self::Rollout(k) => declared("dynamics", Some(FIRST_ROLLOUT + k), ROLLOUT, true),
            Self::Filter => declared("filter", None, "slosh-relative error of the filtered surface", false),
            Self::Calibration => declared("calibration", Some(3), "error at rest, m", false),
            Self::Evaluation => declared("evaluation", Some(4), "slosh-relative error of the surface", false),
            Self::Soft => declared("soft", Some(5), ROLLOUT, true),
            Self::Sparse => declared("sparse", Some(6), "relative error of the coefficients, by group", true),
        }
    }

    /// Seed of the stage in the run of `seed`; the run's own where the stage has no stream.
    #[must_use]
    pub fn seed(self, seed: u64) -> u64 {
        self.info().stream.map_or(seed, |stream| derive_seed(seed, stream))
    }

    /// Name of the stage in curves and checkpoints; a roll-out training has its seed in it.
    #[must_use]
    pub fn label(self, seed: u64) -> String {
        match self {
            Self::Rollout(_) => format!("dynamics {:04x}", self.seed(seed) & 0xffff),
            _ => String::from(self.info().name),
        }
    }

    /// File of the checkpoint; the sparse nets have one each.
    fn checkpoint(self, seed: u64) -> String {
        match self {
            Self::Sparse => String::from("sparse *.postcard"),
            _ => format!("{}.postcard", self.label(seed)),
        }
    }
}

/// Result of one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageRecord {
    /// Name of the stage.
    pub stage: String,
    /// Seed that it drew from.
    pub seed: Option<u64>,
    /// Figure that it is judged by.
    pub metric: &'static str,
    /// Value of the figure.
    pub value: Option<f64>,
    /// File of its checkpoint, in the folder of the training.
    pub checkpoint: Option<String>,
}

impl StageRecord {
    /// Record of `stage` with the `value` of its metric, in the run of `seed`.
    #[must_use]
    pub fn new(stage: Stage, seed: u64, value: Option<f64>) -> Self {
        let (info, label) = (stage.info(), stage.label(seed));
        Self {
            seed: info.stream.map(|_| stage.seed(seed)),
            metric: info.metric,
            value,
            checkpoint: info.checkpoint.then(|| stage.checkpoint(seed)),
            stage: label,
        }
    }

    /// Record of an optimisation, whose metric is the least validation error of its curve.
    #[must_use]
    pub fn from_curve(stage: Stage, seed: u64, curves: &[Curve]) -> Self {
        let label = stage.label(seed);
        let looks = curves.iter().filter(|curve| curve.stage == label).flat_map(|curve| &curve.looks);
        let least = looks.map(|look| look.2).fold(f64::INFINITY, f64::min);
        Self::new(stage, seed, least.is_finite().then_some(least))
    }
}

/// One optimisation: how long, from which seed, in which session.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StageRun<'a> {
    /// Steps or epochs.
    pub(crate) steps: usize,
    /// Seed of everything that the stage draws.
    pub(crate) seed: u64,
    /// Bars, stop flag and checkpoints.
    pub(crate) session: &'a Session<'a>,
}

/// Training and validation data of one stage.
#[derive(Debug)]
pub(crate) struct TrainingSplit<'a, T: ?Sized> {
    /// Data that the stage learns from.
    pub(crate) training: &'a T,
    /// Data that its best state is chosen by.
    pub(crate) validation: &'a T,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two stages never draw the same numbers, and the streams are those of every model so far.
    #[test]
    fn streams_are_distinct_and_stay() {
        let stages = [
            Stage::Autoencoder,
            Stage::WarmStart,
            Stage::Encoder,
            Stage::Calibration,
            Stage::Evaluation,
            Stage::Soft,
            Stage::Sparse,
            Stage::Rollout(0),
            Stage::Rollout(1),
        ];
        let streams: Vec<_> = stages.iter().filter_map(|stage| stage.info().stream).collect();
        assert_eq!(streams, [0, 1, 2, 3, 4, 5, 6, 8, 9]);
        assert_eq!(Stage::Rollout(1).seed(7), derive_seed(7, 9));
        assert_eq!((Stage::Pod.seed(7), Stage::Pod.label(7)), (7, String::from("pod")));
        let name = format!("dynamics {:04x}", derive_seed(7, 8) & 0xffff);
        assert_eq!(Stage::Rollout(0).label(7), name);
    }

    /// A record takes the least validation error of its own curve.
    #[test]
    fn a_record_reads_its_curve() {
        let curve = |stage: &str, errors: [f64; 2]| Curve {
            stage: String::from(stage),
            looks: vec![(100, 0.5, errors[0]), (200, 0.4, errors[1])],
        };
        let curves = [curve("autoencoder", [0.3, 0.2]), curve("encoder", [0.1, 0.15])];
        let record = StageRecord::from_curve(Stage::Encoder, 1, &curves);
        assert_eq!((record.value, record.checkpoint.as_deref()), (Some(0.1), Some("encoder.postcard")));
        assert_eq!(StageRecord::from_curve(Stage::Soft, 1, &curves).value, None);
    }
}
