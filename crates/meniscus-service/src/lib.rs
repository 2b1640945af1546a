//! The running estimator on a host: worker, snapshots for viewers, publishing, commanded motion, set-up of a glass, flash slots.

pub mod camera_facts;
pub mod clock_map;
pub mod commanded_motion;
pub mod controller;
pub mod flash;
pub mod identify;
pub mod ledger;
pub mod live;
pub mod publish;
pub mod run;
pub mod setup;
pub mod sink;
pub mod snapshot;
pub mod timed_turn;
pub mod truth;
