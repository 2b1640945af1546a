//! Named effects in a trained step: what stands between the liquid it was trained on and the one in the glass.
//!
//! Two linear maps, fitted when effects are put in, say what the first mode does in latent space: its height at the
//! wall a = A x (m) and its rate v = B x (m/s); e_a and e_v are the latent directions in which the states spread as
//! only a, only v grows by one. With the reduced model's mass m, friction G and square of the frequency w^2, plain and
//! with the effects (1):
//!
//! ```text
//! energy     H(S x),         S = 1 + (w1/w - 1) e_a A                    convex as H is
//! friction   D1(x) = phi (D^-1 + s H'')^-1 >= 0,   phi = (G1 m)/(G m1),  G at the amplitude sqrt(v^2 + w^2 a^2)
//! memory     z' = v - r z,   energy k z^2/2,  force -k z e_v/m,  heat k r z^2 >= 0
//! ```
//! Friction is taken at the state before the step. All of D takes the factor, not the first mode's part alone: tried
//! on simulated glasses, that halves what is left, because the latents behind it (layers, higher modes) rub with the
//! same liquid. What a thicker layer takes off the frequency comes with it and is no part of w. A factor and not a sum:
//! an effect may as well take friction away, and D1 can still have no other sign.
//!
//! The step takes its gradient in the middle, where a rate r of friction leaves (1 - y)/(1 + y) of a motion, y = r dt/2: what
//! should be stopped within a step bounces. So phi y becomes phi y/(1 + (phi^2 - 1) y^2/(1 + phi y)), which agrees to second
//! order, is y for phi = 1 and stays below 1: s = (dt/2) (phi^2 - 1) y/(1 + phi y) with the y of the first mode and H'' at
//! rest. Where friction is taken away nothing can bounce, and s is 0.
//!
//! With the memory in the middle of the step, z^ = (z + dt v^/2)/(1 + dt r/2), the rate being v^ = e e_v . dH/m (e the
//! joules of one H),
//!
//! ```text
//! x^ = x~ + dt [ (L - D1 - c e_v e_v^T) dH - f e_v ]
//! c = sum e k dt/(2 m^2 (1 + dt r/2)),    f = sum k z/(m (1 + dt r/2))
//! ```
//! has the form of the plain step, and H(S x) e + sum k z^2/2 falls by the heat, exactly: L - D1 is what it was, a skew
//! matrix less a positive one, and (z, v) exchange energy through a skew pair.

use super::flow::Flow;
use super::newton::Square;
use super::{Latent, Operators};
use crate::latent::linalg::whitener;
use crate::math::sqrt;
use crate::reduced::effects::Relax;
use crate::reduced::{ReducedModel, SpeedTable};

/// Number of memory variables: viscoelastic relaxation and contact line.
pub const MEMORIES: usize = 2;

/// A of the height and B of the rate of the first mode, and the directions that belong to them.
///
/// ```
/// use meniscus::latent::generic::{Latent, ModeMap};
///
/// let unit = |i: usize| Latent::from_fn(|row, _| f64::from(u8::from(row == i)));
/// // Latent 0 is the height of the first mode, latent 1 its rate.
/// assert!(ModeMap::new([unit(0), unit(1), unit(0), unit(1)]).is_some());
/// // A direction that does not belong to its row is refused.
/// assert!(ModeMap::new([unit(0), unit(1), unit(2), unit(1)]).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeMap {
    /// A, m for each unit of x.
    pub height: Latent,
    /// B, m/s for each unit of x.
    pub rate: Latent,
    /// e_a: A e_a = 1, B e_a = 0; a unit of x for each m.
    pub along_height: Latent,
    /// e_v: A e_v = 0, B e_v = 1; a unit of x for each m/s.
    pub along_rate: Latent,
}

/// Tolerance for the bi-orthogonality of the mode map.
const SLACK: f64 = 1e-3;

impl ModeMap {
    /// The map of A, B, e_a and e_v; none where the directions are not those of the rows.
    #[must_use]
    pub fn new([height, rate, along_height, along_rate]: [Latent; 4]) -> Option<Self> {
        let length = |x: &Latent| sqrt(x.dot(x));
        let ones = [height.dot(&along_height), rate.dot(&along_rate)];
        let across = [(&height, &along_rate), (&rate, &along_height)];
        let fits = ones.iter().all(|one| (one - 1.0).abs() <= SLACK)
            && across.iter().all(|(row, along)| row.dot(along).abs() <= SLACK * length(row) * length(along));
        fits.then_some(Self { height, rate, along_height, along_rate })
    }
}

/// Maxwell branch of the first mode: a spring whose deflection relaxes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Memory {
    /// k, N/m.
    stiffness: f64,
    /// r.
    relax: Relax,
}

/// The effects of a model, ready for steps.
///
/// ```
/// use meniscus::latent::generic::{LATENTS, Latent, ModeMap, Slots};
/// use meniscus::reduced::{Baseline, Cylinder, ReducedModel, Rheology};
///
/// let unit = |i: usize| Latent::from_fn(|row, _| f64::from(u8::from(row == i)));
/// let map = ModeMap::new([unit(0), unit(1), unit(0), unit(1)]).unwrap();
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 1261.0 };
/// let plain = ReducedModel::new(glass, Rheology::newtonian(0.2), &Baseline::default(), &[], 1.0 / 60.0);
/// // Without effects the energy is not bent.
/// let identity = nalgebra::SMatrix::<f64, LATENTS, LATENTS>::identity();
/// let slots = Slots::between(&plain, &plain, map, 1e-3, &identity);
/// assert_eq!(*slots.bend(), identity);
/// assert_eq!(slots.rate(&unit(1)), 1.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Slots {
    map: ModeMap,
    /// S.
    bend: Square,
    /// (G1 m)/(G m1).
    friction: SpeedTable,
    /// H''.
    hessian: Square,
    /// w, 1/s.
    frequency: f64,
    memories: [Memory; MEMORIES],
    /// m, kg.
    mass_kg: f64,
    /// e, J.
    joules: f64,
}

impl Slots {
    /// Returns the difference between the reduced models `plain` and `with` effects, for a step whose H is in units of `joules` and has
    /// the second derivative `hessian` at rest.
    #[must_use]
    pub fn between(
        plain: &ReducedModel,
        with: &ReducedModel,
        map: ModeMap,
        joules: f64,
        hessian: &Square,
    ) -> Self {
        let (w, w1) = (plain.frequency(), with.frequency());
        // A mass that changes, as by the fill, changes both energies alike: only their ratio moves the wave.
        let bend = Square::identity() + map.along_height * map.height.transpose() * (w1 / w - 1.0);
        let rate = |model: &ReducedModel, speed: f64| model.first_mode_friction(speed) / model.mass_kg();
        let ratio = |speed: f64| rate(with, speed) / rate(plain, speed).max(f64::MIN_POSITIVE);
        // The latent's own mass, near that of the reduced model, which its spring constants are scaled to.
        let mass_kg = joules * map.along_rate.dot(&(hessian * map.along_rate));
        let own = mass_kg / with.mass_kg();
        Self {
            map,
            bend,
            friction: SpeedTable::new(ratio),
            hessian: *hessian,
            frequency: w1,
            memories: with.branches().map(|b| Memory { stiffness: own * b.stiffness, relax: b.relax }),
            mass_kg,
            joules,
        }
    }

    /// S.
    #[must_use]
    pub fn bend(&self) -> &Square {
        &self.bend
    }

    /// The first mode in latent space.
    #[must_use]
    pub fn map(&self) -> &ModeMap {
        &self.map
    }

    /// phi: factor of the effects on friction at `x`.
    #[must_use]
    pub fn friction_factor(&self, x: &Latent) -> f64 {
        let (a, v) = (self.map.height.dot(x), self.map.rate.dot(x));
        let amplitude = sqrt(v * v + self.frequency * self.frequency * a * a);
        self.friction.at(amplitude).max(0.0)
    }

    /// Rate of the first mode at `x`, m/s.
    #[must_use]
    pub fn rate(&self, x: &Latent) -> f64 {
        self.map.rate.dot(x)
    }

    /// Returns whether a branch relaxes with the path length, so that r has to be solved for with the step.
    #[must_use]
    pub(super) fn slides(&self) -> bool {
        self.memories.iter().any(|m| m.stiffness > 0.0 && matches!(m.relax, Relax::Path(_)))
    }

    /// L - D1 at `x` with the memories at `held` (m), while the line moves with `speed` (m/s), for a step of `dt`.
    #[must_use]
    pub(super) fn flow(
        &self,
        operators: &Operators,
        x: &Latent,
        held: &[f64; MEMORIES],
        speed: f64,
        dt: f64,
    ) -> Flow {
        let map = &self.map;
        let friction = self.rubs(operators, self.friction_factor(x), dt);
        let (mut resists, mut pulls) = (0.0, 0.0);
        for (memory, z) in self.memories.iter().zip(held) {
            let fade = 1.0 + 0.5 * dt * memory.relax.rate(speed);
            resists += self.joules * memory.stiffness * 0.5 * dt / (self.mass_kg * self.mass_kg * fade);
            pulls += memory.stiffness * z / (self.mass_kg * fade);
        }
        let memory = map.along_rate * map.along_rate.transpose() * resists;
        Flow { matrix: operators.skew - friction - memory, friction, pull: map.along_rate * pulls }
    }

    /// D1 of `operators` under the factor `phi`, for a step of `dt`.
    fn rubs(&self, operators: &Operators, phi: f64, dt: f64) -> Square {
        if phi <= 1.0 {
            return operators.friction * phi;
        }
        let (c, map) = (&operators.factor, &self.map);
        let slowed = operators.friction * (self.hessian * map.along_rate);
        let y = 0.5 * dt * map.rate.dot(&slowed).max(0.0);
        let s = 0.5 * dt * (phi * phi - 1.0) * y / (1.0 + phi * y);
        // (D^-1 + s H'')^-1 = C (1 + s C^T H'' C)^-1 C^T, a square for any C; H is convex, so that there is an inverse.
        let root = c * whitener(&(Square::identity() + c.transpose() * self.hessian * c * s)).transpose();
        root * root.transpose() * phi
    }

    /// The memories after a step whose mean gradient of H is `gradient`, and the heat that they made, in units of H.
    #[must_use]
    pub(super) fn remember(
        &self,
        held: &[f64; MEMORIES],
        gradient: &Latent,
        speed: f64,
        dt: f64,
    ) -> ([f64; MEMORIES], f64) {
        let v = self.joules * self.map.along_rate.dot(gradient) / self.mass_kg;
        let (mut after, mut heat) = (*held, 0.0);
        for (z, memory) in after.iter_mut().zip(&self.memories) {
            let r = memory.relax.rate(speed);
            let middle = (*z + 0.5 * dt * v) / (1.0 + 0.5 * dt * r);
            *z = 2.0 * middle - *z;
            heat += dt * memory.stiffness * r * middle * middle / self.joules;
        }
        (after, heat)
    }

    /// Energy of the memories, in units of H.
    #[must_use]
    pub fn stored(&self, held: &[f64; MEMORIES]) -> f64 {
        let joules: f64 = self.memories.iter().zip(held).map(|(m, z)| 0.5 * m.stiffness * z * z).sum();
        joules / self.joules
    }
}
