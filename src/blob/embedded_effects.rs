//! Embedded effects of a blob: their names and values, and the liquid that the values are counted from.
//!
//! A blob lists effects by name and value. Their action on the step is worked out when it is loaded, by the formulas of
//! [`crate::reduced::effects`], so that only the list has to be trusted.

use crate::reduced::Rheology;
use crate::reduced::effects::{MOST, PARAMETERS, Stated};
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// One effect with the coordinates of its parameters in the reduced model; those that it does not have are zero.
///
/// A viscosity is stored as the factor over [`EmbeddedEffects::liquid`], a fill as the excess over the header's: the blob holds both,
/// so [`EmbeddedEffects::stated`] gives the SI values back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmbeddedEffect {
    /// Its name in the list of effects.
    pub name: String<32>,
    /// Its coordinates.
    pub values: [f64; PARAMETERS],
}

/// Effects and the liquid that they are counted from: the one that the model was trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EmbeddedEffects {
    /// Density of that liquid, kg/m3.
    pub density_kg_m3: f64,
    /// Rheology of that liquid.
    pub liquid: Rheology,
    /// Effects inserted into the model.
    pub effects: Vec<EmbeddedEffect, MOST>,
}

impl EmbeddedEffects {
    /// Returns liquid and glass that the coordinates are counted from, in a model of that radius and fill.
    #[must_use]
    pub fn stated(&self, radius_m: f64, fill_m: f64) -> Stated {
        Stated { consistency_pa_sn: self.liquid.consistency, radius_m, fill_m }
    }
}
