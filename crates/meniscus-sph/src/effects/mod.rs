//! Laws of the effects that the simulator carries. Without any of them the tension alone acts that the sums lack.
//!
//! | file | effects | where they act |
//! |---|---|---|
//! | `laws` | (all) | from the list of effects to the simulator's numbers |
//! | `rheology` | viscosity, shear_thinning, yield_stress | the liquid's stress |
//! | `walls::slip` | wall_slip | friction at the wall |
//! | `waves` | (shared by the next four) | standing waves of the surface |
//! | `columns` | (shared by the next three) | heights of those waves as sums over particles |
//! | `many` | (shared by the same) | those waves at many places at once |
//! | `surface_tension` | surface_tension | stored energy of the surface's area |
//! | `contact_line` | contact_line, pinned_line | spring and friction along the wall |
//! | `foam` | foam | friction along the wall |
//! | `viscoelastic` | viscoelastic | a stress on every particle |
//! | `glass` | container_tilt, vertical_acceleration, fill | body force and fill |
//!
//! Books: what an effect stores (area, spring, elastic stress) counts into the potential energy, what
//! it dissipates becomes heat of the particles where it acts. Another effect is a [`Law`](meniscus::reduced::effects::Law)
//! in the list of effects, its arm in `laws` and in [`validate`](crate::validate), and its file.

pub(crate) mod acting;
mod columns;
mod contact_line;
mod foam;
mod glass;
mod laws;
mod many;
mod rheology;
mod surface_tension;
mod surroundings;
mod viscoelastic;
pub(crate) mod waves;

pub(crate) use acting::{Acting, longest_step};
pub(crate) use glass::{glass_with, motion_with, rise_m};
pub(crate) use laws::Laws;
pub(crate) use rheology::liquid_with;
pub(crate) use surroundings::Surroundings;
