//! References of a discovery: those that were given, or those that the simulator makes.

use super::error::DiscoverError;
use super::inputs::Inputs;
use super::progress::{Progress, Stage};
use crate::recordings::record::Record;
use crate::references::{SimulatedReference, simulated_references};
use crate::sizing::simulations::Simulations;
use crate::sizing::store::SimulationStore;

/// Origin of the references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReferenceOrigin {
    /// There are none.
    None,
    /// Recordings of known liquids were given.
    Given,
    /// The simulator made them.
    Simulator,
    /// The simulator could not make them, so that there are none.
    NotSimulated {
        /// Reason, in words.
        reason: String,
    },
}

impl ReferenceOrigin {
    /// Returns the origin in one word of the file format.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::None | Self::NotSimulated { .. } => "none",
            Self::Given => "given",
            Self::Simulator => "simulator",
        }
    }

    /// Returns what the origin means for the verdict; nothing where references were given or are simply absent.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self {
            Self::None | Self::Given => String::new(),
            Self::Simulator => String::from(
                " This is said against the simulator: its references are simulated glasses of the stated liquid, so that an error \
                 of the simulator counts as an effect.",
            ),
            Self::NotSimulated { reason } => format!(" The simulator could not make references: {reason}."),
        }
    }
}

/// References with their origin.
pub(super) struct Found {
    pub(super) references: Vec<SimulatedReference>,
    pub(super) origin: ReferenceOrigin,
}

/// Returns the `given` references, or those that the simulator makes for `records` where `inputs` ask for it.
///
/// # Errors
/// [`DiscoverError::Sizing`], when the simulations end early; what is done is kept.
pub(super) fn references(
    inputs: &Inputs,
    given: Vec<SimulatedReference>,
    records: &[Record],
    progress: &dyn Progress,
) -> Result<Found, DiscoverError> {
    if !given.is_empty() {
        return Ok(Found { references: given, origin: ReferenceOrigin::Given });
    }
    let Some(settings) = &inputs.simulated_references else {
        return Ok(Found { references: given, origin: ReferenceOrigin::None });
    };
    progress.begins(Stage::SimulateReferences);
    let store = SimulationStore::new(&settings.store);
    let watch = |state| progress.referenced(state);
    let mut simulations = Simulations::new(&store, &watch);
    simulations.simulator = &*inputs.simulator;
    (simulations.stop, simulations.shard) =
        (inputs.stop, inputs.sizing.as_ref().and_then(|sizing| sizing.shard));
    match simulated_references(records, &inputs.recordings.known, settings, &simulations) {
        Ok(references) => Ok(Found { references, origin: ReferenceOrigin::Simulator }),
        Err(error) if error.ends_all() => Err(DiscoverError::Sizing(error)),
        Err(error) => {
            let origin = ReferenceOrigin::NotSimulated { reason: error.to_string() };
            Ok(Found { references: given, origin })
        }
    }
}
