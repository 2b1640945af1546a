//! Effects in the particle simulator: which of its laws carries an effect.
//!
//! The laws themselves stand in the simulator's crate, which matches [`Law`] exhaustively twice: where a law acts, and
//! where it is validated against theory. A law without either does not compile.

/// Law of the particle simulator that carries an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Law {
    /// Consistency k of the liquid's stress.
    Viscosity,
    /// Flow index n of the liquid's stress.
    ShearThinning,
    /// Yield stress of the liquid.
    YieldStress,
    /// Slip length of the wall.
    WallSlip,
    /// Energy of the surface's area.
    SurfaceTension,
    /// Spring along the wall that yields to dry friction.
    ContactLine,
    /// The same spring, which does not yield within the amplitudes of a glass.
    PinnedLine,
    /// Friction along the wall.
    Foam,
    /// Maxwell stress on every particle.
    Viscoelastic,
    /// Inclined body force.
    ContainerTilt,
    /// Body force along the axis.
    VerticalAcceleration,
    /// Height of the liquid at rest.
    Fill,
}

impl Law {
    /// Returns how many leading parameters of the effect the law takes.
    #[must_use]
    pub fn parameters(self) -> usize {
        match self {
            Self::ContactLine | Self::Viscoelastic => 2,
            Self::Viscosity
            | Self::ShearThinning
            | Self::YieldStress
            | Self::WallSlip
            | Self::SurfaceTension
            | Self::PinnedLine
            | Self::Foam
            | Self::ContainerTilt
            | Self::VerticalAcceleration
            | Self::Fill => 1,
        }
    }
}

/// Presence of an effect in the particle simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulator {
    /// Carried by this law.
    Law(Law),
    /// Not carried, with the reason and a remedy.
    Absent(&'static str),
}

impl Simulator {
    /// Returns the law that carries the effect.
    #[must_use]
    pub fn law(self) -> Option<Law> {
        match self {
            Self::Law(law) => Some(law),
            Self::Absent(_) => None,
        }
    }
}
