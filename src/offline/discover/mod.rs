//! Discovery: where simulation and measurement disagree, and the named effect that explains it.
//!
//! ```text
//! folders --load--> Record --calibrate (references first)--> Problem --verdict--> none, named, tied, unknown
//!                                                                 '--ask, sealed, report
//! ```
//!
//! | file | step |
//! |---|---|
//! | `load`, `record` | recordings as a few numbers a frame, and the motion |
//! | `predict` | what the reduced model expects them to show |
//! | `calibrate` | the baseline and what it cannot do, from references of a known liquid; noise from rest |
//! | `problem` | covariance, exact whitening, nuisances with their prior |
//! | `fit` | damped Gauss-Newton; coarse search over an effect with the nuisances free |
//! | `verdict` | ranking, forward step to pairs, decision by class and name, isolability |
//! | `localise` | where the plain model disagrees |
//! | `ask` | the motion that would tell candidates apart |
//! | `workflow` | the steps in order, thresholds from the references, the sealed recording |
//! | `report` | JSON, page and scene file |
//! | `study` | effects hidden in other data, and what came of it |

pub mod ask;
pub mod calibrate;
pub mod fit;
pub mod load;
pub mod localise;
pub mod predict;
pub mod problem;
pub mod record;
pub mod report;
pub mod study;
pub mod verdict;
pub mod workflow;
