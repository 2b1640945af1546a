//! Recordings for other programs.

use crate::errors::{check_range, refused, system};
use crate::recording::Recording;
use meniscus_data::vtk::{Selected, write};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Writes a recording as VTK files for ParaView, PyVista and VisIt: one `tracers-NNNN.vtp` and one `surface-NNNN.vtp` a frame, and the
/// collections `tracers.pvd` and `surface.pvd` with their times. `meniscus export` does the same.
///
/// Tracers are points with the fields that the recording knows: `velocity_m_s`, `internal_energy_j_kg`, `normal_stress_pa` and
/// `shear_stress_pa`. The surface is a mesh of triangles with `height_m`. Positions are in the room, in metres.
///
/// Args:
///     recording: The recording.
///     folder: Folder for the files; it is made, and has to be empty.
///     every: Takes one frame of so many.
///
/// Returns:
///     The number of frames that were written.
#[pyfunction]
#[pyo3(signature = (recording, folder, *, every=1))]
pub(crate) fn export_vtp(
    py: Python<'_>,
    recording: &Recording,
    folder: PathBuf,
    every: usize,
) -> PyResult<usize> {
    check_range("every", &every, 1..=100_000)?;
    if folder.read_dir().is_ok_and(|mut entries| entries.next().is_some()) {
        return Err(refused(format!("{} is not empty: choose another folder", folder.display())));
    }
    let selected = Selected { every };
    py.detach(|| write(&recording.recorded, &folder, selected, &mut |_| true)).map_err(system)
}
