//! The simulator around the liquid: neighbours, walls and glass, lent to an effect that acts by a force of its own.

use crate::particles::{Kernel, Neighbours};
use crate::walls::{Sticking, Walls};
use meniscus_data::recording::Glass;

/// The simulator around the liquid, as an effect needs it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surroundings<'a> {
    /// The kernel.
    pub(crate) kernel: &'a Kernel,
    /// The lists of neighbours.
    pub(crate) lists: &'a Neighbours,
    /// The images in the walls.
    pub(crate) walls: &'a Walls,
    /// Sticking of the liquid to them.
    pub(crate) sticking: Sticking,
    /// Rates of each particle from its neighbours, as in [`Forces::rate`](crate::forces::Forces::rate).
    pub(crate) rate: &'a [[f64; 3]],
    /// The glass.
    pub(crate) glass: &'a Glass,
    /// Spacing of the particles, m.
    pub(crate) spacing_m: f64,
}
