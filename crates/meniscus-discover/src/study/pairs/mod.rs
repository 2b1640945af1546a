//! Two effects of the liquid at once: hidden pairs, judged by the reduced model and then by the simulator.

pub mod cases;
