//! A second laboratory: effects hidden in the liquid of another solver, judged against references of that solver.
//!
//! It shares no formula with the reduced model. Layers at the wall are diffused through cells in time, friction in the bulk is a sum
//! over the strains of potential flow, integrals are sums over points, and the line at the wall is a ring of pieces.
//!
//! | file | purpose |
//! |---|---|
//! | `shapes` | modes of a cylinder and their integrals, by quadrature |
//! | `layer` | layer at the wall, in time |
//! | `glass` | a glass of liquid with everything that can be hidden in it |
//! | `waves` | waves of a glass, with their masses, springs and friction |
//! | `solver` | motion of the liquid in time |
//! | `camera` | profiles as a camera sees them, and its faults |
//! | `trials` | what is hidden in which glass |
//! | `judge` | judgement by the workflow |
//! | `checks` | tally of the trials |

pub mod camera;
pub mod checks;
pub mod glass;
pub mod judge;
pub mod layer;
pub mod shapes;
pub mod solver;
pub mod trials;
mod waves;
