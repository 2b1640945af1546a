//! Output of a simulation: the surface, fields at tracers, recordings, and files of particles.

mod particles;
mod record;
mod surface;
mod tracers;
mod watched;

pub use particles::Particles;
pub use record::{Observer, record, record_particles, record_surfaces, record_until};
pub(crate) use surface::SurfaceFinder;
pub use watched::WatchedGlass;
