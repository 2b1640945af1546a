//! Error model and intervals of a trained model, its figures on the validation recordings, and its blob.

pub(crate) mod blob_draft;
pub(crate) mod blob_parts;
pub(crate) mod camera_views;
pub(crate) mod error_model;
pub(crate) mod intervals;
pub(crate) mod learnt_model;
pub(crate) mod ratios;
pub(crate) mod validation_report;
