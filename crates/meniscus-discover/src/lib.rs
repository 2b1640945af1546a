//! Discovery: where simulation and measurement disagree, and the named effect that explains it.
//!
//! ```text
//! folders --load--> RecordingSet --Discovery::run--> Report { findings, insertion }
//!
//! recordings -> baseline -> fitting -> decision -> findings -> law -> insert -> foreign -> sizing -> references -> workflow -> report
//!                                                                                                           '-----> study
//! ```
//!
//! The folders follow the workflow, and a file imports only from its own folder and from those before it:
//!
//! | folder | content | begin with |
//! |---|---|---|
//! | [`recordings`] | recordings as a few numbers per frame, the motion of the glass, the one held out | `record` |
//! | [`baseline`] | reduced model without an effect: prior, noise, offsets and residuals from references | `calibrate` |
//! | [`fitting`] | covariance and exact whitening; fits of baseline and effects | `problem` |
//! | [`decision`] | ranking of the effects, thresholds from clean glasses, decision by class and name | `decide` |
//! | [`findings`] | map of the discrepancy, isolability, gap on the held-out recording, suggested recording | `mod` |
//! | [`law`] | the missing force as two curves, where no name fits | `mod` |
//! | [`insert`] | an effect in the flashed model and in the simulator | `mod` |
//! | [`foreign`] | other programs as simulators | `mod` |
//! | [`sizing`] | sizes by simulation, rivals compared by the simulator | `mod` |
//! | [`references`] | references by simulation, where none are given | `mod` |
//! | [`workflow`] | [`Discovery::run`](workflow::Discovery::run), its inputs, progress and errors | `mod` |
//! | [`report`] | results as JSON, scene file and page | `html` |
//! | [`study`] | effects hidden in other data, and how many are found | `run` |
//!
//! [`identify`] stands apart: which known liquid moves in a recording.

pub mod baseline;
pub mod decision;
pub mod findings;
pub mod fitting;
pub mod foreign;
pub mod identify;
pub mod insert;
pub mod law;
pub mod recordings;
pub mod references;
pub mod report;
pub mod sizing;
pub mod study;
pub mod workflow;
