//! Tests of the core that need few crates, for quick mutation testing; there is no code.
