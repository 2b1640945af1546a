//! The tracers of one frame: points with the fields that the recording knows.

use super::poly_data::{Cells, PointArray, PolyData};
use super::room::Pose;
use crate::recording::{COLUMNS, GROUP_COMPONENTS, LAYERS, Lattice, Recording, TRACERS, group_range};
use meniscus::blob::FieldGroup;
use meniscus::units::FRAME_INTERVAL_S;

/// Names of the field groups behind the positions, in file order.
const ARRAYS: [(FieldGroup, &str); 4] = [
    (FieldGroup::Velocity, "velocity_m_s"),
    (FieldGroup::InternalEnergy, "internal_energy_j_kg"),
    (FieldGroup::NormalStress, "normal_stress_pa"),
    (FieldGroup::ShearStress, "shear_stress_pa"),
];

/// Returns the tracers of `frame` with its full `state`. Positions are in the room; vectors and stresses stay in the axes of the glass, in
/// which the simulator has them (velocities are relative to the glass).
pub(super) fn tracers(
    recording: &Recording,
    lattice: &Lattice,
    frame: usize,
    state: &[f32],
    pose: &Pose,
) -> PolyData<'static> {
    let known = recording.known;
    let place = |tracer: usize| {
        let column = tracer / LAYERS;
        if known.contains(FieldGroup::Position) {
            let q = &state[3 * tracer..3 * tracer + 3];
            return pose.place([q[0], q[1], q[2]].map(f64::from));
        }
        let surface_m = f64::from(recording.column_m[frame * COLUMNS + column]);
        pose.place(lattice.tracer(column, tracer % LAYERS, surface_m))
    };
    let mut arrays = Vec::new();
    for (group, name) in ARRAYS {
        if known.contains(group) {
            let index = group as usize;
            let values = state[group_range(index)].to_vec();
            arrays.push(PointArray { name, components: GROUP_COMPONENTS[index], values });
        }
    }
    PolyData {
        points: (0..TRACERS).map(place).collect(),
        cells: Cells::Vertices,
        arrays,
        time_s: frame as f64 * FRAME_INTERVAL_S,
    }
}
