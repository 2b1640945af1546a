//! One step in time, implicit in the middle.
//!
//! ```text
//! a1 = a0 + dt v,  v = (v0 + v1)/2                               (bars left out)
//! m (v1 - v0)/dt = -K a - m alpha (A0^2 + A1^2)/2 a - (U1 - U0)/(a1 - a0) - k z - G v + Q
//! z1 = z0 + dt (v - r z)                                         r = 1/lambda, or |u|/reach
//! heat += dt (v.G v + k r z^2)
//! ```
//! with a and z in the middle too. The chords of the quartic energy and of a drawn law's U are exact (Gonzalez 1996), so
//! `E1 - E0 = dt Q.v` whatever G(s) >= 0 and r(s) >= 0 are: friction is taken at the state before the
//! step, and what depends on the state after it is found by a few repetitions, whose remainder is in
//! [`EnergyBalance::residue_j`]. Along the wall all modes move as one, `u = sum v_n`: friction and catch there are
//! of rank one and solved in closed form.

use super::model::ReducedModel;
use super::modes::RADIAL;
use crate::math::sqrt;
use crate::reduced::bound_waves::{BoundWaveState, FirstModeMotion};

/// Repetitions where something depends on the state after the step.
const REPEATS: usize = 20;

/// The repetitions end when no rate changes by more, m/s.
const SETTLED_M_S: f64 = 1e-15;

/// State of the liquid; directions x and y, then modes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReducedState {
    /// Heights at the wall, m.
    pub height: [[f64; RADIAL]; 2],
    /// Their rates, m/s.
    pub rate: [[f64; RADIAL]; 2],
    /// Inner variable of each mode, m.
    pub memory: [[f64; RADIAL]; 2],
    /// Deflection of the contact line, m.
    pub caught: [f64; 2],
    /// Second-order waves.
    pub bound_waves: BoundWaveState,
    /// Heat since the start, J.
    pub heat_j: f64,
}

/// Forcing of the liquid by the moved glass during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forcing {
    /// Specific force on the liquid along x and y of the glass, m/s2: minus the acceleration of the glass.
    pub along_m_s2: [f64; 2],
    /// Acceleration of the glass upwards, m/s2.
    pub lift_m_s2: f64,
}

/// Energy balance of one step, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Work of the port.
    pub work_j: f64,
    /// Heat that was made; never negative.
    pub heat_j: f64,
    /// Energy after less energy before less work: rounding and what the repetitions left.
    pub residue_j: f64,
}

impl ReducedModel {
    /// Energy of `state` without its heat, J.
    #[must_use]
    pub fn energy(&self, state: &ReducedState) -> f64 {
        let mut energy = 0.0;
        let directions = state.height.iter().zip(&state.rate).zip(state.memory.iter().zip(&state.caught));
        for ((height, rate), (memory, caught)) in directions {
            for ((ready, branch), ((a, v), z)) in
                self.modes.iter().zip(&self.memory).zip(height.iter().zip(rate).zip(memory))
            {
                energy +=
                    0.5 * (ready.mode.mass_kg * v * v + ready.stiffness * a * a + branch.stiffness * z * z);
            }
            energy += 0.5 * self.line.stiffness * caught * caught;
        }
        let [x, y] = [state.height[0][0], state.height[1][0]];
        let square = x * x + y * y;
        let drawn = self.law.as_ref().map_or(0.0, |law| law.energy_j(x));
        energy + drawn + 0.25 * self.quartic * square * square + self.coupling * x * y
    }

    /// Returns the liquid at rest under a constant acceleration: `K a = Q`, mode by mode.
    #[must_use]
    pub fn rest(&self, push: &Forcing) -> ReducedState {
        let mut state = ReducedState::default();
        for (height, along) in state.height.iter_mut().zip(push.along_m_s2) {
            for (a, ready) in height.iter_mut().zip(&self.modes) {
                *a = ready.push_kg * along / (ready.stiffness + ready.lift_kg_m * push.lift_m_s2);
            }
        }
        if let Some(law) = &self.law {
            let first = &self.modes[0];
            let stiffness = first.stiffness + first.lift_kg_m * push.lift_m_s2;
            state.height[0][0] = law.balance_m(stiffness, first.push_kg * push.along_m_s2[0]);
        }
        state
    }

    /// Whether a step has to be repeated.
    fn repeats(&self) -> usize {
        let still =
            self.quartic == 0.0 && self.coupling == 0.0 && self.line.stiffness == 0.0 && self.law.is_none();
        if still { 1 } else { REPEATS }
    }
}

/// Advances `state` by one step under the acceleration `push`.
pub fn step(model: &ReducedModel, state: &mut ReducedState, push: &Forcing) -> EnergyBalance {
    let (dt, before) = (model.dt, *state);
    // A wave along x that nothing turns stays there.
    let flat = |pair: &[[f64; RADIAL]; 2]| pair[1] == [0.0; RADIAL];
    let planar = push.along_m_s2[1] == 0.0
        && model.coupling == 0.0
        && flat(&before.height)
        && flat(&before.rate)
        && flat(&before.memory);
    let directions = if planar { 1 } else { 2 };
    let energy = model.energy(state);
    let mut friction = [[0.0; RADIAL]; 2];
    let mut rubbing = [0.0; 2];
    resist(model, &before, &mut friction, &mut rubbing);
    let mut balance = EnergyBalance::default();
    let mut middle = before.rate;
    for _ in 0..model.repeats() {
        let last = middle;
        let speed = wall_speed(&middle);
        let after: [f64; 2] =
            [before.height[0][0] + dt * middle[0][0], before.height[1][0] + dt * middle[1][0]];
        let square = |pair: &[f64; 2]| pair[0] * pair[0] + pair[1] * pair[1];
        let chord =
            0.5 * model.quartic * (square(&[before.height[0][0], before.height[1][0]]) + square(&after));
        // The other direction's height in the middle.
        let across = [0.5 * (before.height[1][0] + after[1]), 0.5 * (before.height[0][0] + after[0])];
        let drawn = model.law.as_ref().map_or(0.0, |law| law.chord_n(before.height[0][0], after[0]));
        let first = FirstModeForces { chord, across, drawn_n: [drawn, 0.0] };
        let slip = model.line.relax.rate(speed);
        let catch = 1.0 + 0.5 * dt * slip;
        for d in 0..directions {
            let Some(rows) = row(model, &before, d, push, &friction, &first) else { continue };
            let caught = before.caught.get(d).copied().unwrap_or(0.0);
            let held = model.line.stiffness * caught / catch;
            let grip = rubbing.get(d).copied().unwrap_or(0.0) + model.line.stiffness * 0.5 * dt / catch;
            // v_i = (r_i - held - grip u)/D_i,   u = sum v_i.
            let free: f64 = rows.iter().map(|(r, over)| (r - held) * over).sum();
            let give: f64 = rows.iter().map(|(_, over)| over).sum();
            let u = free / (1.0 + grip * give);
            for (v, (r, over)) in middle.iter_mut().skip(d).take(1).flatten().zip(&rows) {
                *v = (r - held - grip * u) * over;
            }
        }
        let changed = middle.iter().flatten().zip(last.iter().flatten());
        if changed.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < SETTLED_M_S {
            break;
        }
    }
    let slip = model.line.relax.rate(wall_speed(&middle));
    for d in 0..directions {
        let heat = finish(model, state, &before, d, &middle, &friction, &rubbing, slip, push);
        balance.heat_j += heat.0;
        balance.work_j += heat.1;
    }
    let (w, steepness) = (model.modes[0].w, model.modes[0].mode.steepness);
    let first = FirstModeMotion {
        square: w * w,
        height: [0, 1].map(|d| 0.5 * (before.height[d][0] + state.height[d][0])),
        rate: [middle[0][0], middle[1][0]],
        turns: [0, 1].map(|d| (state.rate[d][0] - before.rate[d][0]) / (dt * steepness)),
        speed: [middle[0].iter().sum(), middle[1].iter().sum()],
        held: [0, 1].map(|d| 0.5 * (before.caught[d] + state.caught[d])),
    };
    model.bound_waves.advance(&mut state.bound_waves, dt, &first);
    state.heat_j += balance.heat_j;
    balance.residue_j = model.energy(state) + balance.heat_j - energy - balance.work_j;
    balance
}

/// Speed of the contact line, both directions together, m/s.
fn wall_speed(rate: &[[f64; RADIAL]; 2]) -> f64 {
    let sums = [rate[0].iter().sum::<f64>(), rate[1].iter().sum::<f64>()];
    sqrt(sums[0] * sums[0] + sums[1] * sums[1])
}

/// Friction of each mode and along the wall at `state`, N s/m.
fn resist(
    model: &ReducedModel,
    state: &ReducedState,
    friction: &mut [[f64; RADIAL]; 2],
    rubbing: &mut [f64; 2],
) {
    for (i, ready) in model.modes.iter().enumerate() {
        let amplitude = |d: usize| {
            let (a, v) = (state.height[d].get(i).copied(), state.rate[d].get(i).copied());
            let (a, v) = (a.unwrap_or(0.0), v.unwrap_or(0.0));
            v * v + ready.w * ready.w * a * a
        };
        let speed = sqrt(amplitude(0) + amplitude(1));
        let drawn = if i == 0 { model.law_rubs(speed) } else { 0.0 };
        for row in friction.iter_mut() {
            row.iter_mut().skip(i).take(1).for_each(|g| *g = ready.friction.at(speed) + drawn);
        }
    }
    if model.rubbing.is_empty() {
        return;
    }
    let speed = wall_speed(&state.rate);
    let place = model.modes[0].w * wall_speed(&state.height);
    let amplitude = sqrt(speed * speed + place * place);
    *rubbing = [model.line_rubs(amplitude); 2];
}

/// Forces on the first mode that depend on the state after the step.
struct FirstModeForces {
    /// Stiffness by the chord of the quartic energy, N/m.
    chord: f64,
    /// Height of the other direction in the middle, m.
    across: [f64; 2],
    /// Chord of the drawn law's energy, N.
    drawn_n: [f64; 2],
}

/// For each mode of direction `d`: the forces that do not depend on its rate, and one over what does.
fn row(
    model: &ReducedModel,
    before: &ReducedState,
    d: usize,
    push: &Forcing,
    friction: &[[f64; RADIAL]; 2],
    on_first: &FirstModeForces,
) -> Option<[(f64, f64); RADIAL]> {
    let dt = model.dt;
    let (a0, v0) = (before.height.get(d)?, before.rate.get(d)?);
    let (z0, g) = (before.memory.get(d)?, friction.get(d)?);
    let (along, across) = (push.along_m_s2.get(d)?, on_first.across.get(d)?);
    let (chord, drawn) = (on_first.chord, on_first.drawn_n.get(d)?);
    let mut rows = [(0.0, 0.0); RADIAL];
    let states = a0.iter().zip(v0).zip(z0.iter().zip(g));
    for (i, ((slot, ready), (branch, ((a, v), (z, g))))) in
        rows.iter_mut().zip(&model.modes).zip(model.memory.iter().zip(states)).enumerate()
    {
        let m = ready.mode.mass_kg;
        let fade = 1.0 + 0.5 * dt * branch.relax.rate(0.0);
        let (first, turn) = if i == 0 { (chord, model.coupling * across + drawn) } else { (0.0, 0.0) };
        let stiffness = ready.stiffness + ready.lift_kg_m * push.lift_m_s2 + first;
        let force =
            2.0 * m * v / dt - stiffness * a - branch.stiffness * z / fade - turn + ready.push_kg * along;
        *slot = (force, 1.0 / (2.0 * m / dt + 0.5 * dt * (stiffness + branch.stiffness / fade) + g));
    }
    Some(rows)
}

/// Moves direction `d` to the end of the step; returns heat and work, J.
#[allow(clippy::too_many_arguments, reason = "everything that one direction of a step is made of")]
fn finish(
    model: &ReducedModel,
    state: &mut ReducedState,
    before: &ReducedState,
    d: usize,
    middle: &[[f64; RADIAL]; 2],
    friction: &[[f64; RADIAL]; 2],
    rubbing: &[f64; 2],
    slip: f64,
    push: &Forcing,
) -> (f64, f64) {
    let dt = model.dt;
    let (mut heat, mut work, mut u) = (0.0, 0.0, 0.0);
    let along = push.along_m_s2.get(d).copied().unwrap_or(0.0);
    let (Some(height), Some(rate), Some(memory)) =
        (state.height.get_mut(d), state.rate.get_mut(d), state.memory.get_mut(d))
    else {
        return (0.0, 0.0);
    };
    let (Some(middle), Some(friction), Some(a0)) = (middle.get(d), friction.get(d), before.height.get(d))
    else {
        return (0.0, 0.0);
    };
    let parts = height.iter_mut().zip(rate.iter_mut()).zip(memory.iter_mut().zip(a0));
    for (((a, v0), (z, a0)), ((v, g), (ready, branch))) in
        parts.zip(middle.iter().zip(friction).zip(model.modes.iter().zip(&model.memory)))
    {
        let r = branch.relax.rate(0.0);
        let held = (*z + 0.5 * dt * v) / (1.0 + 0.5 * dt * r);
        *z = 2.0 * held - *z;
        *a += dt * v;
        *v0 = 2.0 * v - *v0;
        let half = 0.5 * (a0 + *a);
        heat += dt * (g * v * v + branch.stiffness * r * held * held);
        work += dt * v * (ready.push_kg * along - ready.lift_kg_m * push.lift_m_s2 * half);
        u += v;
    }
    for (caught, rub) in state.caught.iter_mut().zip(rubbing).skip(d).take(1) {
        let held = (*caught + 0.5 * dt * u) / (1.0 + 0.5 * dt * slip);
        *caught = 2.0 * held - *caught;
        heat += dt * (rub * u * u + model.line.stiffness * slip * held * held);
    }
    (heat, work)
}
