//! Native half of the Python package `meniscus_liquid` (distribution `meniscus-liquid`).
//!
//! The Python half in `python/meniscus_liquid` re-exports these classes and adds what needs Python alone: figures, HDF5 and the
//! Gymnasium environment. Arrays are views on memory that a Rust object holds, read-only and without a copy, wherever
//! the object keeps the numbers in that form (`views`).
//!
//! Everything is behind the feature `module`, which `maturin` switches on. Without it the crate is empty: `cargo test
//! --workspace` needs no Python and builds no PyO3. The tests are those of pytest, in `tests/`, against the built wheel.
//!
//! | file | purpose |
//! |---|---|
//! | `errors`, `interrupt`, `views` | exceptions, Ctrl-C during long work, arrays without copies |
//! | `glass`, `liquid`, `motion`, `scene` | what a simulation is made of |
//! | `recording`, `simulate`, `export` | recordings, and the programs that make and convert them |
//! | `model`, `profile`, `estimator`, `estimate` | the estimator on a weight blob |
//! | `reduced` | the reduced slosh model |
//! | `correct`, `evaluate` | a model learns another liquid, and is judged |
//! | `discover`, `simulator` | discovery, with a Python function as its simulator |
#![cfg(feature = "module")]

mod arguments;
mod correct;
mod discover;
mod errors;
mod estimate;
mod estimator;
mod evaluate;
mod export;
mod glass;
mod interrupt;
mod liquid;
mod model;
mod motion;
mod profile;
mod recording;
mod reduced;
mod scene;
mod simulate;
mod simulator;
mod views;

/// Classes and functions of the module `meniscus_liquid._native`.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use super::correct::{Correction, correct};
    #[pymodule_export]
    use super::discover::{Verdict, discover};
    #[pymodule_export]
    use super::errors::{MeniscusError, SimulationError};
    #[pymodule_export]
    use super::estimate::{Estimate, Estimates, Forecast};
    #[pymodule_export]
    use super::estimator::Estimator;
    #[pymodule_export]
    use super::evaluate::{Evaluation, evaluate};
    #[pymodule_export]
    use super::export::export_vtp;
    #[pymodule_export]
    use super::glass::Glass;
    #[pymodule_export]
    use super::liquid::{Liquid, effects, liquids};
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::motion::Motion;
    #[pymodule_export]
    use super::profile::{Profile, camera_profiles, load_profiles, save_profiles};
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::reduced::{ReducedModel, ReducedState};
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::simulate::simulate;

    /// Adds the version.
    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        use pyo3::types::PyModuleMethods;
        // As a turn of the command: kernels for the processor that is there. The numbers do not depend on it.
        meniscus_platform::cpu_features::widen();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
