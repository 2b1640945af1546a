//! The front ends of the command, one file a verb.

pub(crate) mod simulate;
