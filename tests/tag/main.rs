//! The motion of the glass from an AprilTag: corners and poses beside the truth and an independent reader, whole runs beside those
//! with the true motion.

mod fixture;
mod images;
mod run;
mod times;
