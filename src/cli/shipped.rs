//! What comes inside the program, so that the main job needs nothing else: a model and a recording
//! that it has never seen.

/// The glycerine model. `models/README.md` has the commands and seeds that made it.
pub(crate) const MODEL: &[u8] = include_bytes!("../../models/glycerine.blob");

/// Glycerine under a motion that took no part in training or choosing.
pub(crate) const RECORDING: &[u8] = include_bytes!("../../recordings/glycerine-unseen.safetensors");
