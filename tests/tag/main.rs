//! The motion of the glass from an AprilTag: corners and poses beside the truth and an independent reader, whole runs beside those
//! with the true motion, and the page that prints one.

mod fixture;
mod images;
mod print;
#[path = "../support/program.rs"]
mod program;
mod run;
