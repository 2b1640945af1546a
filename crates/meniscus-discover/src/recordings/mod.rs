//! Recordings of one glass: a few numbers per frame, and the motion of the glass.

pub mod error;
mod gauges;
pub mod load;
pub mod motion_plan;
pub mod record;
pub mod split;
pub mod stated;
pub mod tables;
