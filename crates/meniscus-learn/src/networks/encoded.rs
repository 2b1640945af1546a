//! Training or validation recordings, encoded as the stages need them.

use crate::data::dataset::{Frame, Sequence, known_acceleration};
use crate::data::trajectory::{Path, Track};
use crate::networks::autoencoder::Autoencoder;
use crate::networks::encoder::{Encoder, LabelledSequence};
use crate::networks::noise::{Noise, Seen};
use meniscus::latent::generic::Latent;
use rand_chacha::ChaCha8Rng;

/// Recordings of one side of the split, with their latents.
pub(crate) struct EncodedRecordings {
    /// Projected recordings.
    pub(crate) sequences: Vec<Sequence>,
    /// Latents of every frame.
    pub(crate) latents: Vec<Vec<Latent>>,
    /// The same as trajectories under the known port.
    pub(crate) paths: Vec<Path>,
}

impl EncodedRecordings {
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

    /// Returns the sequences with the latents that the encoder has to give.
    pub(crate) fn labelled(&self) -> Vec<LabelledSequence<'_>> {
        let labelled_sequence = |(sequence, latents)| LabelledSequence { sequence, latents };
        self.sequences.iter().zip(self.latents.iter().map(Vec::as_slice)).map(labelled_sequence).collect()
    }

    /// Returns the readings of the encoder on every sequence, behind a camera with `noise`.
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
