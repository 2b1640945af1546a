//! Named effects: what may be missing between the plain liquid and the measured one.
//!
//! Each effect has a file with its slot, its parameters with units and range, and its formula with the
//! source; adding one is that file and a line in [`LIBRARY`]. The slot says where it may act, and by that
//! the laws stay exact whatever the parameters are:
//!
//! | slot | enters as | type |
//! |---|---|---|
//! | [`Slot::Stiffness`], [`Slot::First`] | energy | E |
//! | [`Slot::Liquid`], [`Slot::Line`] | friction G >= 0 | M |
//! | [`Slot::Memory`], [`Slot::Catch`] | an inner variable with energy and friction | E and M |
//! | [`Slot::Port`] | what the moved glass does to the liquid | port |
//! | [`Slot::View`], [`Slot::Vessel`] | what is measured, never the state; the fill | view |
//!
//! A friction below zero cannot be said in these slots: energy that seems to come from nowhere has to be a
//! port or a view.

mod actuation_delay;
mod actuation_gain;
mod camera_latency;
mod camera_pitch;
mod camera_slope;
mod contact_line;
mod container_tilt;
mod depth_scale;
mod detuning;
mod fill;
mod foam;
mod pinned_line;
mod shear_thinning;
mod surface_film;
mod surface_tension;
mod swirl;
mod vertical_acceleration;
mod viscoelastic;
mod viscosity;
mod wall_slip;
mod yield_stress;

#[cfg(test)]
pub(crate) mod tests;

use crate::reduced::{Cylinder, Mode, Rheology};

/// Most parameters of an effect.
pub const PARAMETERS: usize = 2;

/// Most effects at once in a model.
pub const MOST: usize = 4;

/// Values of an effect's parameters; those that it does not have are zero.
pub type Values = [f64; PARAMETERS];

/// Every effect.
pub static LIBRARY: [Entry; 21] = [
    viscosity::ENTRY,
    wall_slip::ENTRY,
    surface_film::ENTRY,
    shear_thinning::ENTRY,
    yield_stress::ENTRY,
    contact_line::ENTRY,
    foam::ENTRY,
    surface_tension::ENTRY,
    pinned_line::ENTRY,
    viscoelastic::ENTRY,
    detuning::ENTRY,
    swirl::ENTRY,
    container_tilt::ENTRY,
    vertical_acceleration::ENTRY,
    actuation_gain::ENTRY,
    actuation_delay::ENTRY,
    fill::ENTRY,
    camera_latency::ENTRY,
    depth_scale::ENTRY,
    camera_pitch::ENTRY,
    camera_slope::ENTRY,
];

/// The effect called `name`.
#[must_use]
pub fn find(name: &str) -> Option<&'static Entry> {
    LIBRARY.iter().find(|entry| entry.name == name)
}

/// What can be told apart before the name can.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// How it is looked at, how it stands and how much of it there is.
    View,
    /// When things happen: clocks.
    Timing,
    /// How it is moved.
    Actuation,
    /// What pulls the surface back.
    Stiffness,
    /// Damping that is the same at every amplitude.
    Damping,
    /// Damping that depends on the amplitude.
    AmplitudeDamping,
    /// Shape of the wave and coupling of its directions.
    Shape,
}

impl Class {
    /// In words.
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

    /// Whether it is something that happens in the liquid, and not how that is looked at, timed or moved.
    #[must_use]
    pub fn in_liquid(self) -> bool {
        !matches!(self, Self::View | Self::Timing | Self::Actuation)
    }
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value at which the effect is not there.
    pub neutral: f64,
    /// Least and largest physical value.
    pub range: (f64, f64),
    /// A size that matters: where fits start from, on either side of the neutral value.
    pub typical: f64,
    /// What it is in words.
    pub meaning: &'static str,
}

/// A stored energy with friction: `z' = v - r z`, energy `k z^2/2`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branch {
    /// Stiffness k, N/m; 0 is no branch.
    pub stiffness: f64,
    /// Relaxation r.
    pub relax: Relax,
}

/// How an inner variable forgets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Relax {
    /// It does not.
    #[default]
    Never,
    /// With a time (s): `r = 1/lambda`.
    Time(f64),
    /// With a way (m): `r = |v|/reach`, dry friction with a spring before it.
    Path(f64),
}

/// Shape of the first mode's energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct First {
    /// Softening kappa, `w = w1 (1 - kappa A^2/R^2)`.
    pub softening: f64,
    /// Coupling of x and y, in units of the mode's stiffness.
    pub coupling: f64,
}

/// What the glass's motion becomes before it drives the liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Factor on what the glass is said to do.
    pub gain: f64,
    /// How much later it does it, s.
    pub delay_s: f64,
    /// Constant inclination towards +x, rad.
    pub tilt_rad: f64,
    /// Part of the recorded inclination that is felt, beside that of the baseline.
    pub tilt_share: f64,
    /// Constant acceleration upwards, m/s2.
    pub lift_m_s2: f64,
    /// Part of the recorded vertical acceleration that is felt, beside that of the baseline.
    pub lift_share: f64,
}

impl Default for Port {
    fn default() -> Self {
        Self { gain: 1.0, delay_s: 0.0, tilt_rad: 0.0, tilt_share: 0.0, lift_m_s2: 0.0, lift_share: 0.0 }
    }
}

/// What the surface becomes before it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// How much later the picture is than its time says, s.
    pub latency_s: f64,
    /// Factor on every length.
    pub scale: f64,
    /// Pitch of the camera that is not known of, rad.
    pub pitch_rad: f64,
    /// Roll of the camera that is not known of, rad.
    pub slope_rad: f64,
}

impl Default for View {
    fn default() -> Self {
        Self { latency_s: 0.0, scale: 1.0, pitch_rad: 0.0, slope_rad: 0.0 }
    }
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug)]
pub enum Slot {
    /// Energy: stiffness that a mode gains, N/m.
    Stiffness(fn(&Values, &Mode, &Cylinder) -> f64),
    /// Energy of the first mode.
    First(fn(&Values) -> First),
    /// Friction of the liquid.
    Liquid(fn(&Values, &mut Rheology)),
    /// Friction along the contact line, N s/m, at an amplitude of its speed (m/s).
    Line(fn(&Values, f64, &Cylinder) -> f64),
    /// An inner variable of each mode.
    Memory(fn(&Values, &Mode, &Cylinder) -> Branch),
    /// An inner variable of the contact line.
    Catch(fn(&Values, &Cylinder) -> Branch),
    /// The port.
    Port(fn(&Values, &mut Port)),
    /// The view.
    View(fn(&Values, &mut View)),
    /// The fill.
    Vessel(fn(&Values, &mut Cylinder)),
}

/// One line of the library.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name.
    pub name: &'static str,
    /// Class.
    pub class: Class,
    /// Its parameters, at most [`PARAMETERS`].
    pub parameters: &'static [Parameter],
    /// In a sentence.
    pub about: &'static str,
    /// Source of the formula.
    pub source: &'static str,
    /// Where it acts.
    pub slot: Slot,
}

impl Entry {
    /// Whether it is geometry, how the liquid is looked at, timed, stood and moved, whose formula is exact. A
    /// fill is not: beside the level it changes the waves.
    #[must_use]
    pub fn is_geometry(&self) -> bool {
        matches!(self.slot, Slot::Port(_) | Slot::View(_)) && !self.class.in_liquid()
    }

    /// The values at which the effect is not there.
    #[must_use]
    pub fn neutral(&self) -> Values {
        let mut values = [0.0; PARAMETERS];
        values.iter_mut().zip(self.parameters).for_each(|(value, parameter)| *value = parameter.neutral);
        values
    }
}

/// An effect with its values.
#[derive(Clone, Copy, Debug)]
pub struct Active {
    /// Which.
    pub entry: &'static Entry,
    /// Its values.
    pub values: Values,
}
