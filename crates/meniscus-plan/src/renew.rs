//! The rest of a move, planned anew only where the motion under way no longer keeps the limit.

use crate::PlanError;
use crate::course::Course;
use crate::models::SurfaceModel;
use crate::preferred::Preferred;
use crate::search::{Plan, Search};

/// Result of planning anew.
pub(crate) enum Renewed {
    /// The motion under way, as the present state lets expect it.
    Kept(Plan),
    /// Another motion.
    Changed(Plan),
}

impl<M: SurfaceModel> Search<'_, M> {
    /// One search of few programs from a motion that is in progress, verified once.
    pub(crate) fn renewed(&mut self, under_way: &Course) -> Result<Renewed, PlanError> {
        let (kept, correction) = self.examine(under_way);
        if self.keeps(&kept) {
            return Ok(Renewed::Kept(kept));
        }
        let remaining_s = under_way.duration_s();
        let near = Preferred::Near(under_way);
        let Some(answer) = self.preferring(remaining_s, &correction, near)? else {
            return Ok(Renewed::Kept(kept));
        };
        let ratio = answer.crest_m / self.request.limit_m;
        let mut course = self.course(remaining_s, answer);
        if !(0.96..=1.0).contains(&ratio) {
            // c ~ 1/T^2; a sixth of the motion at most, as the next turn comes soon.
            let duration_s = remaining_s * ratio.max(0.0).sqrt().clamp(0.85, 1.2);
            if let Some(answer) = self.preferring(duration_s, &correction, near)? {
                let worth = ratio > 1.0 && answer.crest_m < 0.99 * ratio * self.request.limit_m
                    || ratio < 1.0 && answer.crest_m <= self.request.limit_m;
                if worth {
                    course = self.course(duration_s, answer);
                }
            }
        }
        Ok(Renewed::Changed(self.examine(&course).0))
    }
}
