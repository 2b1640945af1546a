//! Discovery: where simulation and measurement disagree, and the named effect that explains it.
//!
//! ```text
//! folders --load--> RecordingSet --Discovery::run--> Report { findings, insertion }
//!
//! split -> calibrate (references first) -> thresholds -> rank -> choose -> decide -> Verdict
//!                                                                    '-> localise, suggest, gap -> insert
//! ```
//!
//! | file | content |
//! |---|---|
//! | `workflow`, `inputs`, `settings`, `progress` | [`Discovery::run`](workflow::Discovery::run) and what it needs |
//! | `load`, `motion_table`, `record` | recordings as a few numbers per frame, and the motion |
//! | `split` | the recordings that are fitted and the one that is held out |
//! | `predict` | prediction of a recording by the reduced model |
//! | `group`, `group_fit` | references of a known liquid and their fit |
//! | `calibrate`, `reference_residual` | prior and error of the baseline, learnt from references |
//! | `noise`, `offsets` | measurement noise; nuisance offsets of fill, lean and view |
//! | `problem`, `covariance` | covariance, exact whitening, nuisances with their prior |
//! | `fit`, `fit_cache` | least squares; coarse search over an effect with the nuisances free; fits on disk |
//! | `rank` | ranking of all effects, the best of them fitted |
//! | `decision_rules`, `thresholds` | constants of the decision; bounds learnt from clean glasses, by effect |
//! | `choose`, `decide`, `verdict`, `assessment` | forward step to pairs, decision by class and name |
//! | `rest_offset`, `evidence` | offsets at rest; bootstrap, cross-validation, isolability |
//! | `localise` | map of the discrepancy of the model without an effect |
//! | `suggest` | the motion that would distinguish the leading candidates |
//! | `gap` | error of each model on the held-out recording |
//! | `insert`, `insertion` | the effect in the flashed model and in the simulator |
//! | `findings`, `verdict_json`, `report`, `html`, `drawings` | results as JSON, scene file and page |
//! | `error`, `input_error` | errors |
//! | `study` | effects hidden in other data, and how many are found |
//! | `identify` | which known liquid moves in a recording |

pub mod assessment;
pub mod calibrate;
mod choose;
mod covariance;
pub mod decide;
pub mod decision_rules;
mod drawings;
pub mod error;
pub mod evidence;
pub mod findings;
pub mod fit;
pub mod fit_cache;
pub mod gap;
pub mod group;
mod group_fit;
pub mod html;
pub mod identify;
pub mod input_error;
pub mod inputs;
pub mod insert;
pub mod insertion;
pub mod isolability;
pub mod known;
pub mod load;
pub mod localise;
pub mod motion_plan;
pub mod motion_table;
pub mod noise;
pub mod offsets;
pub mod predict;
pub mod problem;
pub mod problem_error;
pub mod progress;
pub mod rank;
pub mod record;
pub mod reference_residual;
pub mod report;
pub mod rest_offset;
pub mod settings;
pub mod split;
pub mod study;
pub mod suggest;
pub mod thresholds;
pub mod verdict;
pub mod verdict_json;
pub mod workflow;
