//! Effects as a person spells them: `NAME=VALUE`, on command lines and in files, for every consumer.
//!
//! Names, parameters, units and ranges are those of the list in [`meniscus::reduced::effects`]. This module keeps which of
//! them are on, and reads their spelling:
//!
//! ```text
//! yield_stress=3                    the first parameter
//! contact_line=0.02,0.0005          the first and the second
//! contact_line_reach=0.0005         the second alone
//! ```

use meniscus::reduced::effects::{
    Active, EffectKind, LIBRARY, PARAMETERS, Parameter, Simulator, Slot, Stated, ValueError, find,
    find_parameter,
};

/// SI values of the effects that are on; `None` is off.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct Effects {
    values: [[Option<f64>; PARAMETERS]; EffectKind::COUNT],
}

/// Reason why an effect was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum EffectError {
    /// No effect has this name.
    Unknown(String),
    /// Not `NAME=VALUE` with a number.
    Malformed(String),
    /// More values than the effect has parameters.
    TooMany {
        /// The effect.
        name: &'static str,
        /// Values given.
        given: usize,
        /// Its parameters.
        parameters: usize,
    },
    /// The value is out of its range.
    Value(ValueError),
    /// Two laws for the one contact line.
    TwoLines([&'static str; 2]),
    /// The particle simulator has no law for it.
    NotSimulated {
        /// The parameter.
        spelling: &'static str,
        /// The reason.
        why: &'static str,
    },
}

impl std::fmt::Display for EffectError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(name) => {
                let names: Vec<_> =
                    LIBRARY.iter().flat_map(|effect| effect.parameters).map(|p| p.spelling).collect();
                write!(f, "no effect is called '{name}': take one of {}", names.join(", "))
            }
            Self::Malformed(text) => {
                write!(f, "'{text}' is not an effect: write NAME=VALUE, as surface_tension=0.063")
            }
            Self::TooMany { name, given, parameters } => {
                write!(f, "effect {name} has {parameters} parameter(s), and {given} values are given")
            }
            Self::Value(error) => write!(f, "{error}"),
            Self::TwoLines([one, other]) => {
                write!(f, "effects {one} and {other} are two laws of the same contact line: give one of them")
            }
            Self::NotSimulated { spelling, why } => {
                write!(
                    f,
                    "effect {spelling} is not simulated: {why} (`meniscus simulate --list` shows the others)"
                )
            }
        }
    }
}

impl std::error::Error for EffectError {}

impl From<ValueError> for EffectError {
    fn from(error: ValueError) -> Self {
        Self::Value(error)
    }
}

impl Effects {
    /// Switches the effect `spelling` on with the SI value `value`.
    ///
    /// # Errors
    /// When there is no such effect, the value is out of its range, or another law of the contact line is on.
    pub fn set(&mut self, spelling: &str, value: f64) -> Result<(), EffectError> {
        let (effect, which) =
            find_parameter(spelling).ok_or_else(|| EffectError::Unknown(spelling.into()))?;
        effect.parameters[which].check(value)?;
        if let Some(other) = self.line().filter(|other| *other != effect.kind && is_line(effect.kind)) {
            return Err(EffectError::TwoLines([other.name(), effect.name]));
        }
        self.values[effect.kind as usize][which] = Some(value);
        Ok(())
    }

    /// Switches on what `text` says: `NAME=VALUE` or `NAME=VALUE,VALUE`.
    ///
    /// # Errors
    /// As for [`Self::set`], or when the text is of another form.
    pub fn parse(&mut self, text: &str) -> Result<(), EffectError> {
        let malformed = || EffectError::Malformed(text.into());
        let (name, values) = text.split_once('=').ok_or_else(malformed)?;
        let values: Result<Vec<f64>, _> = values.split(',').map(|value| value.trim().parse()).collect();
        let (name, values) = (name.trim(), values.map_err(|_| malformed())?);
        let [value] = values[..] else {
            let effect = find(name).ok_or_else(|| EffectError::Unknown(name.into()))?;
            let (given, parameters) = (values.len(), effect.parameters.len());
            if given > parameters {
                return Err(EffectError::TooMany { name: effect.name, given, parameters });
            }
            let mut each = effect.parameters.iter().zip(values);
            return each.try_for_each(|(parameter, value)| self.set(parameter.spelling, value));
        };
        self.set(name, value)
    }

    /// Returns these effects with the first parameter of `kind` at `value`, unchecked.
    #[must_use]
    pub fn with(mut self, kind: EffectKind, value: f64) -> Self {
        self.values[kind as usize][0] = Some(value);
        self
    }

    /// Returns the SI value of the first parameter of `kind`, where it is on.
    #[must_use]
    pub fn value(&self, kind: EffectKind) -> Option<f64> {
        self.values[kind as usize][0]
    }

    /// Returns the SI values of the parameters of `kind`.
    #[must_use]
    pub fn values(&self, kind: EffectKind) -> [Option<f64>; PARAMETERS] {
        self.values[kind as usize]
    }

    /// Returns the parameters that are on, with their SI values, in the order of the list.
    #[must_use]
    pub fn on(&self) -> Vec<(&'static Parameter, f64)> {
        let rows =
            LIBRARY.iter().zip(&self.values).flat_map(|(effect, row)| effect.parameters.iter().zip(row));
        rows.filter_map(|(parameter, value)| Some((parameter, (*value)?))).collect()
    }

    /// Returns the effects that are on in the coordinates of the reduced model of `stated`.
    ///
    /// # Errors
    /// When the reduced model's formula does not hold for a value.
    pub fn active(&self, stated: &Stated) -> Result<Vec<Active>, EffectError> {
        let rows = LIBRARY.iter().zip(&self.values).filter(|(_, row)| row.iter().any(Option::is_some));
        rows.map(|(effect, row)| effect.active(row, stated).map_err(EffectError::from)).collect()
    }

    /// Switches `active`, counted from `stated`, on as the particle simulator carries it: the parameters of its law.
    ///
    /// # Errors
    /// When the simulator has no law for it, or as for [`Self::set`].
    pub fn set_simulated(&mut self, active: &Active, stated: &Stated) -> Result<(), EffectError> {
        let taken = match active.entry.simulator {
            Simulator::Law(law) => law.parameters(),
            Simulator::Absent(why) => {
                return Err(EffectError::NotSimulated { spelling: active.entry.name, why });
            }
        };
        let values = active.stated_values(stated).into_iter().flatten();
        let mut each = active.entry.parameters.iter().zip(values).take(taken);
        each.try_for_each(|(parameter, value)| self.set(parameter.spelling, value))
    }

    /// Checks that the particle simulator has a law for every parameter that is on.
    ///
    /// # Errors
    /// [`EffectError::NotSimulated`] with the reason.
    pub fn require_simulated(&self) -> Result<(), EffectError> {
        for (effect, row) in LIBRARY.iter().zip(&self.values) {
            for (n, (parameter, _)) in
                effect.parameters.iter().zip(row).enumerate().filter(|(_, (_, value))| value.is_some())
            {
                let why = match effect.simulator {
                    Simulator::Absent(why) => why,
                    Simulator::Law(law) if n >= law.parameters() => {
                        "the motion file holds the recorded motion, and the simulator takes all of it"
                    }
                    Simulator::Law(_) => continue,
                };
                return Err(EffectError::NotSimulated { spelling: parameter.spelling, why });
            }
        }
        Ok(())
    }

    /// Returns these effects, and those of `under` where these are off.
    #[must_use]
    pub fn over(mut self, under: Self) -> Self {
        let line = self.line();
        for (kind, below) in EffectKind::ALL.into_iter().zip(under.values) {
            if is_line(kind) && line.is_some_and(|line| line != kind) {
                continue;
            }
            for (slot, below) in self.values[kind as usize].iter_mut().zip(below) {
                *slot = slot.or(below);
            }
        }
        self
    }

    /// The law of the contact line that is on.
    fn line(&self) -> Option<EffectKind> {
        EffectKind::ALL.into_iter().find(|kind| is_line(*kind) && self.values(*kind) != [None; PARAMETERS])
    }
}

/// Whether `kind` is a law of the contact line, of which there can be one.
fn is_line(kind: EffectKind) -> bool {
    matches!(kind.effect().slot, Slot::Catch(_))
}

impl std::fmt::Debug for Effects {
    /// Writes the list of spellings and values that are on.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let on = self.on();
        f.debug_list().entries(on.iter().map(|(parameter, value)| (parameter.spelling, value))).finish()
    }
}

#[cfg(test)]
mod tests;
