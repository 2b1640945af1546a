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
//! | file | what |
//! |---|---|
//! | `modes` | wave numbers, masses, frequencies, forcing of the modes (1,n), (0,1), (2,1) |
//! | `layer` | friction of boundary layers, film and bulk, for any generalised Newtonian liquid |
//! | `table` | a number that depends on the amplitude |
//! | `model` | modes and effects together: the coefficients of a step |
//! | `step` | one step in time |
//! | `couple` | what the first mode makes of another wave |
//! | `riding` | the waves of second order in a glass with its effects |
//! | `second` | the second-order waves that ride on the first mode |
//! | `rim` | what a held or sliding contact line does to those |
//! | `field` | from the modes to surface and velocity anywhere: potential flow |
//!
//! Waves of azimuthal order one come in two directions, along x and y of the glass.

mod bound_waves;
mod boundary_layer;
mod contact_line_friction;
mod coupling;
pub mod effects;
mod field;
mod model;
mod modes;
mod second_order;
mod speed_table;
mod step;
#[cfg(test)]
mod tests;

pub use boundary_layer::{Rheology, friction};
pub use contact_line_friction::{ContactLineFriction, SECTORS};
pub use coupling::Coupling;
pub use field::{surface, velocity, wall_harmonics};
pub use model::{Baseline, ReducedModel};
pub use modes::{Cylinder, RADIAL, SloshMode, Wave};
pub use second_order::{BOUND_WAVE_SHAPES, BoundWave, BoundWaveState, BoundWaves, FirstModeMotion};
pub use speed_table::SpeedTable;
pub use step::{EnergyBalance, Forcing, ReducedState, step};
