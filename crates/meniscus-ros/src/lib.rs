//! A ROS 2 node of the running estimator, without a ROS installation: `ros2-client` over RustDDS.
//!
//! ```text
//! worker --TurnOutlet (never waits)--> queue --> publisher's thread --> /liquid/*, /tf, /diagnostics
//!                                       robot --> plan service's thread, parameter services' thread
//! ```
//! `docs/robots.md` has topics, parameters and the service; their definitions are in `ros2/meniscus_msgs`.
//! DDS knows no password: whoever reaches the domain may read everything, set the parameters of [`LiveSettings`] and hand in plans.
//! None of them changes the estimate. The topic of the motion does ([`RosMotion`]), as far as the camera does not deny it.

mod counters;
mod error;
mod frames;
pub mod message;
mod motion;
mod node;
mod outlet;
mod parameters;
mod plan_service;
mod publishing;
mod rate;
mod report;
mod topics;
mod tracers;
mod unsent;

pub use counters::{Counters, Counts};
pub use error::RosError;
pub use motion::{FramePair, MotionTopic, RosMotion};
pub use node::{RosNode, RosSettings};
pub use outlet::TurnOutlet;
pub use parameters::{Facts, LiveSettings};
pub use unsent::counting;
