//! Effects by name: what a liquid or a glass may have beside the plain case, each switched on by one
//! number. Without any of them the simulator computes the same bits as if this folder did not exist.
//!
//! | file | effects | where they act |
//! |---|---|---|
//! | `rheology` | viscosity, shear_thinning, yield_stress | the liquid's stress |
//! | `wall_slip` | wall_slip | friction at the wall |
//! | `columns` | (shared by the next three) | heights of the surface as sums over particles |
//! | `surface_tension` | surface_tension | stored energy of the surface's area |
//! | `contact_line` | contact_line, contact_line_reach | spring and friction along the wall |
//! | `foam` | foam | friction along the wall |
//! | `viscoelastic` | viscoelastic, viscoelastic_time | a stress on every particle |
//! | `glass` | container_tilt, vertical_acceleration, fill | body force and fill |
//!
//! Books: what an effect stores (area, spring, elastic stress) counts into the potential energy, what
//! it dissipates becomes heat of the particles where it acts. Another effect is a line in
//! [`EFFECTS`](meniscus_data::effects::EFFECTS), a field in [`Effects`](meniscus_data::effects::Effects) and its file.

pub(crate) mod acting;
mod columns;
mod contact_line;
mod foam;
mod glass;
mod rheology;
mod surface_tension;
mod viscoelastic;
pub(crate) mod wall_slip;

pub(crate) use acting::{Acting, Surroundings, longest_step};
pub(crate) use glass::{glass_with, motion_with, rise_m};
pub(crate) use rheology::liquid_with;
pub(crate) use wall_slip::{slip_m, stick};
