//! The effects that act by forces of their own, with what they remember.

use super::columns::Columns;
use super::contact_line::{ContactLine, SECTORS, Wall};
use super::foam::Foam;
use super::laws::Laws;
use super::surface_tension::{Tension, lacking};
use super::surroundings::Surroundings;
use super::viscoelastic::Maxwell;
use super::waves::Coefficients;
use crate::particles::Fluid;
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::recording::Glass;

/// Highest wave number of the waves of the surface, times the radius.
const FINEST: f64 = 8.6;

/// Effects on the free surface, and the tension that the sums lack.
#[derive(Clone, Debug)]
struct Surface {
    columns: Columns,
    wall: Wall,
    tension: Tension,
    line: Option<ContactLine>,
    foam: Option<Foam>,
    /// Stored energy of the area at the last call of the forces, J.
    area_j: f64,
    /// Force per length along the wall, N/m.
    held: [f64; SECTORS],
}

impl Surface {
    /// Finds the force along the wall for a step `dt` from the present state; returns its heat, J, where
    /// something rubs there.
    fn rub(&mut self, dt: f64, fluid: &Fluid) -> Option<f64> {
        let Self { columns, wall, line, foam, held, .. } = self;
        if line.is_none() && foam.is_none() {
            return None;
        }
        columns.follow(fluid);
        // Slopes are those at the present velocity first, then at the one that they lead to.
        let mut rate = columns.rate;
        let mut law = [[0.0; 2]; SECTORS];
        for _ in 0..2 {
            let v = wall.velocity(&rate);
            law = line.as_ref().map_or([[0.0; 2]; SECTORS], |line| line.law(dt, &v));
            if let Some(foam) = foam {
                law.iter_mut().zip(foam.slope(&v)).for_each(|([_, slope], foam)| *slope += foam);
            }
            rate = wall.slow(&columns.rate, &columns.mobility, dt, &law)?;
        }
        let v = wall.velocity(&rate);
        *held = std::array::from_fn(|s| law[s][0] + law[s][1] * v[s]);
        // The kicks work at the mean of the rates before and after.
        let middle = wall.velocity(&(0.5 * (columns.rate + rate)));
        let work = dt * wall.length_m * held.iter().zip(&middle).map(|(f, v)| f * v).sum::<f64>();
        let rubbed = foam.map_or([0.0; SECTORS], |foam| foam.slope(&v));
        let stored = line.as_mut().map_or(0.0, |line| {
            let own = std::array::from_fn(|s| held[s] - rubbed[s] * v[s]);
            line.advance(&own, wall.length_m)
        });
        Some(work - stored)
    }
}

/// The acting effects; none before the liquid has settled.
#[derive(Clone, Debug, Default)]
pub(crate) struct Acting {
    surface: Option<Surface>,
    maxwell: Option<Maxwell>,
}

/// The longest step that the acting effects allow, s: surface waves of the finest resolved length
/// must not move by more than half a radian.
pub(crate) fn longest_step(laws: &Laws, glass: &Glass, density: f64) -> f64 {
    let k = FINEST / glass.radius_at(glass.fill_m);
    let tension = laws.tension_n_m.unwrap_or(0.0) * k.powi(3) / density;
    // A spring k_c along the wall, as a part of the stiffness rho g of the surface: 2 k_c/(rho g R).
    let spring =
        laws.line.map_or(0.0, |line| 2.0 * line.force_n_m / line.reach_m / (density * glass.radius_m) * k);
    let rate = (tension + spring).sqrt();
    if rate > 0.0 { 0.5 / rate } else { f64::INFINITY }
}

impl Acting {
    /// The effects that act on a liquid at rest, computed with the smoothing length `length_m`.
    pub(crate) fn on(laws: &Laws, glass: &Glass, rest_density: f64, length_m: f64, fluid: &Fluid) -> Self {
        let Laws { tension_n_m, line, foam, relaxation, lift_m_s2, .. } = *laws;
        let radius_m = glass.radius_at(glass.fill_m);
        let columns = Columns::new(radius_m, rest_density, fluid);
        let lacking = lacking(rest_density, GRAVITY_M_S2 + lift_m_s2, length_m);
        let surface = Surface {
            wall: Wall::new(radius_m, &columns.waves),
            tension: Tension::new(tension_n_m.unwrap_or(0.0) + lacking, radius_m, &columns.waves),
            columns,
            line: line.map(ContactLine::new),
            foam: foam.map(|beta| Foam { beta }),
            area_j: 0.0,
            held: [0.0; SECTORS],
        };
        let maxwell = relaxation.map(|relaxation| Maxwell::new(relaxation, fluid.mass.len()));
        Self { surface: Some(surface), maxwell }
    }

    /// Whether the particles carry a stress of their own.
    pub(crate) fn is_elastic(&self) -> bool {
        self.maxwell.is_some()
    }

    /// Keeps the particles that are in `keep`.
    pub(crate) fn retain(&mut self, keep: &[bool]) {
        if let Some(maxwell) = &mut self.maxwell {
            maxwell.retain(keep);
        }
    }

    /// Advances what the effects remember by `dt`, at the present places and velocities; books heat.
    pub(crate) fn advance(&mut self, dt: f64, around: &Surroundings<'_>, fluid: &mut Fluid) {
        if let Some(maxwell) = &mut self.maxwell {
            maxwell.advance(dt, around, fluid);
        }
        if let Some(heat_j) = self.surface.as_mut().and_then(|surface| surface.rub(dt, fluid)) {
            warm(heat_j, around, fluid);
        }
    }

    /// Fills `pressed` with the pressure on the surface above each particle and the acceleration that
    /// stands for it; leaves it empty where nothing presses.
    pub(crate) fn press(&mut self, fluid: &Fluid, pressed: &mut Vec<[f64; 3]>) {
        let Some(surface) = &mut self.surface else { return };
        let mut q = Coefficients::zeros();
        surface.wall.press(&surface.held, &mut q);
        surface.columns.rise(fluid);
        surface.area_j = surface.tension.pull(&surface.columns.height, &mut q);
        surface.columns.push(&surface.columns.pressure(&q), pressed);
    }

    /// Adds the accelerations that other effects cause.
    pub(crate) fn push(&mut self, around: &Surroundings<'_>, fluid: &mut Fluid) {
        if let Some(maxwell) = &mut self.maxwell {
            maxwell.push(around, fluid);
        }
    }

    /// Returns the energy stored by the effects, J.
    pub(crate) fn stored(&self, fluid: &Fluid) -> f64 {
        let surface = self.surface.as_ref().map_or(0.0, |surface| {
            let line = surface.line.as_ref().map_or(0.0, |line| line.stored(surface.wall.length_m));
            surface.area_j + line
        });
        surface + self.maxwell.as_ref().map_or(0.0, |maxwell| maxwell.stored(fluid))
    }
}

/// Gives heat of the contact line to the particles there: within a spacing and a half of the wall and
/// three of the fill, by mass; to all where there are none.
fn warm(heat_j: f64, around: &Surroundings<'_>, fluid: &mut Fluid) {
    let Surroundings { glass, spacing_m, .. } = *around;
    let near = |x: &[f64; 3]| {
        glass.radius_at(x[2]) - x[0].hypot(x[1]) < 1.5 * spacing_m && x[2] > glass.fill_m - 3.0 * spacing_m
    };
    let parts = || fluid.particle.iter().zip(&fluid.mass);
    let there: f64 = parts().filter(|(p, _)| near(&p.x)).map(|(_, m)| m).sum();
    let all: f64 = fluid.mass.iter().sum();
    let (share, everywhere) = if there > 0.0 { (heat_j / there, false) } else { (heat_j / all, true) };
    for (p, heat) in fluid.particle.iter().zip(&mut fluid.heat) {
        if everywhere || near(&p.x) {
            *heat += share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::Mode;
    use crate::{Setup, Simulator};
    use meniscus::reduced::effects::EffectKind;
    use meniscus_data::effects::Effects;
    use meniscus_data::glass::WallShape;
    use meniscus_data::liquids::{Liquid, Rheology};

    #[test]
    fn the_line_moves_with_the_mode() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let rheology = Rheology::newtonian(0.1);
        let effects = Effects::default().with(EffectKind::Foam, 1.0);
        let liquid = Liquid { name: "x".into(), density_kg_m3: 1261.0, rheology, effects };
        let setup = Setup { glass, liquid, spacing_m: 0.007, seed: 0, no_slip: false, effects, step_s: None };
        let mut simulator = Simulator::new(&setup).expect("the glass settles");
        let mode = Mode::first(glass);
        simulator.set_velocity(|x| mode.velocity(x).map(|v| 0.1 * v));
        let surface = simulator.acting.surface.as_mut().expect("it acts on the surface");
        surface.columns.follow(&simulator.fluid);
        let v = surface.wall.velocity(&surface.columns.rate);
        let sectors = v.len() as f64;
        for (s, v) in v.iter().enumerate() {
            let cos = (std::f64::consts::TAU * (s as f64 + 0.5) / sectors).cos();
            println!("{s} {v:.4} for {:.4}", 0.1 * cos);
            assert!((v - 0.1 * cos).abs() < 0.015, "{v} m/s for {} m/s in sector {s}", 0.1 * cos);
        }
    }
}
