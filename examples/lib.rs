//! Small programs that use Meniscus as a library: `cargo run -p meniscus-examples --example see`.
