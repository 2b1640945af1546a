//! Recordings as VTK files: what ParaView, PyVista and VisIt read.
//!
//! ```text
//! FOLDER/tracers.pvd     times and names of FOLDER/tracers-0000.vtp, ...     points: the 2134 tracers
//! FOLDER/surface.pvd     times and names of FOLDER/surface-0000.vtp, ...     triangles: the free surface
//! FOLDER/particles.pvd   the same of a file of particles, where one is given
//! ```
//! Positions are those in the room: the glass, its inclination about its pivot included, moves. Lengths are metres, all values SI
//! units. Each file is written whole or not at all, and the collections last: an interrupted export has none.

mod particles;
mod poly_data;
mod room;
mod surface_mesh;
mod tracers;

pub use particles::{ParticleFile, write_particles};

use crate::recording::{Lattice, Recording, STATE};
use meniscus::units::FRAME_INTERVAL_S;
use meniscus_platform::files::{FileError, write_whole};
use std::fmt::Write;
use std::path::Path;

/// Frames that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selected {
    /// One frame of so many, from the first on; 1 takes all.
    pub every: usize,
}

impl Selected {
    /// Returns the numbers of the frames of `frames` that are written.
    #[must_use]
    pub fn of(self, frames: usize) -> Vec<usize> {
        (0..frames).step_by(self.every.max(1)).collect()
    }
}

/// Writes the tracers and the surface of `recording` into `folder` and returns the number of frames written. `watch` gets that
/// number after each; where it returns `false` the export ends, without collections.
///
/// # Errors
/// [`FileError`], when the disk refuses.
pub fn write(
    recording: &Recording,
    folder: &Path,
    selected: Selected,
    watch: &mut dyn FnMut(usize) -> bool,
) -> Result<usize, FileError> {
    let lattice = Lattice::new(&recording.glass);
    let triangles = surface_mesh::triangles();
    let frames = selected.of(recording.frames());
    let mut state = vec![0.0; STATE];
    for (done, &frame) in frames.iter().enumerate() {
        recording.state(frame, &mut state);
        let pose = room::Pose::of(recording, frame);
        let tracers = tracers::tracers(recording, &lattice, frame, &state, &pose);
        write_whole(&folder.join(file_name("tracers", frame)), &tracers.to_vtp())?;
        let surface = surface_mesh::surface(recording, &lattice, frame, &pose, &triangles);
        write_whole(&folder.join(file_name("surface", frame)), &surface.to_vtp())?;
        if !watch(done + 1) {
            return Ok(done + 1);
        }
    }
    for name in ["tracers", "surface"] {
        write_collection(folder, name, &frames)?;
    }
    Ok(frames.len())
}

/// Name of the file of `frame`.
fn file_name(name: &str, frame: usize) -> String {
    format!("{name}-{frame:04}.vtp")
}

/// Writes the collection of the files called `name`, with their times.
fn write_collection(folder: &Path, name: &str, frames: &[usize]) -> Result<(), FileError> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for &frame in frames {
        let time_s = frame as f64 * FRAME_INTERVAL_S;
        // Writing into a string cannot fail.
        let _ = writeln!(
            text,
            "<DataSet timestep=\"{time_s}\" group=\"\" part=\"0\" file=\"{}\"/>",
            file_name(name, frame)
        );
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    write_whole(&folder.join(format!("{name}.pvd")), text.as_bytes())
}

#[cfg(test)]
mod tests;
