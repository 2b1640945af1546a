//! Noise of the rendered D435 on a profile.
//!
//! ```text
//! z_i = h_i + n_i + b0 + b1 s_i + b2 (s_i^2 - 1/2)        n white, b a first-order random process of 0.2 s
//! ```
//! The levels are those that the model's training takes for the rendered camera at 0.4 m, measured on recordings: 0.12 mm for each
//! point, 0.1 mm for each term of the smooth bias, 0.01 mm of the position of the glass.

use meniscus::surface::{POINTS, SurfaceProfile, profile_abscissa};
use meniscus::units::{FRAME_INTERVAL_S, Micros};
use meniscus_numerics::random::normal;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Standard deviation of each height, m.
const WHITE_M: f64 = 1.2e-4;
/// Standard deviation of each term of the smooth bias, m.
const BIAS_M: f64 = 1e-4;
/// Standard deviation of the position of the glass, m.
const GLASS_M: f64 = 1e-5;
/// Time over which the bias holds, s.
const BIAS_S: f64 = 0.2;

/// A camera with its own noise.
#[derive(Clone, Debug)]
pub struct Camera {
    random: ChaCha8Rng,
    bias_m: [f64; 3],
    frame: u32,
}

impl Camera {
    /// A camera whose noise belongs to `seed`.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x00ca_3e7a);
        let bias_m = std::array::from_fn(|_| BIAS_M * normal(&mut random));
        Self { random, bias_m, frame: 0 }
    }

    /// Returns the profile of true heights and a glass at `glass_x_m`, with noise.
    pub fn see(&mut self, heights_m: &[f32; POINTS], glass_x_m: f64) -> SurfaceProfile {
        let keep = (-FRAME_INTERVAL_S / BIAS_S).exp();
        let fresh = BIAS_M * (1.0 - keep * keep).sqrt();
        for bias in &mut self.bias_m {
            *bias = keep * *bias + fresh * normal(&mut self.random);
        }
        let [level, tilt, bow] = self.bias_m;
        let height_m = std::array::from_fn(|i| {
            let s = profile_abscissa(i);
            let bias = level + tilt * s + bow * (s * s - 0.5);
            (f64::from(heights_m[i]) + bias + WHITE_M * normal(&mut self.random)) as f32
        });
        self.frame += 1;
        SurfaceProfile {
            height_m,
            variance_m2: [(WHITE_M * WHITE_M + BIAS_M * BIAS_M) as f32; POINTS],
            valid: [true; POINTS],
            glass_x_m: Some((glass_x_m + GLASS_M * normal(&mut self.random)) as f32),
            sequence: self.frame,
            captured: Micros((f64::from(self.frame) * FRAME_INTERVAL_S * 1e6) as u64),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_noise_has_the_stated_size_and_repeats() {
        let (mut camera, mut again) = (Camera::new(4), Camera::new(4));
        let errors: Vec<f64> = (0..400)
            .flat_map(|_| {
                let profile = camera.see(&[0.07; POINTS], 0.0);
                assert_eq!(profile, again.see(&[0.07; POINTS], 0.0));
                profile.height_m.map(|z| f64::from(z) - 0.07)
            })
            .collect();
        let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!((1.4e-4..2.2e-4).contains(&rms), "{rms}");
    }
}
