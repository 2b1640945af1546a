//! Last stage of a run: judgement of the model, beside that of the true liquid, and the report.

use super::{Outcome, Run, SimulatedLiquid};
use crate::error::RelearnError;
use crate::identify::NUMERICAL_VISCOSITY_M2_S;
use crate::judge::judge;
use crate::liquid_source::LiquidSource;
use crate::motions::strength;
use crate::plan::Plan;
use crate::report::{Content, write};
use crate::stage::Stage;
use meniscus::blob::Model;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Recording;
use meniscus_data::validity::Validity;
use meniscus_discover::recordings::record::Drive;
use meniscus_platform::files::AlignedBytes;
use meniscus_report::checks::Check;

impl Run<'_> {
    /// Judges the finished model, beside the oracle's where one is named, and writes the report.
    pub(super) fn report(
        &self,
        liquid: &SimulatedLiquid,
        held_out: &[Recording],
        training: &[Recording],
        mut outcome: Outcome,
    ) -> Result<Outcome, RelearnError> {
        let blob = AlignedBytes::read(&self.folder.model())?;
        let mut judged_on = held_out.to_vec();
        let mut beside = Vec::new();
        if let Some(name) = &self.plan.oracle {
            let (oracle, recordings) = self.oracle(name, &liquid.liquid)?;
            let own = judge(&oracle, &recordings, self.plan.seed)?;
            beside.extend(own.checks.iter().map(|check| {
                Check::informational(
                    format!("oracle_{}", check.name),
                    check.value.unwrap_or(f64::NAN),
                    check.unit,
                )
            }));
            // Both are judged on the true liquid.
            judged_on = recordings;
        }
        self.progress.begins(Stage::Report, &format!("{} held-out recordings", judged_on.len()));
        let judged = judge(&blob, &judged_on, self.plan.seed)?;
        let spilled_ml = |recording: &Recording| 1e6 * recording.spilled_m3.last().copied().unwrap_or(0.0);
        let most = training.iter().chain(held_out).map(spilled_ml).fold(0.0, f64::max);
        beside.push(Check::informational("largest_spill", most, "ml"));
        let header = Model::load(&blob)?.header;
        outcome.sentences.extend(Validity::of(&header).sentence);
        let nu = liquid.liquid.rheology.consistency / liquid.liquid.density_kg_m3;
        if liquid.liquid.rheology.is_newtonian() && nu < NUMERICAL_VISCOSITY_M2_S {
            outcome.sentences.push(format!(
                "The kinematic viscosity {nu:.1e} m2/s is below the simulator's own {NUMERICAL_VISCOSITY_M2_S:.1e} m2/s: the damping \
                 at the wall is that of the liquid, the damping inside is the simulator's"
            ));
        }
        let content = Content {
            liquid: &liquid.liquid.name,
            command: self.command,
            sentences: &outcome.sentences,
            judged: &judged,
            beside: &beside,
        };
        write(self.folder, &content)?;
        self.progress.ends(&format!("{}", self.folder.page().display()));
        outcome.finished = Stage::Report;
        outcome.checks = judged.checks.into_iter().chain(beside).collect();
        Ok(outcome)
    }

    /// Model of the true liquid `name`, learned with the same settings, and its held-out recordings.
    fn oracle(&self, name: &str, learned: &Liquid) -> Result<(AlignedBytes, Vec<Recording>), RelearnError> {
        let scale = match self.plan.strength {
            Some(scale) => scale,
            None => {
                let drives: Vec<(String, &Drive)> =
                    self.measured.iter().map(|one| (one.record.name.clone(), &one.record.drive)).collect();
                strength(learned, &self.plan.glass, self.plan.seconds, &drives)?
            }
        };
        let plan = Plan {
            liquid: LiquidSource::Stated(name.into()),
            strength: Some(scale),
            recordings: Vec::new(),
            oracle: None,
            ..self.plan.clone()
        };
        let folder = self.folder.oracle();
        let run = Run { plan: &plan, folder: &folder, measured: &[], ..*self };
        run.go(Stage::Correct)?;
        let liquid = run.liquid()?;
        let planned = run.planned(&liquid.liquid)?;
        let [_, _, held_out] = run.sets(&liquid, &planned, &[])?;
        Ok((AlignedBytes::read(&folder.model())?, held_out))
    }
}
