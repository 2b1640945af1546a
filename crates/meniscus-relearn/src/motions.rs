//! Motions of the simulated glass: kinds, seeds and strength.
//!
//! The mix is that of the shipped model: mostly strokes and random motions, some jolts, a sweep through the first mode. Seeds of
//! the three sets are apart. Strength is the scale of the travel. A low-viscosity liquid would leave the glass at the full one,
//! so that the highest crest of the reduced model under these motions bounds it ([`largest_strength`]).

use crate::error::RelearnError;
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::liquids::Liquid;
use meniscus_data::motion::Motion;
use meniscus_data::recording::Glass;
use meniscus_discover::baseline::calibrate::Calibration;
use meniscus_discover::baseline::predict::predict;
use meniscus_discover::recordings::record::{Channel, Drive, Quantity, Record};
use meniscus_discover::recordings::stated::{CALLIPERS_M, Known};
use meniscus_discover::recordings::tables::drive_of;
use std::path::Path;

/// Kinds of a set, in their order and again from the first.
const MIX: [&str; 8] = ["strokes", "random", "jolts", "strokes", "sweep", "random", "strokes", "jolts"];

/// Scales that are tried, the strongest first.
const STRENGTHS: [f64; 13] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.15];

/// Highest crest of the reduced model, in radii of the glass and in distances from the fill to the rim. Water keeps to the glass
/// at 0.25 and throws particles over the rim at 0.3, blood keeps to it at 0.3.
const CREST: [f64; 2] = [0.75, 0.65];

/// Factors by which a measured motion is simulated again: as it was, and stronger.
const AGAIN: [f64; 2] = [1.0, 1.3];

/// Strength of the mix over that of the measured motions.
const STRONGER: f64 = 1.3;

/// Set of simulated recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetName {
    /// Weights are learnt from it.
    Training,
    /// Choices are made and intervals are measured by it.
    Validation,
    /// Nothing is chosen by it.
    HeldOut,
}

impl SetName {
    /// All sets.
    pub const ALL: [Self; 3] = [Self::Training, Self::Validation, Self::HeldOut];

    /// Name in files and messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Training => "train",
            Self::Validation => "val",
            Self::HeldOut => "held",
        }
    }

    /// First seed of the set's motions.
    fn first_seed(self) -> u64 {
        match self {
            Self::Training => 1,
            Self::Validation => 101,
            Self::HeldOut => 1001,
        }
    }
}

/// One recording that is to be simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedRecording {
    /// Set that it belongs to.
    pub set: SetName,
    /// Motion, as the command line spells it.
    pub motion: String,
    /// Name of its file without the ending.
    pub name: String,
}

/// Returns the `count` scripted recordings of `set` at `strength`.
pub(crate) fn scripted(set: SetName, count: usize, strength: f64) -> Vec<SimulatedRecording> {
    let one = |k: usize| {
        let kind = MIX[k % MIX.len()];
        let before = (0..k).filter(|n| MIX[n % MIX.len()] == kind).count() as u64;
        let motion = format!("{kind}:{}x{strength}", set.first_seed() + before);
        let name = format!("{}-{}", set.name(), motion.replace(':', "-"));
        SimulatedRecording { set, motion, name }
    };
    (0..count).map(one).collect()
}

/// Returns the measured motion of `drive` in `folder`, as it was and stronger, as training recordings: at most `most` of them.
///
/// # Errors
/// [`RelearnError::File`], when a motion cannot be written.
pub(crate) fn measured(
    drives: &[(String, &Drive)],
    seconds: f64,
    folder: &Path,
    most: usize,
) -> Result<Vec<SimulatedRecording>, RelearnError> {
    let mut all = Vec::new();
    for factor in AGAIN {
        for (name, drive) in drives {
            let factor = factor.min(meniscus_data::motion::REACH_M / farthest(drive).max(1e-6)).max(0.0);
            let path = folder.join(format!("{name}-x{factor:.2}.csv"));
            let frames = (seconds / FRAME_INTERVAL_S).ceil() as usize;
            let row = |n: usize| {
                let time_s = n as f64 * FRAME_INTERVAL_S;
                format!("{time_s:.6}, {:.7}\n", factor * drive.at(time_s).3)
            };
            let text: String = std::iter::once("t, x_m\n".into()).chain((0..frames).map(row)).collect();
            meniscus_platform::files::write_whole(&path, text.as_bytes())?;
            let name = format!("{}-{name}-x{factor:.2}", SetName::Training.name());
            let motion = path.to_string_lossy().into_owned();
            all.push(SimulatedRecording { set: SetName::Training, motion, name });
        }
    }
    all.truncate(most);
    Ok(all)
}

/// Returns the largest travel of `drive`, m.
fn farthest(drive: &Drive) -> f64 {
    drive.place_m.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Returns the scale of the mix for `liquid` in `glass`: as strong as it stays in the glass, and not far stronger than `drives`,
/// if there are any.
///
/// # Errors
/// [`RelearnError::Motion`].
pub(crate) fn strength(
    liquid: &Liquid,
    glass: &Glass,
    seconds: f64,
    drives: &[(String, &Drive)],
) -> Result<f64, RelearnError> {
    let largest = largest_strength(liquid, glass, seconds)?;
    if drives.is_empty() {
        return Ok(largest);
    }
    let mix = of_mix(seconds, 1.0)?;
    let of_mix = rms(mix.iter());
    let of_drives = rms(drives.iter().map(|(_, drive)| *drive));
    let wanted = STRONGER * of_drives / of_mix.max(1e-9);
    let shortest = STRENGTHS[STRENGTHS.len() - 1];
    Ok(STRENGTHS.into_iter().rev().find(|scale| *scale >= wanted).unwrap_or(1.0).clamp(shortest, largest))
}

/// Returns the largest scale at which the reduced model of `liquid` keeps the crests of the mix in `glass`.
///
/// # Errors
/// [`RelearnError::Motion`].
pub fn largest_strength(liquid: &Liquid, glass: &Glass, seconds: f64) -> Result<f64, RelearnError> {
    let limit_m = (CREST[0] * glass.radius_m).min(CREST[1] * (glass.rim_m - glass.fill_m));
    for scale in STRENGTHS {
        let drives = of_mix(seconds, scale)?;
        if drives.iter().all(|drive| crest_m(liquid, glass, drive, seconds) <= limit_m) {
            return Ok(scale);
        }
    }
    Ok(STRENGTHS[STRENGTHS.len() - 1])
}

/// Returns the motions of one round of the mix at `scale`.
fn of_mix(seconds: f64, scale: f64) -> Result<Vec<Drive>, RelearnError> {
    let planned = scripted(SetName::Training, 2 * MIX.len(), scale);
    let drive = |one: &SimulatedRecording| Ok(drive_of(&Motion::parse(&one.motion, seconds)?, seconds));
    planned.iter().map(drive).collect()
}

/// Root mean square of the acceleration along x of `drives`, m/s2.
fn rms<'a>(drives: impl Iterator<Item = &'a Drive>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for drive in drives {
        sum += drive.along_m_s2.iter().map(|a| a[0] * a[0]).sum::<f64>();
        count += drive.along_m_s2.len() as f64;
    }
    (sum / count.max(1.0)).sqrt()
}

/// Highest crest over the fill that the reduced model predicts, m.
fn crest_m(liquid: &Liquid, glass: &Glass, drive: &Drive, seconds: f64) -> f64 {
    let frames = (seconds / FRAME_INTERVAL_S).round() as usize;
    let record = Record {
        name: String::new(),
        interval_s: FRAME_INTERVAL_S,
        channels: vec![Channel { quantity: Quantity::Peak, value: vec![None; frames] }],
        drive: drive.clone(),
        rest_frames: 0,
    };
    let known = Known {
        radius_m: glass.radius_m,
        radius_error_m: CALLIPERS_M,
        fill_m: glass.fill_m,
        density_kg_m3: liquid.density_kg_m3,
        // Of a liquid with a yield stress the viscosity while it flows: at a rate of the slosh.
        viscosity_pa_s: liquid.rheology.viscosity(SLOSH_RATE),
        motion_share: [1.0; 2],
    };
    let theta = Calibration::blind(std::slice::from_ref(&record), 0.0).mean;
    let predicted = predict(&record, &known, &theta, 0.0, &[]);
    predicted.iter().flatten().fold(0.0, |most: f64, z| most.max(*z))
}

/// Rate of shear in a lively slosh, 1/s.
const SLOSH_RATE: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::scene_file::GLASS;
    use std::collections::BTreeSet;

    #[test]
    fn sets_share_no_motion_and_all_can_be_drawn() {
        let sets = SetName::ALL.map(|set| scripted(set, 16, 0.25));
        let all: Vec<_> = sets.iter().flatten().collect();
        let motions: BTreeSet<_> = all.iter().map(|one| &one.motion).collect();
        let names: BTreeSet<_> = all.iter().map(|one| &one.name).collect();
        assert_eq!((motions.len(), names.len()), (48, 48), "{motions:?}");
        for one in all {
            Motion::parse(&one.motion, 4.0).expect("a motion");
        }
    }

    #[test]
    fn thin_liquids_are_moved_less() {
        let of = |name: &str| {
            let liquid = Liquid::load(name).expect("known");
            let scale = largest_strength(&liquid, &GLASS, 4.0).expect("motions");
            for at in [0.25, 0.3, 0.4, 1.0] {
                let drives = of_mix(4.0, at).expect("motions");
                let crest = drives.iter().map(|d| crest_m(&liquid, &GLASS, d, 4.0)).fold(0.0, f64::max);
                println!("{name} at {at}: {:.1} mm; largest {scale}", 1e3 * crest);
            }
            scale
        };
        // Found by simulation: docs of the shipped model and of the study of corrected liquids.
        assert_eq!(of("glycerine"), 1.0);
        assert!((0.2..=0.25).contains(&of("water")), "water spills at 0.3");
        assert!(of("blood") < 0.4, "blood spills at 0.4");
        assert!((0.3..=0.6).contains(&of("butter")));
    }
}
