//! Data inside the program, so that the main job needs no file: a model, notes on liquids, and a recording that the model
//! has never seen.
#![no_std]

/// The glycerine model. `models/README.md` has the commands and seeds that made it.
pub const MODEL: &[u8] = include_bytes!("../models/glycerine.blob");

/// Liquids that are known in the glass of that recording, as notes of `meniscus recognise learn`; `models/README.md` has
/// the commands.
pub const LIQUIDS: [(&str, &str); 6] = [
    ("blood.liquid.json", include_str!("../models/liquids/blood.liquid.json")),
    ("butter.liquid.json", include_str!("../models/liquids/butter.liquid.json")),
    ("gazpacho.liquid.json", include_str!("../models/liquids/gazpacho.liquid.json")),
    ("glycerine.liquid.json", include_str!("../models/liquids/glycerine.liquid.json")),
    ("honey.liquid.json", include_str!("../models/liquids/honey.liquid.json")),
    ("water.liquid.json", include_str!("../models/liquids/water.liquid.json")),
];

/// Glycerine under a motion that took no part in training or choosing.
pub const RECORDING: &[u8] = include_bytes!("../recordings/glycerine-unseen.safetensors");
