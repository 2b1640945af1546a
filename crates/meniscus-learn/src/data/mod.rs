//! Recordings as training data: fluctuations about rest, POD bases, projected sequences.

pub(crate) mod dataset;
pub(crate) mod feed;
pub(crate) mod pod;
pub(crate) mod snapshots;
