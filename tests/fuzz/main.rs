//! Bytes from outside, mutated: nothing panics, and what comes out keeps its promises.
//!
//! ```text
//! bytes.rs        sound bytes with changes anywhere
//! blobs.rs        weight blobs whose length and checksum are right again
//! containers.rs   MCAP, ROS 1, SQLite, safetensors: changes inside, with every length around them right
//! texts.rs        TOML: scenes, liquids, setups as trees of hostile values
//! wires.rs        datagrams, and descriptors that follow each other as they should
//! corpus.rs       tests/corpus: a file for each way in which a reader ends
//! ```
//! Each target starts from sound bytes (of the simulated camera, the shipped model, the shipped recording), so that a
//! mutation gets past the first check. `MENISCUS_FUZZ=50 cargo test --release -p meniscus-tests --test fuzz` runs 50 times as
//! many cases; proptest shrinks a failing case and keeps it beside the target in a file `.regressions`.

#[path = "../recordings/mod.rs"]
mod recordings;

#[path = "../support/mod.rs"]
#[allow(dead_code, reason = "each test takes what it needs of it")]
mod support;

mod blobs;
mod bytes;
mod containers;
mod corpus;
mod mutation;
#[path = "../support/resealed.rs"]
mod resealed;
mod texts;
mod wires;
