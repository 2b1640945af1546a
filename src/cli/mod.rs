//! The front ends of the command, one file a verb.

pub(crate) mod adopt;
mod among;
pub(crate) mod bench;
mod bus;
pub(crate) mod camera;
#[cfg(feature = "train")]
pub(crate) mod correct;
pub(crate) mod deadline;
pub(crate) mod discover;
pub(crate) mod doctor;
pub(crate) mod dump;
#[cfg(feature = "train")]
pub(crate) mod evaluate;
mod film;
pub(crate) mod flash;
#[cfg(feature = "train")]
pub(crate) mod generic;
mod glass;
mod inputs;
pub(crate) mod manual;
#[cfg(not(feature = "train"))]
mod no_train;
pub(crate) mod people;
mod profile;
pub(crate) mod quantize;
pub(crate) mod recognise;
pub(crate) mod record;
pub(crate) mod render;
pub(crate) mod run;
pub(crate) mod setup;
mod shipped;
pub(crate) mod simulate;
mod stop;
#[cfg(feature = "train")]
pub(crate) mod train;
#[cfg(not(feature = "train"))]
pub(crate) use no_train::{correct, evaluate, generic, train};
