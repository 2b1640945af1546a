//! Drawn law: the missing force on the first mode where no name fits.
//!
//! ```text
//! unknown --shape, fit--> f(a), D(u) --band--> bands --nearest--> formula and departures --> ask, gap
//! ```
//!
//! | file | purpose |
//! |---|---|
//! | `shape` | numbers of a law, their prior, and the curves that they stand for |
//! | `fit` | fit of law and baseline together, the drag never negative |
//! | `band` | bands of both curves |
//! | `nearest` | nearest formula of the library, and where the law departs from it |
//! | `draw` | whether a law is drawn, and everything that is said of it |
//! | `words` | sentences of a law |
//!
//! The law has no name. It acts on the first mode along the line on which the glass goes
//! ([`DrawnLaw`](meniscus::reduced::DrawnLaw)); what is missing elsewhere (a camera, a clock, the level at rest) it cannot
//! explain, and then none is drawn.

pub mod band;
pub mod draw;
pub mod fit;
pub mod nearest;
pub mod shape;
mod words;
