//! Risk that the crest passes the rim within a horizon.
//!
//! ```text
//! p = max over turns and heights of 1 - Phi((rim - z) / s),     s = half / 1.645
//! ```
//! z and half are those of the forecast; half is the 90 % quantile of the error, and a normal error is supposed beyond it.
//! Errors of neighbouring turns and heights are nearly one error, so that the largest of their probabilities stands for
//! that of any; it is a lower bound.

use meniscus::blob::Model;
use meniscus::runtime::{Forecast, Memory};
use serde::{Deserialize, Serialize};

/// 90 % quantile of the size of a standard normal error.
const QUANTILE_90: f64 = 1.645;

/// Risk of spilling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpillRisk {
    /// Turns of the horizon.
    pub horizon: u32,
    /// Turns of it for which the motion is planned.
    pub planned: u32,
    /// Largest probability that a height passes the rim.
    pub probability: f32,
    /// Turn of the highest point of the forecast, from 1.
    pub crest_turn: u32,
    /// Height of it above the inner bottom, m.
    pub crest_m: f32,
    /// Half-width of it with 90 % coverage, m.
    pub crest_half_m: f32,
}

impl SpillRisk {
    /// Returns the risk within `horizon` turns after `memory` under `plan`, and hands every turn's forecast to `visit`.
    #[must_use]
    pub fn within(
        model: &Model<'_>,
        memory: &Memory,
        horizon: usize,
        plan: &[f64],
        mut visit: impl FnMut(usize, &Forecast),
    ) -> Self {
        let planned = plan.len().min(horizon) as u32;
        let mut risk =
            Self { horizon: horizon as u32, planned, crest_m: f32::NEG_INFINITY, ..Self::default() };
        Forecast::course(model, memory, horizon, plan, |ahead, forecast| {
            for (height, half) in forecast.surface_m.iter().zip(forecast.half_width_m) {
                risk.probability = risk.probability.max(above(model.header.rim_m, *height, half));
                if *height > risk.crest_m {
                    (risk.crest_turn, risk.crest_m, risk.crest_half_m) = (ahead as u32, *height, half);
                }
            }
            visit(ahead, forecast);
        });
        risk
    }
}

/// Returns the probability that a height passes `rim_m`.
fn above(rim_m: f64, height_m: f32, half_m: f32) -> f32 {
    let distance = (rim_m - f64::from(height_m)) * QUANTILE_90 / f64::from(half_m).max(1e-9);
    tail(distance) as f32
}

/// 1 - Phi(x) of a standard normal number, with an error below 1e-7 (Abramowitz and Stegun, 26.2.17).
fn tail(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let series = t
        * (0.319_381_530
            + t * (-0.356_563_782 + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let upper = series * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    if x >= 0.0 { upper } else { 1.0 - upper }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        for (x, due) in
            [(0.0, 0.5), (1.0, 0.158_655_254), (-1.0, 0.841_344_746), (1.644_854, 0.05), (3.0, 0.001_349_898)]
        {
            assert!((tail(x) - due).abs() < 2e-7, "{x}: {}", tail(x));
        }
        // A crest that touches the rim passes it in half of the cases; one half-width below it in one of twenty.
        assert!((above(0.11, 0.11, 0.004) - 0.5).abs() < 1e-4);
        assert!((above(0.11, 0.106, 0.004) - 0.05).abs() < 1e-3);
    }
}
