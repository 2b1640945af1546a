//! Clear water before a bright card: path-traced glasses through the reader, `setup` and the command.
//!
//! The scenes are `tests/fixtures/optics`, made by `make.py` there. Nobody looked at those whose names begin with `judge`
//! while the reader was written.

mod command;
mod figures;
mod line;
mod nothing;
#[path = "../support/program.rs"]
mod program;
mod scenes;
mod setup;
mod swing;
