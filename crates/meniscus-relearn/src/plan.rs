//! Settings of a run: everything that determines its result.

use crate::error::RelearnError;
use crate::folder::Folder;
use crate::liquid_source::LiquidSource;
use meniscus_data::recording::Glass;
use meniscus_learn::{Hyperparameters, Schedule};
use meniscus_platform::files::write_whole;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Number of simulated recordings in each set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetSizes {
    /// Recordings that weights are learnt from.
    pub training: usize,
    /// Recordings that choices are made and intervals are measured by.
    pub validation: usize,
    /// Recordings that nothing is chosen by.
    pub held_out: usize,
}

/// Settings of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// Version of the program.
    pub version: String,
    /// Liquid.
    pub liquid: LiquidSource,
    /// Glass.
    pub glass: Glass,
    /// Spacing of the particles, m.
    pub spacing_m: f64,
    /// Length of each simulated recording, s.
    pub seconds: f64,
    /// Sizes of the sets.
    pub sizes: SetSizes,
    /// Whether the liquid is identified by the reduced model alone, without simulations.
    pub rough: bool,
    /// Scale of the motions; chosen from the liquid and the recordings where it is not given.
    pub strength: Option<f64>,
    /// Seed of the training.
    pub seed: u64,
    /// Hyperparameters of the training.
    pub hyperparameters: Hyperparameters,
    /// Whether the training starts from the weights of the base model.
    pub transfer: bool,
    /// Checksum of the base model.
    pub base: u32,
    /// Names and checksums of the measured recordings.
    pub recordings: Vec<(String, u32)>,
    /// True liquid, whose own model the result is compared with.
    pub oracle: Option<String>,
}

impl Plan {
    /// Plan of the default length for `liquid` in `glass`: 24 recordings of 4 s and the full schedule.
    #[must_use]
    pub fn new(liquid: LiquidSource, glass: Glass) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            liquid,
            glass,
            spacing_m: 0.005,
            seconds: 4.0,
            sizes: SetSizes { training: 16, validation: 4, held_out: 4 },
            rough: false,
            strength: None,
            seed: 1,
            hyperparameters: Hyperparameters::with_schedule(Schedule::FULL),
            transfer: false,
            base: 0,
            recordings: Vec::new(),
            oracle: None,
        }
    }

    /// The same with five recordings of 3 s, the short schedule and a rough identification.
    #[must_use]
    pub fn quick(self) -> Self {
        Self {
            seconds: 3.0,
            rough: true,
            sizes: SetSizes { training: 3, validation: 1, held_out: 1 },
            hyperparameters: Hyperparameters::with_schedule(Schedule::QUICK),
            ..self
        }
    }

    /// Checks the ranges of all settings.
    ///
    /// # Errors
    /// [`RelearnError::OutOfRange`].
    pub fn check(&self) -> Result<(), RelearnError> {
        let counts = [self.sizes.training, self.sizes.validation, self.sizes.held_out];
        for (name, value, range, allowed) in [
            ("--seconds", self.seconds, 1.5..=60.0, "1.5 to 60"),
            ("--strength", self.strength.unwrap_or(1.0), 0.01..=1.2, "0.01 to 1.2"),
            ("--training", counts[0] as f64, 1.0..=500.0, "1 to 500"),
            ("--validation", counts[1] as f64, 1.0..=500.0, "1 to 500"),
            ("--held-out", counts[2] as f64, 1.0..=500.0, "1 to 500"),
        ] {
            if !range.contains(&value) {
                return Err(RelearnError::OutOfRange { name, value, allowed });
            }
        }
        Ok(())
    }

    /// Makes `folder` the folder of this plan; one that is there already must be of the same plan.
    ///
    /// # Errors
    /// [`RelearnError::OtherPlan`], [`RelearnError::Malformed`] or [`RelearnError::File`].
    pub fn bind(&self, folder: &Folder) -> Result<(), RelearnError> {
        let path = folder.plan();
        let malformed = |fault: String| RelearnError::Malformed { path: path.clone(), fault };
        let ours = serde_json::to_value(self).map_err(|error| malformed(error.to_string()))?;
        let Ok(text) = std::fs::read_to_string(&path) else {
            return Ok(write_whole(&path, format!("{ours:#}\n").as_bytes())?);
        };
        let theirs: Value = serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
        let mut differences = Vec::new();
        compare("", &theirs, &ours, &mut differences);
        if differences.is_empty() {
            return Ok(());
        }
        Err(RelearnError::OtherPlan { folder: folder.path().into(), differences: differences.join("; ") })
    }
}

/// Collects the fields in which `theirs` and `ours` differ.
fn compare(name: &str, theirs: &Value, ours: &Value, differences: &mut Vec<String>) {
    if let (Value::Object(theirs), Value::Object(ours)) = (theirs, ours) {
        let absent = Value::Null;
        let names: std::collections::BTreeSet<&String> = theirs.keys().chain(ours.keys()).collect();
        for field in names {
            let full = if name.is_empty() { field.clone() } else { format!("{name}.{field}") };
            let [theirs, ours] = [theirs, ours].map(|object| object.get(field).unwrap_or(&absent));
            compare(&full, theirs, ours, differences);
        }
    } else if theirs != ours {
        differences.push(format!("{name} is {theirs} there and {ours} here"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::scene_file::GLASS;

    fn plan() -> Plan {
        Plan::new(LiquidSource::Stated("water".into()), GLASS)
    }

    #[test]
    fn a_folder_takes_one_plan_and_names_what_another_changes() {
        let path = std::env::temp_dir().join(format!("meniscus-plan-{}", std::process::id()));
        let folder = Folder::new(&path);
        plan().bind(&folder).expect("a new folder");
        plan().bind(&folder).expect("the same plan");
        let other = Plan { seconds: 3.0, seed: 2, ..plan() };
        let refused = other.bind(&folder).expect_err("another plan").to_string();
        assert!(
            refused.contains("seconds is 4.0 there and 3.0 here") && refused.contains("seed is 1"),
            "{refused}"
        );
        std::fs::write(folder.plan(), "{").expect("written");
        assert!(matches!(plan().bind(&folder), Err(RelearnError::Malformed { .. })));
        std::fs::remove_dir_all(&path).expect("removed");
    }

    #[test]
    fn ranges_are_checked_by_name() {
        plan().check().expect("the default");
        plan().quick().check().expect("the short one");
        let short = Plan { seconds: 1.0, ..plan() };
        assert!(short.check().expect_err("too short").to_string().contains("--seconds = 1"));
        let none = Plan { sizes: SetSizes { held_out: 0, ..plan().sizes }, ..plan() };
        assert!(none.check().expect_err("nothing held out").to_string().contains("--held-out"));
    }
}
