//! Set-up of a simulation and its limits: the glass, the liquid, the spacing, and the step that they allow.

mod packing;

pub(crate) use packing::{Packing, fitting_spacing};

use crate::effects::{self, Laws, glass_with, liquid_with, rise_m};
use crate::forces::{MOST, reach};
use crate::particles::{Kernel, SMOOTHING};
use meniscus_data::effects::Effects;
use meniscus_data::glass::WallShape;
use meniscus_data::liquids::Liquid;
use meniscus_data::recording::Glass;

/// Numerical speed of sound, m/s: ten times the fastest flow, so that density varies by about 1 %.
pub(crate) const SOUND_M_S: f64 = 7.0;

/// Courant number `c0 dt / h` of the longest step.
const COURANT: f64 = 0.8;

/// Longest step as a part of the viscous limit `h^2 / nu`.
const VISCOUS: f64 = 0.08;

/// `lambda h^2/nu` of [`Friction`](crate::forces::Friction) at a free surface; 23 in the bulk.
const FASTEST: f64 = 70.0;

/// Why a simulation could not start or go on.
#[derive(Debug, PartialEq)]
pub enum Error {
    /// The glass or the particle spacing cannot be simulated.
    Setup(String),
    /// Particles left the glass.
    Escaped {
        /// The first of them.
        particle: usize,
        /// Its position, m.
        position_m: [f64; 3],
        /// When, s.
        time_s: f64,
        /// Number of particles outside at that time.
        count: usize,
    },
    /// A position is no longer a finite number.
    NotFinite {
        /// The first such particle.
        particle: usize,
        /// When, s.
        time_s: f64,
    },
    /// The caller raised the flag that ends the simulation.
    Stopped,
}

impl std::fmt::Display for Error {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Setup(why) => write!(f, "{why}"),
            Self::Escaped { particle, position_m: [x, y, z], time_s, count } => write!(
                f,
                "{count} particle(s) left the glass at {time_s:.4} s, the first is {particle} at ({:.1}, {:.1}, \
                 {:.1}) mm: move the glass more gently, or use a smaller spacing",
                1e3 * x,
                1e3 * y,
                1e3 * z
            ),
            Self::NotFinite { particle, time_s } => write!(
                f,
                "particle {particle} has no finite position at {time_s:.4} s: the simulation blew up and was stopped"
            ),
            Self::Stopped => write!(f, "the simulation was stopped before its end: there is no recording"),
        }
    }
}

impl std::error::Error for Error {}

/// Set-up of a simulation, without the motion.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The glass and its fill.
    pub glass: Glass,
    /// The liquid.
    pub liquid: Liquid,
    /// Spacing of the particles, m; the nearest with a whole number of rings in the radius is taken.
    pub spacing_m: f64,
    /// Seed of the packing.
    pub seed: u64,
    /// Whether the liquid sticks to the wall (or slips by `wall_slip`); it slips freely otherwise.
    pub no_slip: bool,
    /// Effects that are on, beside those of the liquid and before them.
    pub effects: Effects,
    /// Step of time, s, where it is to be shorter than the simulator would take.
    pub step_s: Option<f64>,
}

impl Setup {
    /// The setup with every effect that replaces a number put in: liquid, fill and slip as they will be.
    #[must_use]
    pub fn resolved(&self) -> Self {
        let effects = self.effects.over(self.liquid.effects);
        let laws = Laws::of(&effects);
        Self {
            glass: glass_with(&laws, self.glass),
            liquid: liquid_with(&laws, &self.liquid),
            no_slip: self.no_slip && laws.slip_m.is_finite(),
            effects,
            ..*self
        }
    }

    /// The longest step that sound, viscosity and the effects allow at this spacing, s.
    ///
    /// # Errors
    /// When glass, spacing or effects are out of range.
    pub fn longest_step_s(&self) -> Result<f64, Error> {
        let setup = self.resolved();
        check(&setup)?;
        Ok(longest_step(&kernel(&setup), &setup))
    }
}

/// The kernel of a resolved setup.
pub(crate) fn kernel(setup: &Setup) -> Kernel {
    Kernel::new(SMOOTHING * fitting_spacing(&setup.glass, setup.spacing_m))
}

/// The longest step allowed by sound, by viscosity and by the effects of a resolved setup, s.
pub(crate) fn longest_step(kernel: &Kernel, setup: &Setup) -> f64 {
    let viscous =
        if thick(kernel, setup) { reach(MOST) / FASTEST * spreading_s(kernel, setup) } else { f64::INFINITY };
    let effects = effects::longest_step(&Laws::of(&setup.effects), &setup.glass, setup.liquid.density_kg_m3);
    viscous.min(sound_step(kernel)).min(effects)
}

/// Whether the friction of a resolved setup would need shorter explicit steps than sound, and is done in stages.
pub(crate) fn thick(kernel: &Kernel, setup: &Setup) -> bool {
    VISCOUS * spreading_s(kernel, setup) < sound_step(kernel)
}

/// `h^2/nu` at the largest viscosity, s.
fn spreading_s(kernel: &Kernel, setup: &Setup) -> f64 {
    let nu = setup.liquid.rheology.largest() / setup.liquid.density_kg_m3;
    if nu > 0.0 { kernel.h * kernel.h / nu } else { f64::INFINITY }
}

/// The longest step that sound allows, s.
fn sound_step(kernel: &Kernel) -> f64 {
    COURANT * kernel.h / SOUND_M_S
}

/// Whether a resolved setup can be simulated.
pub(crate) fn check(setup: &Setup) -> Result<(), Error> {
    setup.effects.require_simulated().map_err(|error| Error::Setup(format!("{error}")))?;
    let Glass { fill_m, rim_m, wall, .. } = setup.glass;
    let radius_m = setup.glass.size_m();
    if !(0.005..=0.2).contains(&radius_m)
        || !(0.005..=0.3).contains(&fill_m)
        || !(fill_m..=0.4).contains(&rim_m)
    {
        return Err(Error::Setup(format!(
            "a glass of radius {radius_m} m, fill {fill_m} m and rim {rim_m} m is out of range: radius 0.005 to 0.2, \
             fill 0.005 to 0.3, rim from the fill to 0.4"
        )));
    }
    match wall {
        WallShape::Straight { taper } => {
            if !(-0.2..=0.2).contains(&taper) || !(0.005..=0.2).contains(&setup.glass.radius_at(rim_m)) {
                return Err(Error::Setup(format!(
                    "a taper of {taper} is out of range: -0.2 to 0.2, and a radius of 0.005 to 0.2 m at the rim"
                )));
            }
        }
        WallShape::Curved(profile) => {
            if rim_m > profile.top_m() {
                return Err(Error::Setup(format!(
                    "the rim at {rim_m} m is above the last point of the profile at {} m: give the profile up to the rim",
                    profile.top_m()
                )));
            }
        }
    }
    let rise_m = rise_m(&Laws::of(&setup.effects), &setup.glass);
    if fill_m + rise_m > rim_m || rise_m > fill_m {
        return Err(Error::Setup(format!(
            "the surface at rest of an inclined glass would stand {:.1} mm above and below the fill of {:.1} mm: it \
             must stay below the rim at {:.1} mm and above the bottom",
            1e3 * rise_m,
            1e3 * fill_m,
            1e3 * rim_m
        )));
    }
    if !(0.0015..=0.25 * radius_m).contains(&setup.spacing_m) {
        return Err(Error::Setup(format!(
            "a particle spacing of {:.2} mm is out of range: 1.5 mm to a quarter of the radius, {:.2} mm",
            1e3 * setup.spacing_m,
            250.0 * radius_m
        )));
    }
    if let Some(step_s) = setup.step_s {
        let longest = longest_step(&kernel(setup), setup);
        if !(0.01 * longest..=longest).contains(&step_s) {
            return Err(Error::Setup(format!(
                "a step of {:.2} us is out of range: {:.2} to {:.2} us at this spacing, viscosity and effects; a longer \
                 one would blow up",
                1e6 * step_s,
                1e4 * longest,
                1e6 * longest
            )));
        }
    }
    Ok(())
}

/// A glass half as high as that of the recordings, with coarse particles of a liquid that sticks to it, for tests.
#[cfg(test)]
pub(crate) fn small_glass(density_kg_m3: f64, rheology: meniscus_data::liquids::Rheology) -> Setup {
    let liquid = Liquid { name: "x".into(), density_kg_m3, rheology, effects: Effects::default() };
    Setup {
        glass: Glass { radius_m: 0.035, fill_m: 0.035, rim_m: 0.06, wall: WallShape::UPRIGHT },
        liquid,
        spacing_m: 0.007,
        seed: 0,
        no_slip: true,
        effects: Effects::default(),
        step_s: None,
    }
}
