//! Services of the operating system that Meniscus uses, one file each.

pub mod allocations;
pub mod clock;
pub mod cpu_features;
pub mod files;
pub mod handoff;
pub mod large_pages;
pub mod realtime;
