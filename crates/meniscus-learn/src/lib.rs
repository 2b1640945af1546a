//! Training, correction and evaluation of the models that the camera side runs.
//!
//! # Stages of a training
//!
//! ```text
//! recordings --pod--> coefficients --autoencoder--> latents --warm start--> dynamics --rollout--> dynamics --.
//!                                                     '--noise, encoder--> encoder --------------------------+--filter--> draft
//! draft --calibration, evaluation--> blob
//! ```
//! [`train()`] is this list; [`Stage`] declares the name, the seed, the metric and the checkpoint of each stage, and
//! [`Hyperparameters`] holds all that can be tuned. Networks learn through burn; operators are fitted and judged in double
//! precision. [`correct`] lets a model learn another liquid from its free surface, and [`evaluate`] judges both.
//!
//! # Modules, lowest first
//!
//! | module | purpose |
//! |---|---|
//! | `data` | recordings as POD coefficients, latent trajectories, errors on them |
//! | `operators` | the GENERIC step in double precision and in tensors, its fits and its training |
//! | `networks` | autoencoder, encoder, camera noise, internal energy, sparse autoencoders |
//! | `calibration` | error model, intervals, figures of the parts, tensors of the blob |
//! | `train` | the stages in their order |
//! | [`correct`] | correction of a blob by recordings of another liquid |
//! | [`evaluate`] | study of a model before and after correction |
//! | [`seeds`] | mean, deviation and worst of a figure over several trainings |

mod blob_text;
mod calibration;
pub mod correct;
mod data;
mod error;
pub mod evaluate;
mod hyperparameters;
mod learning_curves;
mod networks;
mod operators;
pub mod seeds;
mod stage;
mod train;

pub use error::TrainError;
pub use hyperparameters::{
    AutoencoderParameters, EncoderParameters, FilterParameters, HeatParameters, Hyperparameters,
    PodParameters, RolloutParameters, Schedule, SoftParameters, SparseParameters, WarmStartParameters,
};
pub use learning_curves::curves_png;
pub use networks::base::Base;
pub use stage::{Stage, StageInfo, StageRecord};
pub use train::{Options, Trained, measured_again, stages, train};
