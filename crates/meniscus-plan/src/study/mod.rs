//! Study: random moves in the particle simulator, planned again and again from what the estimator sees.
//!
//! ```text
//! simulator --profile + noise of the camera--> estimator --state--> planner (10 Hz) --acceleration--> simulator
//! ```
//! The crest that is judged is the simulator's: the highest point along the wall until 0.4 s after arrival. The same glass then
//! makes the motion of minimum jerk in the same time, and in the time in which its crest is that of the plan. Each motion starts
//! from the same settled liquid. The other rivals are forecast by the model that planned.
//!
//! | module | purpose |
//! |---|---|
//! | `draw` | random moves |
//! | `camera` | noise of the rendered D435 on a profile |
//! | `carry` | one motion in the simulator, with the estimator in the loop or without |
//! | `judge` | one move, planned and by its rivals |
//! | `run` | all moves, kept one by one |
//! | `report`, `picture` | checks, page and pictures |

mod camera;
mod carry;
mod draw;
mod judge;
mod picture;
mod report;
mod run;

pub use camera::Camera;
pub use carry::{Bench, Carried, Failure, Trace, carry_planned, carry_rival};
pub use draw::{Move, StudyLiquid, moves};
pub use judge::{Outcome, Planner};
pub use picture::{move_png, study_png};
pub use report::{checks, report};
pub use run::{Progress, StudyError, StudyModels, StudyOptions, read, run};
