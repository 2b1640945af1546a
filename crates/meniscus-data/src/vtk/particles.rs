//! Particles of the simulator (`meniscus simulate --particles`) as VTK files.

use super::poly_data::{Cells, PointArray, PolyData};
use super::room::Pose;
use super::{Selected, file_name, write_collection};
use crate::recording::{Recording, StoreError, f32s, read_file, rows};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_platform::files::{FileError, write_whole};
use safetensors::tensor::SafeTensors;
use std::path::Path;

/// Particles of all frames, as the simulator writes them.
#[derive(Clone, Debug)]
pub struct ParticleFile {
    frames: usize,
    particles: usize,
    position: Vec<f32>,
    velocity: Vec<f32>,
    pressure: Vec<f32>,
    heat: Vec<f32>,
}

impl ParticleFile {
    /// Reads the file at `path`; every type and shape is checked.
    ///
    /// # Errors
    /// When it cannot be read or holds no particles.
    pub fn load(path: &Path) -> Result<Self, StoreError> {
        let bytes = read_file(path).map_err(|error| StoreError::Io(path.into(), error))?;
        parse(&bytes).map_err(|why| {
            StoreError::Malformed(
                path.into(),
                format!("it should hold particles of `simulate --particles`, but {why}"),
            )
        })
    }
}

fn parse(bytes: &[u8]) -> Result<ParticleFile, String> {
    let file = SafeTensors::deserialize(bytes).map_err(|error| format!("{error}"))?;
    let particles = f32s(&file, "mass_kg", None)?.len();
    let frames = rows(&file, "pressure_pa");
    Ok(ParticleFile {
        position: f32s(&file, "position_m", Some(&[frames, particles, 3]))?,
        velocity: f32s(&file, "velocity_m_s", Some(&[frames, particles, 3]))?,
        pressure: f32s(&file, "pressure_pa", Some(&[frames, particles]))?,
        heat: f32s(&file, "heat_j_kg", Some(&[frames, particles]))?,
        frames,
        particles,
    })
}

/// Writes `particles`, which were simulated with `recording`, into `folder` and returns the number of frames written. Particles that left over
/// the rim are left out. `watch` is that of [`super::write`].
///
/// # Errors
/// [`FileError`], when the disk refuses.
pub fn write_particles(
    particles: &ParticleFile,
    recording: &Recording,
    folder: &Path,
    selected: Selected,
    watch: &mut dyn FnMut(usize) -> bool,
) -> Result<usize, FileError> {
    let frames = selected.of(particles.frames.min(recording.frames()));
    for (done, &frame) in frames.iter().enumerate() {
        let file = of_frame(particles, &Pose::of(recording, frame), frame);
        write_whole(&folder.join(file_name("particles", frame)), &file.to_vtp())?;
        if !watch(done + 1) {
            return Ok(done + 1);
        }
    }
    write_collection(folder, "particles", &frames)?;
    Ok(frames.len())
}

/// Returns the particles of `frame` that are in the glass.
fn of_frame(all: &ParticleFile, pose: &Pose, frame: usize) -> PolyData<'static> {
    let range = frame * all.particles..(frame + 1) * all.particles;
    let inside: Vec<usize> =
        range.filter(|&k| all.pressure[k].is_finite() && all.position[3 * k].is_finite()).collect();
    let vector = |values: &[f32], k: usize| [values[3 * k], values[3 * k + 1], values[3 * k + 2]];
    let scalars = |values: &[f32]| inside.iter().map(|&k| values[k]).collect();
    let array = |name, components, values| PointArray { name, components, values };
    PolyData {
        points: inside.iter().map(|&k| pose.place(vector(&all.position, k).map(f64::from))).collect(),
        cells: Cells::Vertices,
        arrays: vec![
            array("velocity_m_s", 3, inside.iter().flat_map(|&k| vector(&all.velocity, k)).collect()),
            array("pressure_pa", 1, scalars(&all.pressure)),
            array("heat_j_kg", 1, scalars(&all.heat)),
        ],
        time_s: frame as f64 * FRAME_INTERVAL_S,
    }
}
