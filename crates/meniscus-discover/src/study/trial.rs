//! One trial as the workflow gets it: a folder of profiles and motions with a neutral name.
//!
//! What the simulator does not carry, the study's hands put in: views act on the profiles, actuation on
//! the stated motion.

use super::truth::{DENSITY_KG_M3, Truth};
use crate::study::motion_plans::courses;
use meniscus::surface::{SurfaceProfile, profile_abscissa};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_bags::{profiles_from_csv, profiles_to_csv};
use meniscus_data::recording::frame_of;
use meniscus_data::scene_file::GLASS;
use meniscus_platform::files::write_whole;
use meniscus_virtual::camera::START;
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use rayon::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// An effect that the hands put in, with its value in the unit of the library.
pub type Hand = (&'static str, f64);

/// What one trial is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// The glass.
    pub truth: Truth,
    /// What the hands put in.
    pub hands: Vec<Hand>,
    /// Viscosity that the workflow is told, Pa s.
    pub stated_viscosity_pa_s: f64,
    /// Seed of the camera's noise.
    pub seed: u64,
}

impl Trial {
    /// Writes the folder at `path` with the courses `wanted`, named a, b, c, ... from `first` on; what is
    /// there already is kept.
    ///
    /// # Errors
    /// In words, when the cache lacks a recording or a file cannot be written.
    pub fn write(&self, path: &Path, cache: &Path, wanted: &[usize], first: u8) -> Result<(), String> {
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
        wanted.par_iter().enumerate().try_for_each(|(place, course)| {
            let name = char::from(first + place as u8);
            let seen = self.seen(cache, *course)?;
            file(format!("{name}.profile.csv"), &profiles_to_csv(&self.viewed(&seen)))?;
            file(format!("{name}.motion.csv"), &self.stated(&courses(self.truth.kind)[*course].samples()))
        })
    }

    /// What the camera saw of a course before any fault; kept beside the glasses, because many trials differ
    /// only in what the hands put in.
    fn seen(&self, cache: &Path, course: usize) -> Result<Vec<Option<SurfaceProfile>>, String> {
        let seed = self.seed.wrapping_mul(1000).wrapping_add(course as u64);
        let path = cache.join(format!("seen/{}-{course}-{seed}.csv", self.truth.digest()));
        if !path.exists() {
            let recording = self.truth.recording(cache, course)?;
            let scene = SceneSettings { seed, ..SceneSettings::default() };
            let seen = sightings(&recording, scene).map_err(|error| format!("{error:?}"))?;
            let seen: Vec<SurfaceProfile> = seen.into_iter().flatten().collect();
            write_whole(&path, profiles_to_csv(&seen).as_bytes()).map_err(|error| format!("{error}"))?;
        }
        let wrong = |why: String| format!("{}: {why}; remove it and run again", path.display());
        let text = std::fs::read_to_string(&path).map_err(|error| wrong(format!("{error}")))?;
        let mut seen = vec![None; courses(self.truth.kind)[course].frames()];
        for profile in profiles_from_csv(&text).map_err(|error| wrong(format!("{error}")))? {
            if let Some(place) = seen.get_mut(frame_of(profile.captured, START)) {
                *place = Some(profile);
            }
        }
        Ok(seen)
    }

    /// The profiles as a camera with the hidden faults gives them.
    fn viewed(&self, seen: &[Option<SurfaceProfile>]) -> Vec<SurfaceProfile> {
        let value = |name: &str, or: f64| self.hands.iter().find(|(n, _)| *n == name).map_or(or, |(_, v)| *v);
        let late = (value("camera_latency", 0.0) / FRAME_INTERVAL_S).round() as usize;
        let (scale, pitch, slope) =
            (value("depth_scale", 1.0), value("camera_pitch", 0.0), value("camera_slope", 0.0));
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

    /// The motion file that the workflow is given for a glass that went through `samples`.
    fn stated(&self, samples: &[(f64, f64)]) -> String {
        let value = |name: &str, or: f64| self.hands.iter().find(|(n, _)| *n == name).map_or(or, |(_, v)| *v);
        let (gain, delay) = (value("actuation_gain", 1.0), value("actuation_delay", 0.0));
        let mut text = String::from("t,x_m\n");
        for (t, x) in samples {
            if t - delay >= -1e-9 {
                // Writing into a string cannot fail.
                let _ = writeln!(text, "{:.6},{:.9}", t - delay, x / gain);
            }
        }
        text
    }
}
