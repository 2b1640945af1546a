//! The simulated USB camera below the session: its bus, what stands before it, and its replay of a dump.

mod bus;
mod glass;
mod replay;

pub use bus::SimulatedBus;
pub use glass::RecordedGlass;
pub use replay::replay;
