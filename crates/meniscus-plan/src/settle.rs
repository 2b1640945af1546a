//! The motion of the lowest crest of one duration, by program and forecast in turn.
//!
//! ```text
//! q <- q + a (q* - q),    a = 1, 1/2, 1/4: the first by which the forecast, too, gets lower          q*: solution about q
//! ```
//! All of these motions keep the limits of the robot, which are convex. A step that is worth it for the linear response alone is
//! not taken: without that the rounds of a lively liquid swing from one motion to another.

use crate::PlanError;
use crate::course::Course;
use crate::models::SurfaceModel;
use crate::program::Correction;
use crate::search::{Plan, Search, frames_of};

/// Programs of one duration, behind the first.
const ROUNDS: usize = 6;

/// Gain for which a step is taken, as part of the limit.
const WORTH: f64 = 0.01;

/// Parts of the way to a solution that are tried.
const STEPS: [f64; 3] = [1.0, 0.5, 0.25];

impl<M: SurfaceModel> Search<'_, M> {
    /// The motion of the lowest crest that takes `duration_s`, by program and forecast in turn; `None` where the robot needs longer.
    /// The motion `nearby`, of any duration, saves time alone.
    /// Leaves in `correction` what the linear response lacks of its forecast.
    pub(crate) fn settled(
        &mut self,
        duration_s: f64,
        correction: &mut Correction,
        nearby: Option<&Course>,
    ) -> Result<Option<Plan>, PlanError> {
        let mut first = self.program(duration_s, correction, nearby)?;
        if first.is_none() {
            // What a motion of another duration lacked may leave no room here: from the liquid alone, once more.
            *correction = self.free(frames_of(duration_s));
            first = self.program(duration_s, correction, nearby)?;
        }
        let Some(answer) = first else { return Ok(None) };
        let (mut plan, next) = self.examine(&self.course(duration_s, answer));
        *correction = next;
        for _ in 0..ROUNDS {
            let Some(answer) = self.program(duration_s, correction, Some(&plan.course))? else { break };
            let (used, hoped) = (self.used(&plan).most(), answer.crest_m / self.request.limit_m);
            if used - hoped < WORTH {
                break;
            }
            let towards = |share: f64| {
                let mixed = |(q, next): (&f64, &f64)| q + share * (next - q);
                let jerks_m_s3 = plan.course.jerks_m_s3.iter().zip(&answer.jerks_m_s3).map(mixed).collect();
                self.examine(&Course { jerks_m_s3, ..plan.course.clone() })
            };
            let lower = |(plan, _): &(Plan, Correction)| self.used(plan).most() < used - 0.1 * WORTH;
            let Some((better, next)) = STEPS.into_iter().map(towards).find(lower) else { break };
            (plan, *correction) = (better, next);
        }
        Ok(Some(plan))
    }
}
