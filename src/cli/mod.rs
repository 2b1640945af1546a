//! The front ends of the command, one file a verb.

pub(crate) mod run;
mod shipped;
pub(crate) mod simulate;
#[cfg(feature = "train")]
pub(crate) mod train;
#[cfg(not(feature = "train"))]
#[path = "no_train.rs"]
pub(crate) mod train;
