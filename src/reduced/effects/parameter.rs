//! Parameters of effects: SI value for people and files, coordinate for the reduced model, and the conversion.
//!
//! A person states a value that can be measured: a viscosity in Pa s^n, a fill in m. The reduced model counts three of
//! them from the glass and the liquid that it was given, because only that difference changes its step:
//!
//! ```text
//! viscosity     coordinate = k/k0         k0 stated consistency, Pa s^n
//! radius        coordinate = R - R0       R0 stated inner radius, m
//! fill          coordinate = h - h0       h0 stated height at rest, m
//! all others    coordinate = value
//! ```

/// Most parameters of an effect.
pub const PARAMETERS: usize = 2;

/// Coordinates of an effect's parameters in the reduced model; those that it does not have are zero.
///
/// A parameter's [`Reference`] converts between coordinate and SI value.
pub type Values = [f64; PARAMETERS];

/// Glass and liquid as stated: where relative coordinates are counted from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stated {
    /// Viscosity or consistency k0, Pa s^n.
    pub consistency_pa_sn: f64,
    /// Inner radius of the glass R0, m.
    pub radius_m: f64,
    /// Height of the liquid at rest h0, m.
    pub fill_m: f64,
}

/// Relation of a coordinate of the reduced model to the SI value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The value itself.
    Absolute,
    /// The value over the stated consistency.
    Consistency,
    /// The value less the stated radius.
    Radius,
    /// The value less the stated height at rest.
    Fill,
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name within its effect.
    pub name: &'static str,
    /// Name on the command line and in files: the effect's name for the first parameter, `EFFECT_NAME` for the second.
    pub spelling: &'static str,
    /// Unit of the SI value.
    pub unit: &'static str,
    /// Relation of the coordinate to the SI value.
    pub reference: Reference,
    /// Least and largest SI value that has a meaning.
    pub admissible: (f64, f64),
    /// Coordinate at which the effect is absent.
    pub neutral: f64,
    /// Least and largest coordinate for which the reduced model's formula holds.
    pub range: (f64, f64),
    /// Coordinate offset of a size that matters: where fits start from, on either side of the neutral coordinate.
    pub typical: f64,
    /// Meaning of the SI value.
    pub meaning: &'static str,
}

impl Parameter {
    /// Returns the coordinate of the SI value `value`.
    #[must_use]
    pub fn to_coordinate(&self, value: f64, stated: &Stated) -> f64 {
        match self.reference {
            Reference::Absolute => value,
            Reference::Consistency => value / stated.consistency_pa_sn,
            Reference::Radius => value - stated.radius_m,
            Reference::Fill => value - stated.fill_m,
        }
    }

    /// Returns the SI value of `coordinate`.
    #[must_use]
    pub fn to_value(&self, coordinate: f64, stated: &Stated) -> f64 {
        match self.reference {
            Reference::Absolute => coordinate,
            Reference::Consistency => stated.consistency_pa_sn * coordinate,
            Reference::Radius => stated.radius_m + coordinate,
            Reference::Fill => stated.fill_m + coordinate,
        }
    }

    /// Returns the name of the coordinate; the parameter's own where both are the same number.
    #[must_use]
    pub fn coordinate_name(&self) -> &'static str {
        match self.reference {
            Reference::Absolute => self.name,
            Reference::Consistency => "factor",
            Reference::Radius | Reference::Fill => "excess",
        }
    }

    /// Returns the unit of the coordinate.
    #[must_use]
    pub fn coordinate_unit(&self) -> &'static str {
        match self.reference {
            Reference::Absolute | Reference::Radius | Reference::Fill => self.unit,
            Reference::Consistency => "1",
        }
    }

    /// Checks that the SI value `value` has a meaning.
    ///
    /// # Errors
    /// [`ValueError`] with the admissible range.
    pub fn check(&self, value: f64) -> Result<(), ValueError> {
        let (least, largest) = self.admissible;
        if least <= value && value <= largest {
            return Ok(());
        }
        Err(self.refused(value, self.admissible, Limit::Meaning))
    }

    /// The error for `value` outside of `range`.
    pub(super) fn refused(&self, value: f64, range: (f64, f64), limit: Limit) -> ValueError {
        let Self { spelling, unit, meaning, .. } = *self;
        ValueError { spelling, unit, meaning, value, range, limit }
    }
}

/// Limit that a value lies outside of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// Beyond it the value has no meaning.
    Meaning,
    /// Beyond it the formula of the reduced model does not hold for the stated glass and liquid.
    ReducedModel,
}

/// Value of a parameter outside of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueError {
    /// Spelling of the parameter.
    pub spelling: &'static str,
    /// Unit of the value.
    pub unit: &'static str,
    /// Meaning of the value.
    pub meaning: &'static str,
    /// The SI value that was given.
    pub value: f64,
    /// Least and largest SI value.
    pub range: (f64, f64),
    /// Limit that it lies outside of.
    pub limit: Limit,
}

impl core::fmt::Display for ValueError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { spelling, unit, meaning, value, range, limit } = *self;
        let (least, largest) = range;
        write!(f, "effect {spelling} = {value} {unit} is out of range: {least} to {largest} {unit}")?;
        if limit == Limit::ReducedModel {
            write!(f, " in the reduced model of this glass and liquid")?;
        }
        write!(f, " ({meaning})")
    }
}

impl core::error::Error for ValueError {}
