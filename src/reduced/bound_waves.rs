//! Second-order (bound) waves, which the first mode carries with it at twice its frequency, and in a tilted glass at its
//! own.
//!
//! ```text
//! s'' + 2 gamma s' + w^2 s = (p v1^2 + q w1^2 a1^2)/R + C a1 (v1' + w1^2 a1)/kappa1 + B t v1'/kappa1
//! ```
//! for s of (0,n) and (2,n). The quadratic terms of the surface conditions have this form for a standing wave (Miles
//! 1976); `coupling.rs` says what they are without viscosity. Of (0,1) and (2,1) p and q may be calibrated, and then belong
//! to the baseline; that q corrects B, too. `v1' + w1^2 a1` is what push, friction and the contact line do to the first mode,
//! which the product of height and potential feels at once. These waves ride along: their energy is of fourth order in the
//! amplitude and is left out of the books. With waves along x and y, `a1^2` is `ax^2 + ay^2` for (0,n), and `ax^2 - ay^2` and
//! `2 ax ay` for (2,n).
//!
//! In a glass that leans by t = tan theta the surface at rest is `t x` over the round cross-section: one side is
//! deeper than the other, and a wave along it does not stay in its mode; `v1'/kappa1 = -g a1 + b f` is how fast the
//! potential of the first mode changes. A camera that is rolled shows the same surface at rest and not this.

use super::modes::{BOUND_WAVE_SHAPES, RADIAL};
use crate::math::sqrt;
use crate::reduced::contact_line_friction::{ContactLineFriction, Dragged, SECTORS};
use crate::reduced::effects::Branch;
use crate::reduced::speed_table::SpeedTable;

/// State of the second-order waves, by shape and radial mode.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoundWaveState {
    /// Heights at the wall, m.
    pub height: [[f64; RADIAL]; BOUND_WAVE_SHAPES],
    /// Their rates, m/s.
    pub rate: [[f64; RADIAL]; BOUND_WAVE_SHAPES],
    /// Inner variables of the liquid, m.
    pub memory: [[f64; RADIAL]; BOUND_WAVE_SHAPES],
    /// Deflection of the contact line by them, by sector of the wall, m.
    pub caught: [f64; SECTORS],
}

/// Coefficients of one second-order wave (0,n) or (2,n).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundWave {
    /// Frequency squared, 1/s2.
    pub square: f64,
    /// Frequency squared of the discrete oscillator of the same period, 1/s2.
    pub discrete: f64,
    /// Damping gamma (1/s) by the amplitude of the first mode, which sets how thick the liquid is.
    pub damping: SpeedTable,
    /// Coefficients p and q of what the first mode drives.
    pub drive: [f64; 2],
    /// Coupling C to the forces on the first mode, 1/m2.
    pub carried: f64,
    /// Coupling `B t` to a lean along x, 1/m.
    pub lean: f64,
    /// Inner variable of the liquid; stiffness over the mass, 1/s2.
    pub memory: Branch,
}

/// The second-order waves of a glass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoundWaves {
    /// (0,n) and (2,n).
    pub waves: [[BoundWave; RADIAL]; 2],
    /// Radius R, m.
    pub radius_m: f64,
    /// Steepness of the first mode, 1/m.
    pub steepness: f64,
    /// The contact line, where it is held or slides.
    pub contact_line: Option<ContactLineFriction>,
}

/// Motion of the first mode in the middle of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FirstModeMotion {
    /// Its frequency squared, 1/s2.
    pub square: f64,
    /// Heights along x and y, m.
    pub height: [f64; 2],
    /// Their rates, m/s.
    pub rate: [f64; 2],
    /// Rate of change of its potential, m2/s2.
    pub turns: [f64; 2],
    /// Speed of the contact line, m/s.
    pub speed: [f64; 2],
    /// Deflection of the contact line, m.
    pub held: [f64; 2],
}

impl FirstModeMotion {
    /// `p` along `q`, in the three shapes.
    fn products(p: [f64; 2], q: [f64; 2]) -> [f64; BOUND_WAVE_SHAPES] {
        let ([px, py], [qx, qy]) = (p, q);
        [px * qx + py * qy, px * qx - py * qy, px * qy + py * qx]
    }
}

impl BoundWaves {
    /// Advances `state` by `dt` seconds beside the first mode.
    pub(super) fn advance(&self, state: &mut BoundWaveState, dt: f64, first: &FirstModeMotion) {
        let FirstModeMotion { height, rate, turns, .. } = *first;
        let rates = FirstModeMotion::products(rate, rate);
        let heights = FirstModeMotion::products(height, height);
        let gravity = first.square / self.steepness;
        let forced = FirstModeMotion::products(height, [0, 1].map(|d| turns[d] + gravity * height[d]));
        let leans = [turns[0], turns[0], turns[1]];
        let amplitude = sqrt(rates[0] + first.square * heights[0]);
        let [ring, saddle] = &self.waves;
        let kinds = [ring, saddle, saddle];
        let dragged = Dragged { speed: first.speed, held: first.held };
        let sliding = self.contact_line.as_ref().map(|line| (line, line.slide(dt, &state.caught, &dragged)));
        let mut middle = state.rate;
        // Along the line the waves move one another a little.
        let repeats = if sliding.is_some() { 2 } else { 1 };
        for _ in 0..repeats {
            for (j, waves) in kinds.iter().enumerate() {
                let by = |values: &[f64; BOUND_WAVE_SHAPES]| values.get(j).copied().unwrap_or(0.0);
                for (n, wave) in waves.iter().enumerate() {
                    let of = |values: &[[f64; RADIAL]; BOUND_WAVE_SHAPES]| {
                        values.get(j).and_then(|row| row.get(n)).copied().unwrap_or(0.0)
                    };
                    let [p, q] = wave.drive;
                    let push = (p * by(&rates) + q * first.square * by(&heights)) / self.radius_m
                        + wave.carried * by(&forced)
                        + wave.lean * by(&leans);
                    // Implicit in the middle, with the stiffness that keeps the frequency exact.
                    let fade = 1.0 + 0.5 * dt * wave.memory.relax.rate(0.0);
                    let [held, grip] = sliding.as_ref().map_or([0.0; 2], |(line, sliding)| {
                        let spring =
                            line.square.get(j.min(1)).and_then(|row| row.get(n)).copied().unwrap_or(0.0);
                        sliding.pull(j, of(&middle), &middle).map(|pull| spring * pull)
                    });
                    let pulled = wave.memory.stiffness * of(&state.memory) / fade + held;
                    let stores = wave.discrete + wave.memory.stiffness / fade;
                    let now = (2.0 * of(&state.rate) / dt - wave.discrete * of(&state.height)
                        + push * wave.discrete / wave.square
                        - pulled)
                        / (2.0 / dt + 0.5 * stores * dt + 2.0 * wave.damping.at(amplitude) + grip);
                    middle.iter_mut().skip(j).take(1).flatten().skip(n).take(1).for_each(|slot| *slot = now);
                }
            }
        }
        if let Some((_, sliding)) = sliding {
            sliding.finish(&mut state.caught, &middle);
        }
        let waves = kinds.iter().copied().flatten();
        let slots = state.height.as_flattened_mut().iter_mut().zip(state.rate.as_flattened_mut());
        let slots = slots.zip(state.memory.as_flattened_mut().iter_mut().zip(waves));
        for (((height, rate), (memory, wave)), middle) in slots.zip(middle.as_flattened()) {
            *height += dt * middle;
            *rate = 2.0 * middle - *rate;
            let held = (*memory + 0.5 * dt * middle) / (1.0 + 0.5 * dt * wave.memory.relax.rate(0.0));
            *memory = 2.0 * held - *memory;
        }
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods, reason = "a test may take the platform's functions")]
mod tests {
    use super::*;

    #[test]
    fn a_steady_push_lifts_the_wave_to_its_static_height_and_a_planar_wave_drives_no_sine() {
        let wave = |square: f64, q: f64| BoundWave {
            square,
            discrete: square,
            damping: SpeedTable::constant(5.0),
            drive: [0.0, q],
            carried: 0.0,
            lean: 0.0,
            memory: Branch::default(),
        };
        let waves = [[wave(900.0, 0.5); RADIAL], [wave(700.0, -0.25); RADIAL]];
        let order = BoundWaves { waves, radius_m: 0.035, steepness: 52.0, contact_line: None };
        let first = FirstModeMotion {
            square: 500.0,
            height: [0.01, 0.0],
            rate: [0.0; 2],
            turns: [0.0; 2],
            speed: [0.0; 2],
            held: [0.0; 2],
        };
        let mut waves = BoundWaveState::default();
        for _ in 0..4000 {
            order.advance(&mut waves, 1.0 / 240.0, &first);
        }
        let wanted = 0.5 * 500.0 * 1e-4 / 0.035 / 900.0;
        assert!((waves.height[0][0] / wanted - 1.0).abs() < 1e-6, "{} for {wanted}", waves.height[0][0]);
        assert!(waves.height[1][0] < 0.0 && waves.height[2] == [0.0; RADIAL]);
    }

    #[test]
    fn what_holds_the_first_mode_up_lifts_the_waves_that_its_height_carries() {
        let wave = BoundWave {
            square: 900.0,
            discrete: 900.0,
            damping: SpeedTable::constant(5.0),
            drive: [0.0; 2],
            carried: 30.0,
            lean: 0.0,
            memory: Branch::default(),
        };
        let order =
            BoundWaves { waves: [[wave; RADIAL]; 2], radius_m: 0.035, steepness: 50.0, contact_line: None };
        let settled = |turns: f64| {
            let first = FirstModeMotion {
                square: 500.0,
                height: [0.0, 0.01],
                rate: [0.0; 2],
                turns: [0.0, turns],
                speed: [0.0; 2],
                held: [0.0; 2],
            };
            let mut waves = BoundWaveState::default();
            for _ in 0..4000 {
                order.advance(&mut waves, 1.0 / 240.0, &first);
            }
            waves.height.map(|row| row[0])
        };
        // Let go, gravity alone turns it: psi1' = -w1^2 a1/kappa1, which q counts.
        assert!(settled(-500.0 * 0.01 / 50.0).iter().all(|s| s.abs() < 1e-12));
        // Held up, psi1' = 0: C a1 w1^2 a1/kappa1, along y against the first saddle.
        let wanted = 30.0 * 0.01 * 500.0 * 0.01 / 50.0 / 900.0;
        let [ring, along, across] = settled(0.0);
        assert!((ring / wanted - 1.0).abs() < 1e-6 && (along / wanted + 1.0).abs() < 1e-6, "{ring} {along}");
        assert!(across.abs() < 1e-12);
    }
}
