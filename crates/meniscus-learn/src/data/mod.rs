//! Recordings as training data: fluctuations about rest, POD bases, projected sequences, errors on them.

pub(crate) mod dataset;
pub(crate) mod errors;
pub(crate) mod feed;
pub(crate) mod groups;
pub(crate) mod pod;
pub(crate) mod snapshots;
pub(crate) mod trajectory;
