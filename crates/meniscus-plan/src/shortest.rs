//! The root of c(T) = 1: the shortest duration whose lowest crest is not above the limit.

use crate::PlanError;
use crate::models::SurfaceModel;
use crate::program::{Answer, Correction};
use crate::search::{LONGEST_S, Search, TOLERANCE};

/// Part of the limit above which a crest counts as at the limit.
const NEAR: f64 = 0.985;

/// Programs in a search.
const TRIES: usize = 16;

/// A duration with its solution.
#[derive(Clone, Debug)]
pub(crate) struct Timed {
    pub(crate) duration_s: f64,
    pub(crate) answer: Answer,
}

impl<M: SurfaceModel> Search<'_, M> {
    /// The shortest duration from `least_s` on whose lowest crest is not above the limit.
    pub(crate) fn fastest(
        &mut self,
        guess_s: f64,
        least_s: f64,
        correction: &Correction,
    ) -> Result<Timed, PlanError> {
        let limit_m = self.request.limit_m;
        let (mut low_s, mut above) = (least_s, None::<f64>);
        let mut high: Option<Timed> = None;
        let mut lowest_m = f64::NAN;
        let mut duration_s = guess_s.max(least_s * (1.0 + 1e-6));
        for _ in 0..TRIES {
            match self.program(duration_s, correction)? {
                None => (low_s, above) = (duration_s, None),
                Some(answer) => {
                    let ratio = answer.crest_m / limit_m;
                    lowest_m = answer.crest_m.min(lowest_m);
                    if ratio > 1.0 {
                        (low_s, above) = (duration_s, Some(ratio));
                    } else {
                        high = Some(Timed { duration_s, answer });
                        if ratio > NEAR {
                            break;
                        }
                    }
                }
            }
            duration_s = match &high {
                Some(high) if high.duration_s <= low_s * (1.0 + TOLERANCE) => break,
                Some(high) => between(low_s, above, high, limit_m),
                // c falls with 1/T^2 where the surface is slow, and less where the present slosh is the crest.
                None => low_s * above.map_or(1.15, |ratio| ratio.sqrt().clamp(1.02, 1.6)),
            };
            if duration_s > LONGEST_S {
                break;
            }
        }
        high.ok_or(PlanError::Infeasible { longest_s: duration_s.min(LONGEST_S), crest_m: lowest_m, limit_m })
    }
}

/// A duration between `low_s` and that of `high`, where log c over log T meets the limit.
fn between(low_s: f64, above: Option<f64>, high: &Timed, limit_m: f64) -> f64 {
    let (low, top) = (low_s.ln(), high.duration_s.ln());
    let below = (high.answer.crest_m / limit_m).max(1e-3).ln();
    let share = match above {
        Some(ratio) => (ratio.ln() / (ratio.ln() - below)).clamp(0.1, 0.95),
        // No crest is known at the lower end: by c ~ 1/T^2 from the upper one.
        None => ((top + 0.5 * below - low) / (top - low)).clamp(0.1, 0.9),
    };
    (low + share * (top - low)).exp()
}
