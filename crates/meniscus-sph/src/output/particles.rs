//! The particles themselves, frame by frame, for whoever wants more than the tracers.
//!
//! One safetensors file (as recordings, so that numpy, Julia and Rust open it in one call):
//! `position_m`, `velocity_m_s` `[frames, particles, 3]`, `pressure_pa`, `heat_j_kg` `[frames, particles]`,
//! all `f32`, and `mass_kg` `[particles]`. They are the states at the frames, not filtered in time. A particle that left over the rim
//! is not a number from then on.

use crate::Simulator;
use meniscus_platform::files::{FileError, write_whole};
use safetensors::tensor::{Dtype, TensorView};
use std::path::Path;

/// Particles of every frame so far.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    position: Vec<f32>,
    velocity: Vec<f32>,
    pressure: Vec<f32>,
    heat: Vec<f32>,
    mass: Vec<f32>,
    frames: usize,
}

impl Particles {
    /// Appends the present state.
    pub fn take(&mut self, simulator: &Simulator) {
        let fluid = &simulator.fluid;
        if self.frames == 0 {
            self.mass = fluid.mass.iter().map(|&m| m as f32).collect();
        }
        let particles = self.mass.len();
        let first = self.frames * particles;
        self.frames += 1;
        let all = self.frames * particles;
        [&mut self.position, &mut self.velocity].into_iter().for_each(|v| v.resize(3 * all, f32::NAN));
        [&mut self.pressure, &mut self.heat].into_iter().for_each(|v| v.resize(all, f32::NAN));
        for ((p, heat), number) in fluid.particle.iter().zip(&fluid.heat).zip(&simulator.number) {
            let at = first + *number as usize;
            self.position[3 * at..3 * at + 3].copy_from_slice(&p.x.map(|x| x as f32));
            self.velocity[3 * at..3 * at + 3].copy_from_slice(&p.v.map(|v| v as f32));
            self.pressure[at] = p.p as f32;
            self.heat[at] = *heat as f32;
        }
    }

    /// Frames taken so far.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`FileError`], when the disk refuses.
    pub fn save(&self, path: &Path) -> Result<(), FileError> {
        let (frames, particles) = (self.frames, self.mass.len());
        let bytes = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let tensors = [
            ("position_m", vec![frames, particles, 3], bytes(&self.position)),
            ("velocity_m_s", vec![frames, particles, 3], bytes(&self.velocity)),
            ("pressure_pa", vec![frames, particles], bytes(&self.pressure)),
            ("heat_j_kg", vec![frames, particles], bytes(&self.heat)),
            ("mass_kg", vec![particles], bytes(&self.mass)),
        ];
        let views = tensors.iter().map(|(name, shape, bytes)| {
            let view =
                TensorView::new(Dtype::F32, shape.clone(), bytes).expect("as many bytes as the shape says");
            (*name, view)
        });
        let file = safetensors::serialize(views, None).expect("the names differ and the shapes fit");
        write_whole(path, &file)
    }
}
