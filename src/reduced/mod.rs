//! The reduced slosh model: an upright cylinder's first modes as a GENERIC system, driven through a port.
//!
//! ```text
//! state    a_i, v_i (height at the wall, its rate), z_i (what an effect remembers), heat
//! energy   E = sum m_i (v_i^2 + w_i^2 a_i^2)/2 + what effects store + heat,      entropy S = heat/T
//! motion   a_i' = v_i,   m_i v_i' = -dE/da_i - G v_i + m_i k_i tanh(k_i h) b_i f
//! heat'    = v.G v >= 0                                  for any friction G(s) >= 0
//! ```
//! `f` is the specific force along the surface that the moved glass leaves to the liquid: the port. One
//! step is implicit in the middle, so energy is exact against the port's work and entropy cannot fall.
//!
//! | file | purpose |
//! |---|---|
//! | `modes` | wave numbers, masses, frequencies and forcing of the modes (1,n), (0,n), (2,n) |
//! | `boundary_layer` | friction of boundary layers, film and bulk, for any generalised Newtonian liquid |
//! | `finite_layer` | what a layer that is not thin, and a held contact line, add to that |
//! | `wall_impedance` | layer at a wall with slip, of a viscoelastic liquid |
//! | `speed_table` | a number that depends on the amplitude of a speed |
//! | `baseline` | calibration of the plain model |
//! | [`effects`] | physical differences from the plain liquid |
//! | `mode_coefficients` | coefficients of a mode (1,n) under the effects |
//! | `coupling` | forcing of another wave by the first mode |
//! | `drawn_law` | an unnamed force on the first mode, as two curves |
//! | `contact_line_friction` | action of a held or sliding contact line on the second-order waves |
//! | `bound_waves` | second-order waves and their step |
//! | `bound_wave_coefficients` | coefficients of the second-order waves under the effects |
//! | `model` | modes, second order and effects together |
//! | `step` | one step in time |
//! | `field` | surface and velocity anywhere: potential flow |
//!
//! Waves of azimuthal order one come in two directions, along x and y of the glass.

mod baseline;
mod bound_wave_coefficients;
mod bound_waves;
mod boundary_layer;
#[cfg(test)]
mod bulk_rate_tests;
mod contact_line_friction;
mod coupling;
mod drawn_law;
pub mod effects;
mod field;
mod finite_layer;
mod mode_coefficients;
mod model;
mod modes;
mod speed_table;
mod step;
#[cfg(test)]
mod tests;
mod wall_impedance;

pub use baseline::Baseline;
pub use bound_waves::BoundWaveState;
pub use boundary_layer::Rheology;
pub use contact_line_friction::SECTORS;
pub use drawn_law::{DrawnLaw, LAW_HEIGHTS, LAW_RATES, LawTables};
pub use field::{surface, velocity, wall_harmonics};
pub use model::ReducedModel;
pub use modes::{BOUND_WAVE_SHAPES, Cylinder, RADIAL, SloshMode, Wave};
pub(crate) use speed_table::SpeedTable;
pub use step::{EnergyBalance, Forcing, ReducedState, step};
pub use wall_impedance::Maxwell;
