//! Hyperparameters of a correction, in one serialised struct.
//!
//! "Chosen by hand" means that the first value that worked has stayed: no sweep over it is recorded.

use serde::{Deserialize, Serialize};

/// Everything that a correction can be tuned by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CorrectionParameters {
    /// Steps of Adam; 300 take half a minute on two cores, and longer where the model carries effects.
    pub steps: usize,
    /// Largest growth of the slosh-relative error on the source recordings.
    pub forgetting: f64,
    /// Learning rate of the first step. Chosen by hand.
    pub learning_rate: f64,
    /// Roll-outs of one step: of the new liquid, of the same stretched, of the source liquid. Chosen by hand.
    pub batch: [usize; 3],
    /// Steps between two candidates.
    pub judge_every: usize,
    /// Factors by which heights and travel of the glass are stretched alike. Small sloshes are linear, so that a stronger
    /// one than any that was recorded is then not met for the first time.
    pub stretch: [f32; 2],
    /// Frames over which the filter is followed in the loss: 0.2 s, most of a period.
    pub tracked_frames: usize,
    /// Frames of a forecast in the loss: 0.5 s. An error of frequency or damping grows with the time.
    pub forecast_frames: usize,
    /// Frames ahead at which a candidate is judged: 0.25 s.
    pub judged_frames: usize,
    /// Share of a single recording that is learnt from; the rest is held out.
    pub learnt_share: f64,
    /// Covariance of the residuals.
    pub residuals: ResidualParameters,
    /// Largest factor by which the intervals are widened.
    pub max_widening: f32,
}

impl Default for CorrectionParameters {
    fn default() -> Self {
        Self {
            steps: 300,
            forgetting: 0.05,
            learning_rate: 2e-3,
            batch: [40, 16, 16],
            judge_every: 10,
            stretch: [1.6, 2.4],
            tracked_frames: 12,
            forecast_frames: 30,
            judged_frames: 15,
            learnt_share: 0.7,
            residuals: ResidualParameters::default(),
            max_widening: 20.0,
        }
    }
}

/// Estimate of the residual covariance; its formulas stand in `residual_covariance`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResidualParameters {
    /// K, share of Q that is measured. Chosen, as the next, on recordings of butter and water that a correction learns from.
    pub measured_share: f64,
    /// Share of the frames, those of least w, that rho is measured on.
    pub still_share: f64,
    /// Bounds of rho.
    pub noise_ratio_bounds: [f64; 2],
}

impl Default for ResidualParameters {
    fn default() -> Self {
        Self { measured_share: 0.9, still_share: 0.2, noise_ratio_bounds: [0.05, 1.0] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of parameters gives back the same numbers, and one that lacks a field is refused by name.
    #[test]
    fn parameters_survive_json() {
        let ours = CorrectionParameters::default();
        let mut value = serde_json::to_value(&ours).expect("plain numbers");
        assert_eq!(serde_json::from_value::<CorrectionParameters>(value.clone()).expect("the same"), ours);
        value["residuals"].as_object_mut().expect("an object").remove("still_share");
        let refused = serde_json::from_value::<CorrectionParameters>(value).expect_err("a field is missing");
        assert!(refused.to_string().contains("still_share"), "{refused}");
    }
}
