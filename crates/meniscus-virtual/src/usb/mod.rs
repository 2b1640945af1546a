//! The simulated USB camera below the session: its bus, what stands before it, its replay of a dump, and a
//! film of what it shows for the rig in `hil/`.

mod bus;
mod film;
mod glass;
mod replay;

pub use bus::SimulatedBus;
pub use film::{FilmError, film};
pub use glass::RecordedGlass;
pub use replay::replay;
