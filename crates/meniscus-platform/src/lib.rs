//! What Meniscus needs of the operating system, each need in one file.

pub mod allocations;
pub mod clock;
pub mod cpu_features;
pub mod files;
pub mod handoff;
pub mod large_pages;
pub mod realtime;
