//! Settled glass: the arrangement of the particles at rest, from which every simulation in that glass starts.
//!
//! A packing of rings is not at rest: it relaxes for 1.5 s of simulated time ([`relax`]), 5 s of processor time at a
//! spacing of 5 mm. The result depends on the glass, the spacing, the seed and the direction of gravity, and hardly on
//! the liquid, so that one liquid settles for all: of 1000 kg/m3 and [`VISCOSITY_PA_S`], without effects on wall and
//! surface. Masses and densities scale with the density of rest:
//! ```text
//! m = m_s rho_0/1000      rho = rho_s rho_0/1000      p = c_0^2 (rho - rho_0)      V = m/rho      v = 0
//! ```
//! Hydrostatic compression is `g depth/c_0^2`, whatever the density. Liquids whose effects are to be compared then
//! start from the same particles.
//!
//! | file | content |
//! |---|---|
//! | `relax` | the packing comes to rest |
//! | `kept` | settled glasses in memory and on disk |

mod kept;
mod relax;

pub use kept::keep_settled_in;
pub(crate) use relax::check_running;

use crate::particles::{Fluid, Particle};
use crate::setup::{Packing, SOUND_M_S, fitting_spacing};
use crate::{Error, Setup, Simulator};
use meniscus::reduced::effects::EffectKind;
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::effects::Effects;
use meniscus_data::liquids::{Liquid, Rheology};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Density at rest of the liquid that settles, kg/m3.
const DENSITY_KG_M3: f64 = 1000.0;

/// Viscosity of the liquid that settles, Pa s.
const VISCOSITY_PA_S: f64 = 0.01;

/// Particles of a glass at rest, of a liquid of 1000 kg/m3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Settled {
    /// Position in the frame of the glass, m.
    position: Vec<[f64; 3]>,
    /// Mass, kg.
    mass: Vec<f64>,
    /// Density, kg/m3.
    density: Vec<f64>,
    /// Law of the packing ([`crate::corrections::PositionDensity::law`]).
    pub(crate) law: [f64; 4],
}

impl Settled {
    /// The particles as a liquid of `rest_density` kg/m3 and `viscosity` Pa s at rest.
    pub(crate) fn fluid(&self, rest_density: f64, viscosity: f64) -> Fluid {
        let scale = rest_density / DENSITY_KG_M3;
        let density: Vec<f64> = self.density.iter().map(|density| density * scale).collect();
        let mass: Vec<f64> = self.mass.iter().map(|mass| mass * scale).collect();
        let parts = self.position.iter().zip(&density).zip(&mass);
        let particle = |((x, density), mass): ((&[f64; 3], &f64), &f64)| Particle {
            x: *x,
            v: [0.0; 3],
            volume: mass / density,
            p: SOUND_M_S * SOUND_M_S * (density - rest_density),
        };
        Fluid {
            particle: parts.map(particle).collect(),
            viscosity: vec![viscosity; mass.len()],
            acceleration: vec![[0.0; 3]; mass.len()],
            heat: vec![0.0; mass.len()],
            mass,
            density,
        }
    }
}

/// The settled glass of a resolved, checked `setup`: a kept one, or a new one, which is kept.
///
/// # Errors
/// When settling fails, and [`Error::Stopped`] once `stop` is raised.
pub(crate) fn of(setup: &Setup, stop: &AtomicBool) -> Result<Arc<Settled>, Error> {
    let setup = settling(setup);
    let packed = packed(&setup);
    let key = kept::Key::of(&setup, &packed);
    if let Some(settled) = kept::find(&key) {
        return Ok(settled);
    }
    let settled = Arc::new(Simulator::with(&setup, packed).settle(stop)?);
    kept::keep(&key, &settled);
    Ok(settled)
}

/// The setup in which the glass of `setup` settles.
fn settling(setup: &Setup) -> Setup {
    let mut effects = Effects::default();
    // What turns or changes gravity, in which the liquid comes to rest.
    for kind in [EffectKind::ContainerTilt, EffectKind::VerticalAcceleration] {
        if let Some(value) = setup.effects.value(kind) {
            effects = effects.with(kind, value);
        }
    }
    let liquid = Liquid {
        name: "settling".into(),
        density_kg_m3: DENSITY_KG_M3,
        rheology: Rheology::newtonian(VISCOSITY_PA_S),
        effects: Effects::default(),
    };
    Setup { liquid, effects, no_slip: true, step_s: None, ..setup.clone() }
}

/// The packing of rings in hydrostatic balance: `p = rho g depth`, with rho taken at rest.
fn packed(setup: &Setup) -> Fluid {
    let packing = Packing::liquid(&setup.glass, fitting_spacing(&setup.glass, setup.spacing_m), setup.seed);
    let rest = setup.liquid.density_kg_m3;
    let pressed = |z: f64| rest + rest * GRAVITY_M_S2 * (setup.glass.fill_m - z) / (SOUND_M_S * SOUND_M_S);
    let density: Vec<f64> = packing.position.iter().map(|x| pressed(x[2])).collect();
    let mass = density.iter().zip(&packing.volume).map(|(density, volume)| density * volume).collect();
    let packed = Settled { position: packing.position, mass, density, law: [1.0, 0.0, 0.0, 0.0] };
    packed.fluid(rest, setup.liquid.rheology.viscosity(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::small_glass;

    #[test]
    fn two_liquids_in_one_glass_start_from_the_same_particles() {
        let stop = AtomicBool::new(false);
        let [water, honey] = [(998.0, 1e-3), (1420.0, 10.0)].map(|(density, viscosity)| {
            let setup = small_glass(density, Rheology::newtonian(viscosity));
            Simulator::new_until(&setup, &stop).expect("the glass settles")
        });
        for (a, b) in water.fluid.particle.iter().zip(&honey.fluid.particle) {
            assert_eq!((a.x, a.v), (b.x, [0.0; 3]));
            assert!((a.p / 998.0 - b.p / 1420.0).abs() < 1e-9, "{} and {} Pa", a.p, b.p);
        }
        let volume = |simulator: &Simulator| simulator.motion().map(|(_, _, m)| m).sum::<f64>();
        assert!((volume(&water) / 998.0 - volume(&honey) / 1420.0).abs() < 1e-12);
    }

    #[test]
    fn a_kept_glass_gives_the_same_bits_as_a_new_one() {
        let setup = settling(&small_glass(1000.0, Rheology::newtonian(1e-3)).resolved());
        let stop = AtomicBool::new(false);
        let kept = of(&setup, &stop).expect("it settles");
        let new = Simulator::with(&setup, packed(&setup)).settle(&stop).expect("it settles");
        assert_eq!(*kept, new);
    }

    #[test]
    fn an_inclined_glass_settles_by_itself() {
        let setup = small_glass(1000.0, Rheology::newtonian(1e-3));
        let tilted =
            Setup { effects: Effects::default().with(EffectKind::ContainerTilt, 0.05), ..setup.clone() };
        let key = |setup: &Setup| {
            let setup = settling(&setup.resolved());
            kept::Key::of(&setup, &packed(&setup))
        };
        assert_ne!(key(&setup), key(&tilted));
        let foaming = Setup { effects: Effects::default().with(EffectKind::Foam, 0.1), ..setup.clone() };
        assert_eq!(key(&setup), key(&foaming), "a film does not act while the glass settles");
    }
}
