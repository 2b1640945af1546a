//! Random moves, each of its own seed.

use crate::request::{Limits, Request};
use meniscus_data::liquids::{Liquid, LiquidError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Confidence of every move.
const CONFIDENCE: f64 = 0.95;

/// A liquid of the study and the model that plans for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StudyLiquid {
    /// Glycerine, planned and estimated by a learned model.
    Glycerine,
    /// Water, planned and estimated by a learned model or the reduced one.
    Water,
}

impl StudyLiquid {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Glycerine, Self::Water];

    /// Its name among the liquids.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Glycerine => "glycerine",
            Self::Water => "water",
        }
    }

    /// The liquid itself.
    ///
    /// # Errors
    /// When the liquid compiled in is wrong.
    pub fn load(self) -> Result<Liquid, LiquidError> {
        Liquid::load(self.name())
    }
}

/// A move from rest to rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Move {
    /// The liquid.
    pub liquid: StudyLiquid,
    /// Seed of the draw and of the camera's noise.
    pub seed: u64,
    /// The move itself, from 0 m.
    pub request: Request,
}

impl Move {
    /// The move of this seed: 0.1 to 0.5 m, below 4 to 10 mm.
    #[must_use]
    pub fn new(liquid: StudyLiquid, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (to_m, limit_m) = (random.random_range(0.1..0.5), random.random_range(0.004..0.010));
        let limits = Limits::default();
        let request = Request { to_m, limits, limit_m, confidence: CONFIDENCE, residual_m: None };
        Self { liquid, seed, request }
    }

    /// Name, by liquid and seed.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}-{}", self.liquid.name(), self.seed)
    }
}

/// Returns `count` moves of the seeds from `first` on, the liquids in turn.
#[must_use]
pub fn moves(count: usize, first: u64) -> Vec<Move> {
    let liquids = StudyLiquid::ALL.into_iter().cycle();
    liquids.zip(first..).take(count).map(|(liquid, seed)| Move::new(liquid, seed)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_repeat_and_stay_in_their_ranges() {
        let all = moves(40, 1);
        assert_eq!(all, moves(40, 1));
        assert_eq!(all.iter().filter(|one| one.liquid == StudyLiquid::Water).count(), 20);
        for one in &all {
            assert!((0.1..0.5).contains(&one.request.to_m) && (0.004..0.01).contains(&one.request.limit_m));
            one.request.check(0.0).expect("a move that can be meant");
        }
        assert_ne!(all[0].request.to_m, all[2].request.to_m);
    }
}
