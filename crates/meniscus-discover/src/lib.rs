//! Discovery: where simulation and measurement disagree, and the named effect that explains it.
//!
//! ```text
//! folders --load--> Record --calibrate (references first)--> Problem --verdict--> none, named, tied, unknown
//!                                                                 '--ask, sealed, report
//! ```
//!
//! | file | step |
//! |---|---|
//! | `load`, `tables`, `record` | recordings as a few numbers a frame, and the motion |
//! | `predict` | what the reduced model expects them to show |
//! | `calibrate`, `left` | the baseline and what it cannot do, from references of a known liquid |
//! | `noise`, `offsets` | noise from rest frames; what fill, stand and view may be off by |
//! | `problem`, `covariance` | covariance, exact whitening, nuisances with their prior |
//! | `fit` | damped Gauss-Newton; coarse search over an effect with the nuisances free |
//! | `rank` | every effect searched for, the best fitted |
//! | `thresholds` | what clean glasses fake, by effect |
//! | `choose`, `verdict` | forward step to pairs, decision by class and name |
//! | `evidence` | bootstrap, recordings left out, isolability |
//! | `localise` | where the plain model disagrees |
//! | `ask` | the motion that would tell candidates apart |
//! | `gap` | what each model leaves of the sealed recording |
//! | `workflow` | the steps in order |
//! | `kept` | fits that are not made twice |
//! | `report`, `html`, `drawings` | JSON and scene file, and the page with what is drawn in it |
//! | `study` | effects hidden in other data, and what came of it |

pub mod ask;
pub mod calibrate;
mod choose;
mod covariance;
pub mod decision_rules;
mod drawings;
pub mod evidence;
pub mod fit;
pub mod fit_cache;
pub mod gap;
pub mod html;
pub mod identify;
pub mod insert;
pub mod load;
pub mod localise;
pub mod motion_table;
pub mod noise;
pub mod offsets;
pub mod predict;
pub mod problem;
pub mod rank;
pub mod record;
pub mod reference_residual;
pub mod report;
pub mod settings;
pub mod split;
pub mod study;
pub mod thresholds;
pub mod verdict;
pub mod workflow;
