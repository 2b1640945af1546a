//! Glasses, and the files that simulator, training and discovery share: recordings, profiles, liquids, motions, effects, scenes and
//! weight blobs; recordings as VTK files.

pub mod blob_file;
pub mod effects;
pub mod glass;
pub mod liquids;
pub mod motion;
pub mod profiles;
pub mod recording;
pub mod scene_file;
pub mod validity;
pub mod vtk;
