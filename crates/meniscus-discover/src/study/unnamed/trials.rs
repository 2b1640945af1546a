//! Trials of the drawn law: what is hidden, in which glass, with which library.

use super::laws::{CALIBRATION as CALIBRATION_LAWS, HiddenLaw, JUDGED};
use serde::{Deserialize, Serialize};

/// Viscosity of the liquid in question, Pa s.
pub(super) const VISCOSITY_PA_S: f64 = 0.2;

/// Sizes at which each law is hidden, and the number of clean glasses.
const JUDGED_SIZES: [f64; 2] = [0.95, 0.65];
const CALIBRATION_SIZES: [f64; 2] = [1.0, 0.6];
const CLEAN: u64 = 12;

/// Group of trials with one purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Purpose {
    /// Law that is judged.
    Judged,
    /// Law on which bands are calibrated.
    Calibration,
    /// Nothing is hidden.
    Clean,
    /// An effect of the library is hidden.
    Named,
}

/// Library that a trial is judged with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Library {
    /// All effects but those that are the same law as the hidden one.
    Whole,
    /// Only view, clocks and motion of the glass: no formula of a force in the liquid.
    WithoutForces,
}

/// One trial.
#[derive(Clone, Copy, Debug)]
pub struct LawTrial {
    /// Purpose.
    pub purpose: Purpose,
    /// Hidden law.
    pub law: Option<HiddenLaw>,
    /// Library.
    pub library: Library,
    /// Viscosity of the glass, Pa s; stated is the reference's.
    pub viscosity_pa_s: f64,
    /// Factor of the motion of the glass over the stated one.
    pub gain: f64,
    /// Seed of the glass and of the noise.
    pub seed: u64,
}

/// Viscosities of the glasses, Pa s, and gains of the motion that hide an effect of the library.
const NAMED: [(f64, f64); 4] = [(0.27, 1.0), (0.15, 1.0), (0.2, 1.1), (0.2, 0.92)];

/// First seeds of the trials by purpose, and of the second size of the calibration. Those of the judged trials were set
/// last, after prior and factors.
const JUDGED_SEED: u64 = 27_000;
const CALIBRATION_SEEDS: [u64; 2] = [1024, 1054];
const CLEAN_SEED: u64 = 8000;
const NAMED_SEED: u64 = 9000;

/// Returns all trials.
#[must_use]
pub fn law_trials() -> Vec<LawTrial> {
    let plain = |purpose: Purpose, law: Option<HiddenLaw>, library: Library, seed: u64| LawTrial {
        purpose,
        law,
        library,
        viscosity_pa_s: VISCOSITY_PA_S,
        gain: 1.0,
        seed,
    };
    let mut out = Vec::new();
    for size in JUDGED_SIZES {
        for library in [Library::Whole, Library::WithoutForces] {
            for law in JUDGED {
                let seed = JUDGED_SEED + out.len() as u64;
                out.push(plain(Purpose::Judged, Some(HiddenLaw { size, ..law }), library, seed));
            }
        }
    }
    for (size, first) in CALIBRATION_SIZES.into_iter().zip(CALIBRATION_SEEDS) {
        for (seed, law) in (first..).zip(CALIBRATION_LAWS) {
            let law = Some(HiddenLaw { size, ..law });
            out.push(plain(Purpose::Calibration, law, Library::WithoutForces, seed));
        }
    }
    out.extend((0..CLEAN).map(|i| plain(Purpose::Clean, None, Library::Whole, CLEAN_SEED + i)));
    for (seed, (viscosity_pa_s, gain)) in (NAMED_SEED..).zip(NAMED) {
        let plain = plain(Purpose::Named, None, Library::Whole, seed);
        out.push(LawTrial { viscosity_pa_s, gain, ..plain });
    }
    out
}
