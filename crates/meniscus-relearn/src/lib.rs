//! Learning of a new liquid: a model that knows velocity, heat and stresses, from simulations of that liquid.
//!
//! ```text
//! recordings of the surface --identify--> liquid file --simulate--> recordings of the inside --train--> model
//!                                                                     '--held out--.                       |
//!                                        report <--judge--------------------------+-- model <--correct-----'
//! ```
//! [`Run`] goes through the [`Stage`]s in this order. Each takes its inputs from one folder and writes its outputs there
//! ([`Folder`]), whole or not at all, so that a person can stop after any of them, look, and go on. A stage whose output is
//! there is not run again. [`Plan`] is everything that determines the result; a folder belongs to one plan.
//!
//! The crate stands above `meniscus-learn` and `meniscus-discover`, because it joins the fits of the one with the training of the
//! other, and neither needs the other.
//!
//! | module | content |
//! |---|---|
//! | `plan`, `liquid_source`, `law`, `folder` | settings of a run, and the files that it writes |
//! | [`identify`] | viscosity, flow index and yield stress from recordings of the surface |
//! | `liquid_file` | a liquid as TOML with the interval of every number |
//! | `motions` | motions of the simulated glass, and how strong they may be |
//! | `simulate` | the recordings, several at once, none of them twice |
//! | `train`, `correct` | model, and its correction on the measured recordings |
//! | `judge`, `report` | errors and coverage on simulated recordings that no stage saw |
//! | `stage`, `run`, `progress` | the stages in their order, and the observer of a run |

mod correct;
mod error;
mod folder;
pub mod identify;
mod judge;
mod law;
mod learned_rows;
mod liquid_file;
mod liquid_source;
mod motions;
mod plan;
mod progress;
mod report;
mod run;
mod simulate;
mod stage;
mod train;

pub use error::RelearnError;
pub use folder::Folder;
pub use judge::{Judged, judge};
pub use learned_rows::learned_rows;
pub use liquid_file::{Sources, liquid_text};
pub use liquid_source::LiquidSource;
pub use motions::{SetName, SimulatedRecording, largest_strength};
pub use plan::{Plan, SetSizes};
pub use progress::{Progress, Silent};
pub use run::{Outcome, Run};
pub use simulate::{Shard, Workers};
pub use stage::Stage;
