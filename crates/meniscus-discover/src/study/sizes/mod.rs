//! Sizes of hidden effects by simulation, counted over trials.
//!
//! Each trial at reference size whose verdict states a class is sized as `meniscus discover` does by default. Nothing of the
//! sizing was set on these glasses.
//!
//! | file | purpose |
//! |---|---|
//! | `run` | which trials are sized, and the sizing of each |
//! | `trial` | sizes beside the truth |
//! | `checks` | tally of the trials, and their table |

pub mod checks;
pub mod run;
pub mod trial;
