//! The front ends of the command, one file a verb.

#[cfg(not(feature = "train"))]
mod absent;
#[cfg(feature = "studies")]
pub(crate) mod adopt;
mod among;
#[cfg(feature = "studies")]
pub(crate) mod bench;
mod bus;
#[cfg(feature = "studies")]
pub(crate) mod camera;
#[cfg(feature = "train")]
pub(crate) mod correct;
#[cfg(feature = "studies")]
pub(crate) mod deadline;
#[cfg(feature = "studies")]
pub(crate) mod discover;
pub(crate) mod doctor;
pub(crate) mod dump;
#[cfg(feature = "train")]
pub(crate) mod evaluate;
#[cfg(feature = "studies")]
mod film;
#[cfg(feature = "studies")]
mod filmed;
pub(crate) mod flash;
#[cfg(feature = "train")]
pub(crate) mod generic;
mod glass;
mod inputs;
pub(crate) mod manual;
#[cfg(feature = "studies")]
pub(crate) mod people;
mod profile;
#[cfg(feature = "studies")]
pub(crate) mod quantize;
#[cfg(feature = "studies")]
pub(crate) mod recognise;
#[cfg(feature = "studies")]
pub(crate) mod record;
#[cfg(feature = "studies")]
pub(crate) mod render;
pub(crate) mod run;
#[cfg(feature = "studies")]
pub(crate) mod setup;
mod shipped;
#[cfg(feature = "studies")]
pub(crate) mod simulate;
#[cfg(feature = "studies")]
mod stop;
#[cfg(feature = "train")]
pub(crate) mod train;
#[cfg(not(feature = "studies"))]
pub(crate) use absent::{
    adopt, bench, camera, deadline, discover, people, quantize, recognise, record, render, setup, simulate,
};
#[cfg(not(feature = "train"))]
pub(crate) use absent::{correct, evaluate, generic, train};
