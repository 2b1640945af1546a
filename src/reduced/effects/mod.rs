//! The list of effects: physical differences between the plain liquid and a measured one.
//!
//! Each effect has one file with one [`Effect`]: name, parameters with SI unit, range and source, and the answer to every
//! consumer. Adding one is that file, its `mod` line and its line in the list below. The build then fails until each
//! consumer that matches [`EffectKind`] or [`Law`] has answered.
//!
//! | field | consumer |
//! |---|---|
//! | [`Effect::slot`] | the reduced model, discovery, the flashed model |
//! | [`Effect::simulator`] | the particle simulator and its validation |
//! | [`Effect::free`], [`Effect::twin`] | fits and verdicts of discovery |
//! | [`Effect::trial`] | hidden trials of the discovery study |
//!
//! `NAME=VALUE` has one meaning on every command line and in every file: the SI value of the parameter. The reduced model
//! counts some parameters from the stated glass and liquid; [`Parameter::to_coordinate`] is the only place that converts.
//! A weight blob stores coordinates beside the liquid and fill that they are counted from.
//!
//! The slot says where an effect may act, and by that the laws of thermodynamics stay exact for any parameters:
//!
//! | slot | enters as | type |
//! |---|---|---|
//! | [`Slot::Stiffness`], [`Slot::FirstMode`] | energy | E |
//! | [`Slot::Liquid`], [`Slot::Line`] | friction G >= 0 | M |
//! | [`Slot::Memory`], [`Slot::Catch`] | an inner variable with energy and friction | E and M |
//! | [`Slot::Port`] | change of the glass's motion before it drives the liquid | port |
//! | [`Slot::View`], [`Slot::Vessel`] | change of the measurement, never of the state; the glass and its fill | view |
//!
//! These slots admit no negative friction: energy that seems to come from nowhere has to be a port or a view.

mod actuation_delay;
mod actuation_gain;
mod camera_latency;
mod camera_pitch;
mod camera_slope;
mod contact_line;
mod container_tilt;
mod definition;
mod depth_scale;
mod detuning;
mod fill;
mod foam;
mod held_tension;
mod parameter;
mod pinned_line;
mod radius;
mod shear_thinning;
mod simulator;
mod slot;
mod stuck_line;
mod surface_film;
mod surface_tension;
mod swirl;
mod vertical_acceleration;
mod viscoelastic;
mod viscosity;
mod wall_slip;
mod yield_stress;

#[cfg(test)]
mod parameter_tests;
#[cfg(test)]
pub(crate) mod tests;

pub use definition::{Active, Class, Effect, FreeParameters, MOST, Recorded};
pub use parameter::{Limit, PARAMETERS, Parameter, Reference, Stated, ValueError, Values};
pub use simulator::{Law, Simulator};
pub use slot::{Branch, FirstModeEnergy, Port, Relax, Slot, View};

/// The name of [`Effect`] in signatures that predate it.
pub use definition::Effect as Entry;

/// Makes the enum, the list and the way from one to the other, so that they cannot disagree.
macro_rules! list {
    ($($(#[$doc:meta])* $kind:ident = $file:ident,)*) => {
        /// Identity of an effect, for exhaustive matches.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum EffectKind {
            $($(#[$doc])* $kind,)*
        }

        impl EffectKind {
            /// Every kind, in the order of [`LIBRARY`].
            pub const ALL: [Self; Self::COUNT] = [$(Self::$kind,)*];

            /// Number of effects.
            pub const COUNT: usize = [$(Self::$kind),*].len();

            /// Returns the definition.
            #[must_use]
            pub fn effect(self) -> &'static Effect {
                match self {
                    $(Self::$kind => &LIBRARY[Self::$kind as usize],)*
                }
            }
        }

        /// Every effect.
        pub static LIBRARY: [Effect; EffectKind::COUNT] = [$($file::EFFECT,)*];
    };
}

list! {
    /// Viscosity.
    Viscosity = viscosity,
    /// Slip at the wall.
    WallSlip = wall_slip,
    /// Film on the surface.
    SurfaceFilm = surface_film,
    /// Contact line that a sticking wall holds.
    StuckLine = stuck_line,
    /// Flow index.
    ShearThinning = shear_thinning,
    /// Yield stress.
    YieldStress = yield_stress,
    /// Sliding contact line.
    ContactLine = contact_line,
    /// Foam on the wall.
    Foam = foam,
    /// Surface tension.
    SurfaceTension = surface_tension,
    /// Pinned contact line.
    PinnedLine = pinned_line,
    /// Surface tension with a held contact line.
    HeldTension = held_tension,
    /// Viscoelastic relaxation.
    Viscoelastic = viscoelastic,
    /// Amplitude detuning.
    Detuning = detuning,
    /// Coupling of the two directions.
    Swirl = swirl,
    /// Inclined glass.
    ContainerTilt = container_tilt,
    /// Vertical acceleration.
    VerticalAcceleration = vertical_acceleration,
    /// Gain of the glass's motion.
    ActuationGain = actuation_gain,
    /// Delay of the glass's motion.
    ActuationDelay = actuation_delay,
    /// Height of the liquid at rest.
    Fill = fill,
    /// Inner radius of the glass.
    Radius = radius,
    /// Latency of the camera.
    CameraLatency = camera_latency,
    /// Scale of the camera's lengths.
    DepthScale = depth_scale,
    /// Pitch of the camera.
    CameraPitch = camera_pitch,
    /// Roll of the camera.
    CameraSlope = camera_slope,
}

impl EffectKind {
    /// Returns the name on the command line and in files.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.effect().name
    }
}

/// Returns the effect called `name`.
///
/// ```
/// use meniscus::reduced::effects::{EffectKind, find};
///
/// assert_eq!(find("viscosity").map(|effect| effect.kind), Some(EffectKind::Viscosity));
/// assert!(find("viscosty").is_none());
/// ```
#[must_use]
pub fn find(name: &str) -> Option<&'static Effect> {
    LIBRARY.iter().find(|entry| entry.name == name)
}

/// Returns the effect and the index of its parameter that `spelling` names: `NAME` or `NAME_PARAMETER`.
///
/// ```
/// use meniscus::reduced::effects::find_parameter;
///
/// // The second parameter of the contact line is spelled with the effect before it.
/// let (effect, index) = find_parameter("contact_line_reach").unwrap();
/// assert_eq!((effect.name, index), ("contact_line", 1));
/// assert_eq!(effect.parameters[index].unit, "m");
/// ```
#[must_use]
pub fn find_parameter(spelling: &str) -> Option<(&'static Effect, usize)> {
    LIBRARY.iter().find_map(|effect| {
        let which = effect.parameters.iter().position(|parameter| parameter.spelling == spelling)?;
        Some((effect, which))
    })
}
