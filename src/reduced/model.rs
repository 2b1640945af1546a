//! A glass of liquid with its effects: every coefficient that a step needs.

use super::baseline::Baseline;
use super::mode_coefficients::{ModeCoefficients, coefficients, line_rubs, memory};
use super::modes::{Cylinder, RADIAL};
use crate::math::sqrt;
use crate::reduced::bound_wave_coefficients::{FirstModeContext, bound_waves};
use crate::reduced::bound_waves::BoundWaves;
use crate::reduced::boundary_layer::Rheology;
use crate::reduced::drawn_law::DrawnLaw;
use crate::reduced::effects::{Active, Branch, MOST, Port, Relax, Slot, View};
use crate::reduced::speed_table::SLOWEST_M_S;
use heapless::Vec;

/// Repetitions by which [`ReducedModel::swinging_frequency`] is found. Each one is nearer by the share of the relaxing stiffness
/// in the whole.
const MEMORY_REPEATS: usize = 8;

/// A glass of liquid with its effects, for steps of one length.
///
/// ```
/// use meniscus::reduced::{Baseline, Cylinder, Forcing, ReducedModel, ReducedState, Rheology, step};
///
/// let glass = Cylinder { radius_m: 0.035, depth_m: 0.07, density_kg_m3: 998.0 };
/// let water = Rheology::newtonian(1.0e-3);
/// let model = ReducedModel::new(glass, water, &Baseline::default(), &[], 1.0 / 240.0);
/// // The first mode of this glass has 3.6 Hz.
/// let hz = model.frequency() / core::f64::consts::TAU;
/// assert!((hz - 3.61).abs() < 0.01, "{hz}");
///
/// // A free slosh: all energy that the waves lose becomes heat.
/// let mut state = ReducedState::default();
/// state.height[0][0] = 0.005;
/// let before = model.energy(&state);
/// for _ in 0..240 {
///     let balance = step(&model, &mut state, &Forcing::default());
///     assert!(balance.heat_j >= 0.0 && balance.work_j == 0.0);
/// }
/// assert!(model.energy(&state) < before);
/// assert!((model.energy(&state) + state.heat_j - before).abs() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct ReducedModel {
    /// Glass and liquid at rest, with the effects on them.
    pub glass: Cylinder,
    /// Changes to the glass's motion before it drives the liquid.
    pub port: Port,
    /// Changes to the surface before it is measured.
    pub view: View,
    pub(super) dt: f64,
    pub(super) modes: [ModeCoefficients; RADIAL],
    pub(super) bound_waves: BoundWaves,
    /// Quartic coefficient of the first mode's energy, N/m3.
    pub(super) quartic: f64,
    /// Coupling of its two directions, N/m.
    pub(super) coupling: f64,
    pub(super) memory: [Branch; RADIAL],
    pub(super) line: Branch,
    /// Friction along the contact line, evaluated at the amplitude of its speed.
    pub(super) rubbing: Vec<Active, MOST>,
    /// Unnamed force on the first mode.
    pub(super) law: Option<DrawnLaw>,
}

impl ReducedModel {
    /// The model of `glass` filled with `liquid` under `baseline` with the effects `active`, for steps of
    /// `dt` seconds; at most [`MOST`] effects act, further ones are left out.
    #[must_use]
    pub fn new(glass: Cylinder, liquid: Rheology, baseline: &Baseline, active: &[Active], dt: f64) -> Self {
        let (mut glass, mut liquid) = (glass, liquid);
        let (mut port, mut view) = (Port::default(), View::default());
        let mut rubbing = Vec::new();
        for effect in active {
            match effect.entry.slot {
                Slot::Liquid(change) => change(&effect.values, &mut liquid),
                Slot::Vessel(change) => change(&effect.values, &mut glass),
                Slot::Port(change) => change(&effect.values, &mut port),
                Slot::View(change) => change(&effect.values, &mut view),
                // More than fit are left out, as said above.
                Slot::Line(_) => drop(rubbing.push(*effect)),
                Slot::Memory(stress) => liquid.maxwell = stress(&effect.values),
                Slot::Stiffness(_) | Slot::FirstMode(_) | Slot::Catch(_) => {}
            }
        }
        // An effect on the line is counted from what the baseline holds of it, and a free line is the least.
        liquid.held_line = (liquid.held_line + baseline.held_line - 1.0).max(0.0);
        let of_mode = |n: usize| coefficients(n, &glass, &liquid, baseline, active, dt);
        let modes: [ModeCoefficients; RADIAL] = core::array::from_fn(of_mode);
        let stiffness = modes.first().map_or(0.0, |m| m.stiffness);
        // A^2 = a^2 of a Duffing oscillator: w = w0 (1 + 3 alpha A^2/(8 w0^2)), energy m alpha a^4/4.
        let soften = |kappa: f64| -8.0 / 3.0 * kappa * stiffness / (glass.radius_m * glass.radius_m);
        let (mut quartic, mut coupling) = (soften(baseline.detuning), 0.0);
        let memory = modes.map(|ready| memory(liquid.maxwell, &ready.mode, &glass));
        let mut line = Branch::default();
        for effect in active {
            match effect.entry.slot {
                Slot::FirstMode(shape) => {
                    let shape = shape(&effect.values);
                    quartic += soften(shape.softening);
                    coupling += shape.coupling * stiffness;
                }
                Slot::Catch(branch) => line = branch(&effect.values, &glass),
                _ => {}
            }
        }
        let bound_waves = bound_waves(
            &glass,
            &liquid,
            baseline,
            active,
            &FirstModeContext { port: &port, line: &line, first: &modes[0], dt },
        );
        let law = None;
        Self { glass, port, view, dt, modes, bound_waves, quartic, coupling, memory, line, rubbing, law }
    }

    /// The same model with the unnamed force `law` on its first mode, in place of the one that it had.
    #[must_use]
    pub fn with_law(mut self, law: DrawnLaw) -> Self {
        self.law = Some(law);
        self
    }

    /// Friction of the drawn law at an amplitude of the first mode's rate (m/s), N s/m.
    pub(super) fn law_rubs(&self, speed: f64) -> f64 {
        self.law.as_ref().map_or(0.0, |law| law.friction(speed))
    }

    /// Frequency (1/s) and damping gamma (1/s) of the mode (1,n) at small amplitude; none where there is
    /// no such mode.
    #[must_use]
    pub fn frequency_and_damping(&self, n: usize) -> Option<(f64, f64)> {
        self.modes.get(n).map(|m| (m.w, m.friction.at(SLOWEST_M_S) / (2.0 * m.mode.mass_kg)))
    }

    /// Mass of the first mode, kg: its kinetic energy is `m v^2/2`.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.modes[0].mode.mass_kg
    }

    /// Frequency of the first mode without friction, under the constant lift, 1/s.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        let first = &self.modes[0];
        sqrt((first.free * first.free + first.mode.steepness * self.port.lift_m_s2).max(0.0))
    }

    /// Frequency at which the first mode swings, under friction, the constant lift, viscoelastic relaxation and a contact line that
    /// is pinned, 1/s.
    ///
    /// ```text
    /// W^2 = w^2 + kappa a + (k/m) W^2/(W^2 + r^2) + (s/m)/(1 + s sum_n 1/(K_n - m_n W^2))
    /// ```
    /// of a memory of stiffness k that relaxes at the rate r, and a line of stiffness s on which the higher modes n ride. A line that
    /// slides, and changes with the amplitude, are left out.
    #[must_use]
    pub fn swinging_frequency(&self) -> f64 {
        let (first, branch) = (&self.modes[0], &self.memory[0]);
        let rate = branch.relax.rate(0.0);
        let free = first.w * first.w + first.mode.steepness * self.port.lift_m_s2;
        let stored = branch.stiffness / first.mode.mass_kg;
        let mut square = free + stored;
        let pinned = if self.line.relax == Relax::Never { self.line.stiffness } else { 0.0 };
        for _ in 0..MEMORY_REPEATS {
            let given = |ready: &ModeCoefficients| 1.0 / (ready.stiffness - ready.mode.mass_kg * square);
            let yields = 1.0 + pinned * self.modes.iter().skip(1).map(given).sum::<f64>();
            square = free + stored * square / (square + rate * rate) + pinned / (first.mode.mass_kg * yields);
        }
        sqrt(square.max(0.0))
    }

    /// Friction of the first mode at an amplitude of its rate (m/s), in the liquid, along the contact line and by a drawn law,
    /// N s/m.
    #[must_use]
    pub fn first_mode_friction(&self, speed: f64) -> f64 {
        self.modes[0].friction.at(speed) + self.line_rubs(speed) + self.law_rubs(speed)
    }

    /// Friction along the contact line at an amplitude of its speed (m/s), N s/m.
    pub(super) fn line_rubs(&self, speed: f64) -> f64 {
        line_rubs(&self.rubbing, speed, &self.glass)
    }

    /// Returns the inner variables of the first mode: of the liquid, and of the contact line. A stiffness of zero is none.
    #[must_use]
    pub fn branches(&self) -> [Branch; 2] {
        [self.memory[0], self.line]
    }

    /// Returns the part of a static slope that the kept modes do not show, m for each unit of slope: the modes
    /// left out follow an acceleration at once.
    #[must_use]
    pub fn residual_lever_m(&self) -> f64 {
        self.glass.radius_m - self.modes.iter().map(|m| m.mode.lever_m).sum::<f64>()
    }
}
