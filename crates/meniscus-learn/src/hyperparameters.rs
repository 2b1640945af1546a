//! Hyperparameters of the training, in one serialised struct.
//!
//! Each field says where its value comes from. "Chosen by hand" means that the first value that worked has stayed: no sweep
//! over it is recorded. Widths and counts that the blob or the camera side fixes are no hyperparameters; they stand beside
//! the layers that they shape.

use serde::{Deserialize, Serialize};

/// Length of every optimisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Schedule {
    /// Steps of the autoencoder.
    pub autoencoder: usize,
    /// Passes of the encoder over all windows.
    pub encoder: usize,
    /// Steps of one roll-out training.
    pub rollout: usize,
    /// Roll-out trainings from different seeds; the best on the validation recordings stays.
    pub seeds: u64,
}

impl Schedule {
    /// Full training, some six minutes on two cores.
    pub const FULL: Self = Self { autoencoder: 4000, encoder: 300, rollout: 3000, seeds: 2 };

    /// Short training, under a minute on two cores.
    pub const QUICK: Self = Self { autoencoder: 2000, encoder: 60, rollout: 400, seeds: 1 };
}

/// Everything that a training can be tuned by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hyperparameters {
    /// Length of every optimisation.
    pub schedule: Schedule,
    /// POD bases of the field groups.
    pub pod: PodParameters,
    /// Joint autoencoder.
    pub autoencoder: AutoencoderParameters,
    /// GRU encoder.
    pub encoder: EncoderParameters,
    /// Warm start of the operators.
    pub warm_start: WarmStartParameters,
    /// Roll-out training of the operators.
    pub rollout: RolloutParameters,
    /// Pattern of the internal energy.
    pub heat: HeatParameters,
    /// Constant-gain filter.
    pub filter: FilterParameters,
    /// Soft net, a comparison.
    pub soft: SoftParameters,
    /// Sparse autoencoders, a comparison.
    pub sparse: SparseParameters,
}

impl Hyperparameters {
    /// The values of every shipped model, with the given schedule.
    #[must_use]
    pub fn with_schedule(schedule: Schedule) -> Self {
        Self {
            schedule,
            pod: PodParameters::default(),
            autoencoder: AutoencoderParameters::default(),
            encoder: EncoderParameters::default(),
            warm_start: WarmStartParameters::default(),
            rollout: RolloutParameters::default(),
            heat: HeatParameters::default(),
            filter: FilterParameters::default(),
            soft: SoftParameters::default(),
            sparse: SparseParameters::default(),
        }
    }
}

impl Default for Hyperparameters {
    fn default() -> Self {
        Self::with_schedule(Schedule::FULL)
    }
}

/// Snapshots and ranks of the proper orthogonal decomposition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PodParameters {
    /// Largest number of snapshots of one decomposition. The eigenproblem costs its cube.
    pub max_snapshots: usize,
    /// Smallest energy of a snapshot, relative to the liveliest frame. Chosen by hand.
    pub moving_energy_share: f64,
    /// Largest number of modes of q, v, sigma, tau and the surface. Bounded by the size of the blob: 6402 numbers a mode.
    pub max_modes: [usize; 5],
    /// Relative L2 error at which fewer modes are enough. Chosen by hand.
    pub tolerance: f64,
}

impl Default for PodParameters {
    fn default() -> Self {
        Self {
            max_snapshots: 600,
            moving_energy_share: 1e-3,
            max_modes: [12, 24, 24, 24, 8],
            tolerance: 1e-3,
        }
    }
}

/// Optimisation of the joint autoencoder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AutoencoderParameters {
    /// Snapshots of one step. Chosen by hand.
    pub batch: usize,
    /// Learning rate of the first step. Chosen by hand.
    pub learning_rate: f64,
    /// Steps between two validations.
    pub validate_every: usize,
    /// Noise on the latents in units of their standard deviation. A filter never knows them exactly, so the decoder must
    /// be smooth. Size chosen by hand.
    pub latent_noise: f64,
    /// Share in the decoded coefficients, relative to the strongest latent, below which a latent is noise.
    pub silent_share: f64,
}

impl Default for AutoencoderParameters {
    fn default() -> Self {
        Self { batch: 256, learning_rate: 2e-3, validate_every: 100, latent_noise: 0.02, silent_share: 1e-3 }
    }
}

/// Optimisation of the GRU encoder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EncoderParameters {
    /// Windows of one step. Chosen by hand.
    pub batch: usize,
    /// Learning rate of the first epoch. Chosen by hand.
    pub learning_rate: f64,
    /// Epochs between two validations.
    pub validate_every: usize,
}

impl Default for EncoderParameters {
    fn default() -> Self {
        Self { batch: 128, learning_rate: 4e-3, validate_every: 5 }
    }
}

/// Search for the split of the linear generator from which the operators start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarmStartParameters {
    /// Weight of the relative error of the energy against that of the roll-outs. Chosen by hand.
    pub energy_error_weight: f64,
    /// Shares of the decoded fields that are added to the energy; the best of all pairs with `lyapunov_shares` is taken.
    pub grounding: [f64; 4],
    /// Shares of the correction by the Lyapunov equation: 0 keeps the energy, 1 the motion.
    pub lyapunov_shares: [f64; 6],
}

impl Default for WarmStartParameters {
    fn default() -> Self {
        Self {
            energy_error_weight: 0.3,
            grounding: [0.01, 0.03, 0.1, 0.2],
            lyapunov_shares: [0.0, 0.01, 0.03, 0.1, 0.3, 1.0],
        }
    }
}

/// Optimisation of the operators through roll-outs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RolloutParameters {
    /// Roll-outs of one step. At these sizes the cost is calls, not numbers.
    pub batch: usize,
    /// Learning rate of the first step. Chosen by hand.
    pub learning_rate: f64,
    /// Weight of the energy against the states in the loss, both relative to their mean square. It makes H the energy of
    /// the slosh, not just any function that falls.
    pub energy_weight: f32,
    /// Weight of the heat of a whole roll-out in the loss, likewise.
    pub heat_weight: f32,
    /// Turns of a roll-out in each third of the steps. One-step training is erratic; ten and more steps are not.
    pub horizons: [usize; 3],
    /// Steps between two validations.
    pub validate_every: usize,
    /// Steps for which one preconditioner serves.
    pub precondition_every: usize,
}

impl Default for RolloutParameters {
    fn default() -> Self {
        Self {
            batch: 128,
            learning_rate: 2e-3,
            energy_weight: 0.05,
            heat_weight: 0.02,
            horizons: [8, 16, 30],
            validate_every: 25,
            precondition_every: 10,
        }
    }
}

/// Least-squares fit of the pattern of the internal energy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeatParameters {
    /// Frames between two that are used: neighbours carry the same information.
    pub stride: usize,
    /// Ridge on the squares of x relative to that of the heat: a silent latent gets no pattern.
    pub ridge: f64,
    /// Share of the squares of `s P x` that may be left out.
    pub left_out: f64,
}

impl Default for HeatParameters {
    fn default() -> Self {
        Self { stride: 4, ridge: 1e-4, left_out: 0.004 }
    }
}

/// Regression of the constant gain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilterParameters {
    /// Rounds of regression. The innovation depends on the gain, and settles within a few.
    pub rounds: usize,
}

impl Default for FilterParameters {
    fn default() -> Self {
        Self { rounds: 8 }
    }
}

/// Optimisation of the soft net, which is trained for comparison alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SoftParameters {
    /// Learning rate of the first step: that of the exact step.
    pub learning_rate: f64,
    /// Weight of the degeneracy in the loss against a relative error of the states of one. Chosen by hand.
    pub degeneracy_weight: f32,
    /// Turns of a roll-out in each third of the steps.
    pub horizons: [usize; 3],
    /// Steps between two validations.
    pub validate_every: usize,
}

impl Default for SoftParameters {
    fn default() -> Self {
        Self { learning_rate: 2e-3, degeneracy_weight: 1e-2, horizons: [4, 8, 16], validate_every: 25 }
    }
}

/// Optimisation of the sparse autoencoders, which are trained for comparison alone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SparseParameters {
    /// Snapshots of one step: as many as the joint autoencoder takes.
    pub batch: usize,
    /// Learning rate of the first step: that of the joint autoencoder.
    pub learning_rate: f64,
    /// Weight of the L1 norm of the bottleneck; the paper takes 0.001 to 0.005.
    pub l1_weight: f32,
    /// Deviation relative to the largest of its group below which a latent is switched off.
    pub silent_share: f32,
    /// Steps between two validations.
    pub validate_every: usize,
}

impl Default for SparseParameters {
    fn default() -> Self {
        Self { batch: 256, learning_rate: 2e-3, l1_weight: 3e-3, silent_share: 0.1, validate_every: 100 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of hyperparameters gives back the same numbers, and one that lacks a field is refused by name.
    #[test]
    fn hyperparameters_survive_json() {
        let ours = Hyperparameters::with_schedule(Schedule::QUICK);
        let mut value = serde_json::to_value(&ours).expect("plain numbers");
        assert_eq!(serde_json::from_value::<Hyperparameters>(value.clone()).expect("the same fields"), ours);
        value["rollout"].as_object_mut().expect("an object").remove("horizons");
        let refused = serde_json::from_value::<Hyperparameters>(value).expect_err("a field is missing");
        assert!(refused.to_string().contains("horizons"), "{refused}");
    }
}
