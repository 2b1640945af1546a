//! The training or the validation recordings, as the stages need them.

use crate::data::dataset::{Frame, Sequence, known_acceleration};
use crate::networks::autoencoder::Autoencoder;
use crate::networks::encoder::{Encoder, Lesson};
use crate::networks::noise::{Noise, Seen};
use crate::operators::filter::Track;
use crate::operators::linear::Path;
use meniscus::latent::generic::Latent;
use rand_chacha::ChaCha8Rng;

/// One side of the split, as the stages need it.
pub(crate) struct Side {
    /// What happened.
    pub(crate) sequences: Vec<Sequence>,
    /// Latents of every frame.
    pub(crate) latents: Vec<Vec<Latent>>,
    /// The same as trajectories under the known port.
    pub(crate) paths: Vec<Path>,
}

impl Side {
    /// Encodes `sequences`.
    pub(crate) fn new(sequences: Vec<Sequence>, autoencoder: &Autoencoder, frame: &Frame) -> Self {
        let latents: Vec<_> = sequences.iter().map(|s| autoencoder.encode(s, frame)).collect();
        let path = |(s, x): (&Sequence, &Vec<Latent>)| {
            let scale = f64::from(frame.acceleration_scale);
            let u = known_acceleration(&s.glass_x_m).iter().map(|a| a / scale).collect();
            let of_scale = |joules: &[f64]| joules.iter().map(|e| e / frame.energy_scale_j).collect();
            Path { x: x.clone(), u, energy: of_scale(&s.energy_j), heat: of_scale(&s.heat_j) }
        };
        let paths = sequences.iter().zip(&latents).map(path).collect();
        Self { sequences, latents, paths }
    }

    /// What the encoder should say.
    pub(crate) fn lessons(&self) -> Vec<Lesson<'_>> {
        let lesson = |(sequence, latents)| Lesson { sequence, latents };
        self.sequences.iter().zip(self.latents.iter().map(Vec::as_slice)).map(lesson).collect()
    }

    /// What the camera and the encoder make of every sequence.
    pub(crate) fn tracks(
        &self,
        frame: &Frame,
        encoder: &Encoder,
        noise: Noise,
        rng: &mut ChaCha8Rng,
    ) -> Vec<Track> {
        let track = |(sequence, truth): (&Sequence, &Vec<Latent>)| {
            let seen = Seen::new(sequence, frame, Some(noise), rng);
            let u = (0..sequence.frames()).map(|n| seen.port(n)).collect();
            let said = encoder.read(&seen);
            let (y, port) = said.into_iter().map(|reading| (reading.latent, reading.port)).unzip();
            Track { y, u, port, truth: truth.clone() }
        };
        self.sequences.iter().zip(&self.latents).map(track).collect()
    }
}
