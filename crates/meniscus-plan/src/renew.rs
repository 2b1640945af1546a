//! The rest of a move, planned anew only where the motion under way no longer keeps the limit.

use crate::PlanError;
use crate::course::Course;
use crate::models::SurfaceModel;
use crate::program::Correction;
use crate::search::{Plan, Search};

/// Largest factor on what is left of a motion.
const LONGER: f64 = 1.2;

/// Factor on the crest for which a longer motion is worth it.
const WORTH: f64 = 0.99;

/// Result of planning anew.
pub(crate) enum Renewed {
    /// The motion under way, as the present state lets expect it.
    Kept(Plan),
    /// Another motion.
    Changed(Plan),
}

impl<M: SurfaceModel> Search<'_, M> {
    /// One search of few programs from a motion that is in progress. Another motion takes its place where its forecast is better.
    pub(crate) fn renewed(&mut self, under_way: &Course) -> Result<Renewed, PlanError> {
        let (kept, correction) = self.examine(under_way);
        if self.keeps(&kept) {
            return Ok(Renewed::Kept(kept));
        }
        let remaining_s = under_way.duration_s();
        let Some((mut plan, correction)) = self.near(under_way, remaining_s, &correction)? else {
            return Ok(Renewed::Kept(kept));
        };
        if !self.keeps(&plan) {
            // c ~ 1/T^2; a fifth of the motion at most, as the next turn comes soon.
            let duration_s = remaining_s * self.used(&plan).most().sqrt().min(LONGER);
            if let Some((slower, _)) = self.near(under_way, duration_s, &correction)?
                && self.used(&slower).most() < WORTH * self.used(&plan).most()
            {
                plan = slower;
            }
        }
        // By the linear response it is better; the whole model may say otherwise.
        let lower = self.used(&plan).most() < self.used(&kept).most();
        Ok(if lower { Renewed::Changed(plan) } else { Renewed::Kept(kept) })
    }

    /// The motion of a duration near the one under way, with its forecast and what the linear response lacks of it.
    fn near(
        &mut self,
        under_way: &Course,
        duration_s: f64,
        correction: &Correction,
    ) -> Result<Option<(Plan, Correction)>, PlanError> {
        let answer = self.program_near(duration_s, correction, under_way)?;
        Ok(answer.map(|answer| self.examine(&self.course(duration_s, answer))))
    }
}
