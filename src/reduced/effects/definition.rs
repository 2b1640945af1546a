//! The definition of an effect: everything that any consumer asks of it.

use super::{EffectKind, Limit, PARAMETERS, Parameter, Simulator, Slot, Stated, ValueError, Values};

/// Most effects at once in a model.
pub const MOST: usize = 4;

/// Group of effects that can be distinguished before the single effect can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// View, stand and fill.
    View,
    /// Clocks.
    Timing,
    /// Motion of the glass.
    Actuation,
    /// Restoring forces.
    Stiffness,
    /// Damping that is the same at every amplitude.
    Damping,
    /// Damping that depends on the amplitude.
    AmplitudeDamping,
    /// Shape of the wave and coupling of its directions.
    Shape,
}

impl Class {
    /// Returns the class in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::View => "view and stand",
            Self::Timing => "timing",
            Self::Actuation => "actuation",
            Self::Stiffness => "stiffness",
            Self::Damping => "linear damping",
            Self::AmplitudeDamping => "amplitude-dependent damping",
            Self::Shape => "shape",
        }
    }

    /// Returns whether it acts in the liquid, and not on how that is viewed, timed or moved.
    #[must_use]
    pub fn in_liquid(self) -> bool {
        !matches!(self, Self::View | Self::Timing | Self::Actuation)
    }
}

/// Recorded motion that an effect may take a share of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// Inclination of the glass.
    Inclination,
    /// Vertical acceleration of the glass.
    Lift,
}

/// Parameters that a fit moves; the others stay where they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FreeParameters {
    /// All of them.
    All,
    /// The first; the second is a property of the wall that these data do not determine.
    First,
    /// The share of a recorded motion where there is one that the model was not given, the constant otherwise.
    FirstOrRecorded(Recorded),
}

/// One effect.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Identity, for exhaustive matches.
    pub kind: EffectKind,
    /// Name on the command line, in files and in reports.
    pub name: &'static str,
    /// Class.
    pub class: Class,
    /// Its parameters, one to [`PARAMETERS`].
    pub parameters: &'static [Parameter],
    /// The effect in a sentence.
    pub about: &'static str,
    /// Source of the formula.
    pub source: &'static str,
    /// Place in the reduced model. A camera effect is a [`Slot::View`].
    pub slot: Slot,
    /// Law in the particle simulator, which also selects its validation case.
    pub simulator: Simulator,
    /// Parameters that a fit moves.
    pub free: FreeParameters,
    /// Effect that no recording of a planar motion distinguishes from this one.
    pub twin: Option<EffectKind>,
    /// First coordinate in a hidden trial of the discovery study, by size; size 1 is the reference size. `None` is not
    /// hidden.
    pub trial: Option<fn(f64) -> f64>,
}

impl Effect {
    /// Returns whether it is geometry (view, timing, stand and motion), whose formula is exact. A fill is not: beside
    /// the level it changes the waves.
    #[must_use]
    pub fn is_geometry(&self) -> bool {
        matches!(self.slot, Slot::Port(_) | Slot::View(_)) && !self.class.in_liquid()
    }

    /// Returns the coordinates at which the effect is absent.
    #[must_use]
    pub fn neutral(&self) -> Values {
        let mut values = [0.0; PARAMETERS];
        values.iter_mut().zip(self.parameters).for_each(|(value, parameter)| *value = parameter.neutral);
        values
    }

    /// Returns the effect at the SI values `given`, counted from `stated`; a parameter that is not given is neutral.
    ///
    /// # Errors
    /// [`ValueError`] when a value has no meaning, or the reduced model's formula does not hold for it.
    pub fn active(
        &'static self,
        given: &[Option<f64>; PARAMETERS],
        stated: &Stated,
    ) -> Result<Active, ValueError> {
        let mut values = self.neutral();
        for ((slot, parameter), given) in values.iter_mut().zip(self.parameters).zip(given) {
            let Some(value) = *given else { continue };
            parameter.check(value)?;
            let coordinate = parameter.to_coordinate(value, stated);
            let (least, largest) = parameter.range;
            if !(least <= coordinate && coordinate <= largest) {
                let range = (parameter.to_value(least, stated), parameter.to_value(largest, stated));
                return Err(parameter.refused(value, range, Limit::ReducedModel));
            }
            *slot = coordinate;
        }
        Ok(Active { entry: self, values })
    }
}

/// An effect with its coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Active {
    /// Its definition.
    pub entry: &'static Effect,
    /// Its coordinates in the reduced model.
    pub values: Values,
}

impl Active {
    /// Returns the SI values, counted from `stated`; `None` for a parameter that the effect does not have.
    #[must_use]
    pub fn stated_values(&self, stated: &Stated) -> [Option<f64>; PARAMETERS] {
        let mut out = [None; PARAMETERS];
        for ((out, parameter), coordinate) in out.iter_mut().zip(self.entry.parameters).zip(&self.values) {
            *out = Some(parameter.to_value(*coordinate, stated));
        }
        out
    }
}
