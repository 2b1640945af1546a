//! Effects of the simulator by name: what a liquid or a glass may have beside the plain case, each switched on by one number.

/// The effects that are switched on; `None` is off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effects {
    /// Viscosity or consistency, Pa s^n, instead of the liquid's.
    pub viscosity: Option<f64>,
    /// Flow index n instead of the liquid's.
    pub shear_thinning: Option<f64>,
    /// Yield stress, Pa, instead of the liquid's.
    pub yield_stress: Option<f64>,
    /// Slip length b of Navier, m.
    pub wall_slip: Option<f64>,
    /// Surface tension sigma, N/m.
    pub surface_tension: Option<f64>,
    /// Force of a contact line that slides, N per metre of line.
    pub contact_line: Option<f64>,
    /// How far a contact line gives way before it slides, m.
    pub contact_line_reach: Option<f64>,
    /// Coefficient of the foam's friction, N/m (s/m)^(2/3).
    pub foam: Option<f64>,
    /// Modulus G of the Maxwell branch, Pa.
    pub viscoelastic: Option<f64>,
    /// Relaxation time lambda of the Maxwell branch, s.
    pub viscoelastic_time: Option<f64>,
    /// Angle by which the glass stands inclined towards +x, rad.
    pub container_tilt: Option<f64>,
    /// Constant upward acceleration of the room, m/s2.
    pub vertical_acceleration: Option<f64>,
    /// Height of the liquid at rest instead of the glass's, m.
    pub fill: Option<f64>,
}

/// One line of the table of effects.
#[derive(Clone, Copy, Debug)]
pub struct Effect {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// Unit of its value.
    pub unit: &'static str,
    /// Least and largest value.
    pub range: (f64, f64),
    /// What it does.
    pub meaning: &'static str,
    /// Where its law comes from.
    pub source: &'static str,
    slot: fn(&mut Effects) -> &mut Option<f64>,
}

/// Every effect.
pub const EFFECTS: [Effect; 13] = [
    Effect {
        name: "viscosity",
        unit: "Pa s^n",
        range: (0.0, 100.0),
        meaning: "viscosity, or consistency k, instead of the liquid's",
        source: "Newton; Herschel and Bulkley 1926",
        slot: |e| &mut e.viscosity,
    },
    Effect {
        name: "shear_thinning",
        unit: "1",
        range: (0.1, 2.0),
        meaning: "flow index n of tau = tau0 + k rate^n; below 1 the liquid thins",
        source: "Herschel and Bulkley 1926",
        slot: |e| &mut e.shear_thinning,
    },
    Effect {
        name: "yield_stress",
        unit: "Pa",
        range: (0.0, 1000.0),
        meaning: "stress tau0 below which the liquid stands",
        source: "Herschel and Bulkley 1926; Papanastasiou 1987",
        slot: |e| &mut e.yield_stress,
    },
    Effect {
        name: "wall_slip",
        unit: "m",
        range: (0.0, f64::INFINITY),
        meaning: "slip length b: u_wall = b du/dn; 0 sticks, inf slips freely",
        source: "Navier 1823",
        slot: |e| &mut e.wall_slip,
    },
    Effect {
        name: "surface_tension",
        unit: "N/m",
        range: (0.0, 2.0),
        meaning: "energy of the surface's area; the contact line is free at 90 degrees",
        source: "Lamb 1932, article 267",
        slot: |e| &mut e.surface_tension,
    },
    Effect {
        name: "contact_line",
        unit: "N/m",
        range: (0.0, 2.0),
        meaning: "force per length that holds the contact line: a spring that yields to dry friction",
        source: "Dahl 1968; Viola, Brun and Gallaire 2018",
        slot: |e| &mut e.contact_line,
    },
    Effect {
        name: "contact_line_reach",
        unit: "m",
        range: (1e-5, 0.02),
        meaning: "deflection at which the held line slides, 0.0005 unless given; with contact_line",
        source: "a property of the wall; the default is a choice",
        slot: |e| &mut e.contact_line_reach,
    },
    Effect {
        name: "foam",
        unit: "N/m (s/m)^(2/3)",
        range: (0.0, 20.0),
        meaning: "friction of foam on the wall, force per length beta |v|^(2/3)",
        source: "Bretherton 1961; Viola et al. 2016; Sauret et al. 2015",
        slot: |e| &mut e.foam,
    },
    Effect {
        name: "viscoelastic",
        unit: "Pa",
        range: (0.0, 500.0),
        meaning: "modulus G of a Maxwell stress beside the viscous one",
        source: "Maxwell 1867; Bird, Armstrong and Hassager 1987",
        slot: |e| &mut e.viscoelastic,
    },
    Effect {
        name: "viscoelastic_time",
        unit: "s",
        range: (1e-3, 100.0),
        meaning: "relaxation time lambda of that stress, 0.05 unless given; with viscoelastic",
        source: "Maxwell 1867; the default is a choice",
        slot: |e| &mut e.viscoelastic_time,
    },
    Effect {
        name: "container_tilt",
        unit: "rad",
        range: (-0.35, 0.35),
        meaning: "the glass stands inclined by this angle towards +x",
        source: "gravity turned into the frame of the glass",
        slot: |e| &mut e.container_tilt,
    },
    Effect {
        name: "vertical_acceleration",
        unit: "m/s2",
        range: (-5.0, 20.0),
        meaning: "constant upward acceleration of the glass and its room",
        source: "equivalence of gravity and acceleration",
        slot: |e| &mut e.vertical_acceleration,
    },
    Effect {
        name: "fill",
        unit: "m",
        range: (0.005, 0.3),
        meaning: "height of the liquid at rest instead of the glass's",
        source: "geometry",
        slot: |e| &mut e.fill,
    },
];

/// Why an effect was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum EffectError {
    /// No effect has this name.
    Unknown(String),
    /// Not `NAME=VALUE` with a number.
    Malformed(String),
    /// The value is out of the effect's range.
    Range {
        /// Which effect.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// Least and largest value.
        range: (f64, f64),
    },
}

impl std::fmt::Display for EffectError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Unknown(name) => {
                let names: Vec<_> = EFFECTS.iter().map(|effect| effect.name).collect();
                write!(f, "no effect is called '{name}': take one of {}", names.join(", "))
            }
            Self::Malformed(text) => {
                write!(f, "'{text}' is not an effect: write NAME=VALUE, as surface_tension=0.063")
            }
            Self::Range { name, value, unit, range: (least, largest) } => {
                write!(f, "effect {name} = {value} {unit} is out of range: {least} to {largest} {unit}")
            }
        }
    }
}

impl std::error::Error for EffectError {}

impl Effects {
    /// Switches the effect `name` on with `value`.
    ///
    /// # Errors
    /// When there is no such effect, or the value is out of its range.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), EffectError> {
        let found = EFFECTS.iter().find(|effect| effect.name == name);
        let effect = found.ok_or_else(|| EffectError::Unknown(name.into()))?;
        let (least, largest) = effect.range;
        if !(least..=largest).contains(&value) {
            return Err(EffectError::Range {
                name: effect.name,
                value,
                unit: effect.unit,
                range: effect.range,
            });
        }
        *(effect.slot)(self) = Some(value);
        Ok(())
    }

    /// Switches on what `text` says: `NAME=VALUE`.
    ///
    /// # Errors
    /// As for [`Self::set`], or when the text is of another form.
    pub fn parse(&mut self, text: &str) -> Result<(), EffectError> {
        let malformed = || EffectError::Malformed(text.into());
        let (name, value) = text.split_once('=').ok_or_else(malformed)?;
        self.set(name.trim(), value.trim().parse().map_err(|_| malformed())?)
    }

    /// The effects that are on, with their values, in the order of [`EFFECTS`].
    #[must_use]
    pub fn on(mut self) -> Vec<(&'static Effect, f64)> {
        EFFECTS.iter().filter_map(|effect| (effect.slot)(&mut self).map(|value| (effect, value))).collect()
    }

    /// These effects, and those of `under` where these are off.
    #[must_use]
    pub fn over(mut self, mut under: Self) -> Self {
        for effect in &EFFECTS {
            let below = *(effect.slot)(&mut under);
            let slot = (effect.slot)(&mut self);
            *slot = slot.or(below);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_has_a_field_of_its_own() {
        let mut effects = Effects::default();
        for (index, effect) in EFFECTS.iter().enumerate() {
            effects.set(effect.name, effect.range.0).expect("the least value is allowed");
            assert_eq!(effects.on().len(), index + 1, "{}", effect.name);
        }
        assert_eq!(Effects::default().over(effects), effects);
    }

    #[test]
    fn wrong_effects_are_refused_with_name_value_unit_and_range() {
        let refusal = |text: &str| format!("{}", Effects::default().parse(text).expect_err(text));
        assert!(refusal("viscosity=-1").contains("viscosity = -1 Pa s^n is out of range: 0 to 100"));
        assert!(refusal("surface_tension=nan").contains("NaN"));
        assert!(refusal("colour=3").contains("no effect is called 'colour': take one of viscosity"));
        assert!(refusal("foam").contains("NAME=VALUE") && refusal("foam=much").contains("NAME=VALUE"));
    }
}
