//! Criterion benches; `cargo bench -p meniscus-benches` runs them.
