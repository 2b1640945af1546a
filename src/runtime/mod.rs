//! The 60 Hz turn: predict, correct, decode, inside a budget, in a mode that says how valid the estimate is.
//!
//! | file | purpose |
//! |---|---|
//! | `turn_input`, `estimate` | input and result of a turn |
//! | `estimator` | the turn as a list of its stages |
//! | `predict`, `correct`, `decode` | the stages |
//! | `memory`, `motion`, `mode`, [`health`] | state from turn to turn |
//! | `budget` | deadline and times of the stages |
//! | `profile_sensor`, `tracker` | payloads to profiles, and to turns |
//! | `forecast`, `lagged_stress` | surface ahead, stresses one frame late |
//! | [`output`] | bytes of an estimate |

mod budget;
mod correct;
mod course;
mod decode;
mod estimate;
mod estimator;
mod forecast;
pub mod health;
mod lagged_stress;
mod linear_model;
mod memory;
mod modal_state;
mod mode;
mod motion;
pub mod output;
mod predict;
mod profile_sensor;
mod tracker;
mod turn_input;

pub use budget::{Clock, DEADLINE_US, Stages};
pub use estimate::Estimate;
pub use estimator::{Estimator, POINTS_NEEDED};
pub use forecast::{Crest, Forecast};
pub use lagged_stress::smoothed_stress;
pub use linear_model::{LatentRows, LinearModel, LinearStep};
pub use memory::Memory;
pub use modal_state::{ALONG_STATES, MODES_ALONG, ModalState, ModeState};
pub use mode::{COAST_LIMIT, Mode};
pub use motion::Motion;
pub use profile_sensor::{FrameObservation, ProfileSensor};
pub use tracker::{Tracker, Turn};
pub use turn_input::{InputSource, TurnInput};
