//! Path-traced glasses: refraction, meniscus and scattering that the project's own renderer does not have.
//!
//! ```text
//! set: images without noise, truth --degrade: faults of a camera--> pairs --judge: the reader--> errors
//!                                                                                 '--rows: table and checks of the study
//! ```

pub mod degrade;
pub mod judge;
pub mod rows;
pub mod set;
