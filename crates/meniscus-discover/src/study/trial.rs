//! One trial as the workflow gets it: a folder of profiles and motions with a neutral name.
//!
//! Effects that the simulator does not carry are applied by the study: those of the camera to the profiles, those of the
//! actuation to the stated motion.

use super::truth::{DENSITY_KG_M3, Truth};
use crate::study::motions::motions;
use meniscus::reduced::effects::{Effect, Port, Slot, View};
use meniscus::surface::{SurfaceProfile, profile_abscissa};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_data::profiles::{profiles_from_csv, profiles_to_csv};
use meniscus_data::recording::frame_of;
use meniscus_data::scene_file::GLASS;
use meniscus_platform::files::write_whole;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// Effect that the study applies to profiles or motion itself.
#[derive(Clone, Copy)]
pub struct Hand {
    /// The effect.
    pub effect: &'static Effect,
    /// Its first coordinate in the reduced model.
    pub value: f64,
}

impl PartialEq for Hand {
    fn eq(&self, other: &Self) -> bool {
        (self.effect.kind, self.value) == (other.effect.kind, other.value)
    }
}

impl std::fmt::Debug for Hand {
    /// Writes name and value, which go into the digest of a plan.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("").field(&self.effect.name).field(&self.value).finish()
    }
}

/// Changes that the study makes to profiles and to the stated motion.
#[derive(Clone, Copy, Debug, Default)]
struct Faults {
    view: View,
    /// Gain of the stated motion and its delay, s.
    port: Port,
}

/// Glass, effects and stated liquid of one trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The glass.
    pub truth: Truth,
    /// Effects that the study applies itself.
    pub hands: Vec<Hand>,
    /// Viscosity stated to the workflow, Pa s.
    pub stated_viscosity_pa_s: f64,
    /// Seed of the camera's noise.
    pub seed: u64,
}

impl Trial {
    /// Writes the folder at `path` with the motions `wanted`, named a, b, c, ... from `first` on; files
    /// that exist are kept.
    ///
    /// # Errors
    /// In words, when the cache lacks a recording or a file cannot be written.
    pub fn write(&self, path: &Path, cache: &Path, wanted: &[usize], first: u8) -> Result<(), String> {
        let faults = self.faults()?;
        let file = |name: String, text: &str| {
            write_whole(&path.join(name), text.as_bytes()).map_err(|error| format!("{error}"))
        };
        file(
            "setup.toml".into(),
            &format!(
                "radius_m = {}\nfill_m = {}\ndensity_kg_m3 = {DENSITY_KG_M3:.1}\nviscosity_pa_s = {}\n",
                GLASS.radius_m, GLASS.fill_m, self.stated_viscosity_pa_s
            ),
        )?;
        wanted.par_iter().enumerate().try_for_each(|(place, motion)| {
            let name = char::from(first + place as u8);
            let seen = self.profiles(cache, *motion)?;
            file(format!("{name}.profile.csv"), &profiles_to_csv(&viewed(&seen, &faults.view)))?;
            let samples = motions(self.truth.kind)[*motion].samples();
            file(format!("{name}.motion.csv"), &stated(&samples, &faults.port))
        })
    }

    /// Returns the profiles of a motion before any fault. They lie beside the glasses, because many trials differ only in
    /// the effects that the study applies itself.
    fn profiles(&self, cache: &Path, motion: usize) -> Result<Vec<Option<SurfaceProfile>>, String> {
        let seed = self.seed.wrapping_mul(1000).wrapping_add(motion as u64);
        let path = cache.join(format!("seen/{}-{motion}-{seed}.csv", self.truth.digest()));
        if !path.exists() {
            let recording = self.truth.recording(cache, motion)?;
            let scene = SceneSettings { seed, ..SceneSettings::default() };
            let seen = sightings(&recording, scene).map_err(|error| format!("{error:?}"))?;
            let seen: Vec<SurfaceProfile> = seen.into_iter().flatten().collect();
            write_whole(&path, profiles_to_csv(&seen).as_bytes()).map_err(|error| format!("{error}"))?;
        }
        let wrong = |why: String| format!("{}: {why}; remove it and run again", path.display());
        let text = std::fs::read_to_string(&path).map_err(|error| wrong(format!("{error}")))?;
        let mut seen = vec![None; motions(self.truth.kind)[motion].frames()];
        for profile in profiles_from_csv(&text).map_err(|error| wrong(format!("{error}")))? {
            if let Some(place) = seen.get_mut(frame_of(profile.captured, START)) {
                *place = Some(profile);
            }
        }
        Ok(seen)
    }

    /// Returns the changes by the effects that the study applies itself.
    ///
    /// # Errors
    /// In words, for an effect that acts in the liquid or on the glass, which only the simulator carries.
    fn faults(&self) -> Result<Faults, String> {
        let mut faults = Faults::default();
        for Hand { effect, value } in &self.hands {
            let mut values = effect.neutral();
            values[0] = *value;
            match effect.slot {
                Slot::View(change) => change(&values, &mut faults.view),
                Slot::Port(change) => change(&values, &mut faults.port),
                Slot::Stiffness(_)
                | Slot::FirstMode(_)
                | Slot::Liquid(_)
                | Slot::Line(_)
                | Slot::Memory(_)
                | Slot::Catch(_)
                | Slot::Vessel(_) => return Err(format!("{} acts in the liquid: simulate it", effect.name)),
            }
        }
        let Port { gain, delay_s, .. } = faults.port;
        if faults.port != (Port { gain, delay_s, ..Port::default() }) {
            return Err("an inclination or a lift acts on the glass: simulate it".into());
        }
        Ok(faults)
    }
}

/// Returns the profiles of a camera with the faults `view`.
fn viewed(seen: &[Option<SurfaceProfile>], view: &View) -> Vec<SurfaceProfile> {
    let View { latency_s, scale, pitch_rad: pitch, slope_rad: slope } = *view;
    let late = (latency_s / FRAME_INTERVAL_S).round() as usize;
    let mut out = Vec::new();
    for n in 0..seen.len() {
        let Some(mut profile) = seen[n.saturating_sub(late)] else { continue };
        profile.sequence = n as u32;
        profile.captured.0 = START.0 + (n as f64 * FRAME_INTERVAL_S * 1e6).round() as u64;
        profile.glass_x_m = profile.glass_x_m.map(|x| (scale * f64::from(x)) as f32);
        for (i, z) in profile.height_m.iter_mut().enumerate() {
            let s = profile_abscissa(i);
            let bow = pitch * GLASS.radius_m * (1.0 - (1.0 - s * s).sqrt());
            *z = (scale * f64::from(*z) + bow + slope.tan() * GLASS.radius_m * s) as f32;
        }
        out.push(profile);
    }
    out
}

/// Returns the motion file for the workflow of a glass on the path `samples`.
fn stated(samples: &[(f64, f64)], port: &Port) -> String {
    let (gain, delay) = (port.gain, port.delay_s);
    let mut text = String::from("t,x_m\n");
    for (t, x) in samples {
        if t - delay >= -1e-9 {
            // Writing into a string cannot fail.
            let _ = writeln!(text, "{:.6},{:.9}", t - delay, x / gain);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::cases::hidden;
    use crate::study::motions::MotionKind;
    use meniscus::reduced::effects::EffectKind;

    #[test]
    fn every_hidden_effect_that_the_simulator_lacks_is_put_in_by_hand() {
        let trial = |hands: Vec<Hand>| {
            let truth = hidden().next().expect("one is hidden").truth(1.0, 7, MotionKind::Single);
            Trial { truth, hands, stated_viscosity_pa_s: 0.2, seed: 1 }
        };
        for hidden in hidden().filter(|hidden| !hidden.is_simulated()) {
            let hand = Hand { effect: hidden.effect, value: hidden.value(1.0) };
            let Faults { view, port } = trial(vec![hand]).faults().expect("it can be put in");
            assert!(view != View::default() || port != Port::default(), "{hand:?} changes nothing");
        }
        let foam = Hand { effect: EffectKind::Foam.effect(), value: 0.1 };
        assert_eq!(format!("{foam:?}"), "(\"foam\", 0.1)");
        assert!(trial(vec![foam]).faults().expect_err("in the liquid").contains("foam acts in the liquid"));
        let tilt = Hand { effect: EffectKind::ContainerTilt.effect(), value: 0.1 };
        assert!(trial(vec![tilt]).faults().is_err());
    }
}
