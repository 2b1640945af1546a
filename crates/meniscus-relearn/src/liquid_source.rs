//! Origin of the liquid of a run.

use crate::law::Law;
use serde::{Deserialize, Serialize};

/// Origin of the liquid that is simulated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum LiquidSource {
    /// A liquid file as it stands, or a known liquid by its name.
    Stated(String),
    /// Viscosity, and flow index and yield stress by `law`, from recordings; density and name as stated.
    Identified {
        /// Name of the liquid.
        name: String,
        /// Density, kg/m3.
        density_kg_m3: f64,
        /// Viscosity that a source states, Pa s: taken where the recordings do not determine it.
        stated_viscosity_pa_s: Option<f64>,
        /// Law that is fitted.
        law: Law,
    },
}
