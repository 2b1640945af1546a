//! Slots: the places in the reduced model where an effect may act.

use super::parameter::Values;
use crate::reduced::{Cylinder, Maxwell, Rheology, SloshMode};

/// A stored energy with friction: `z' = v - r z`, energy `k z^2/2`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Branch {
    /// Stiffness k, N/m; 0 is no branch.
    pub stiffness: f64,
    /// Relaxation r.
    pub relax: Relax,
}

/// Relaxation of an inner variable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Relax {
    /// None.
    #[default]
    Never,
    /// With a time (s): `r = 1/lambda`.
    Time(f64),
    /// Over a path (m): `r = |v|/reach`, dry friction with a spring before it.
    Path(f64),
}

impl Relax {
    /// Rate of relaxation (1/s) while the wall's liquid moves with `speed` (m/s).
    #[must_use]
    pub fn rate(self, speed: f64) -> f64 {
        match self {
            Self::Never => 0.0,
            Self::Time(lambda_s) => 1.0 / lambda_s.max(1e-6),
            Self::Path(reach_m) => speed / reach_m.max(1e-9),
        }
    }
}

/// Shape of the first mode's energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FirstModeEnergy {
    /// Softening kappa, `w = w1 (1 - kappa A^2/R^2)`.
    pub softening: f64,
    /// Coupling of x and y, in units of the mode's stiffness.
    pub coupling: f64,
}

/// Changes to the glass's motion before it drives the liquid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Port {
    /// Factor on the commanded motion of the glass.
    pub gain: f64,
    /// Delay behind the commanded motion, s.
    pub delay_s: f64,
    /// Constant inclination towards +x, rad.
    pub tilt_rad: f64,
    /// Part of the recorded inclination that acts, beside that of the baseline.
    pub tilt_share: f64,
    /// Constant acceleration upwards, m/s2.
    pub lift_m_s2: f64,
    /// Part of the recorded vertical acceleration that acts, beside that of the baseline.
    pub lift_share: f64,
}

impl Default for Port {
    fn default() -> Self {
        Self { gain: 1.0, delay_s: 0.0, tilt_rad: 0.0, tilt_share: 0.0, lift_m_s2: 0.0, lift_share: 0.0 }
    }
}

/// Changes to the surface before it is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Delay of the image behind its time stamp, s.
    pub latency_s: f64,
    /// Factor on every length.
    pub scale: f64,
    /// Unknown pitch of the camera, rad.
    pub pitch_rad: f64,
    /// Unknown roll of the camera, rad.
    pub slope_rad: f64,
}

impl Default for View {
    fn default() -> Self {
        Self { latency_s: 0.0, scale: 1.0, pitch_rad: 0.0, slope_rad: 0.0 }
    }
}

/// Place where an effect acts.
#[derive(Clone, Copy, Debug)]
pub enum Slot {
    /// Energy: stiffness that a mode gains, N/m.
    Stiffness(fn(&Values, &SloshMode, &Cylinder) -> f64),
    /// Energy of the first mode.
    FirstMode(fn(&Values) -> FirstModeEnergy),
    /// Friction of the liquid.
    Liquid(fn(&Values, &mut Rheology)),
    /// Friction along the contact line, N s/m, at an amplitude of its speed (m/s).
    Line(fn(&Values, f64, &Cylinder) -> f64),
    /// A stress that relaxes: an inner variable of each mode, and another layer at the wall.
    Memory(fn(&Values) -> Maxwell),
    /// An inner variable of the contact line.
    Catch(fn(&Values, &Cylinder) -> Branch),
    /// The port.
    Port(fn(&Values, &mut Port)),
    /// The view.
    View(fn(&Values, &mut View)),
    /// The glass and its fill.
    Vessel(fn(&Values, &mut Cylinder)),
}
