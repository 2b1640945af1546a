//! Hidden laws: forces on the first mode that the library of effects does not hold.
//!
//! ```text
//! f = m w^2 A spring(a/A),     D = m w^2 A drag(a/A, v/(w A)),     A = 15 mm
//! ```

use std::f64::consts::TAU;

/// Height that laws are counted in, m.
const UNIT_M: f64 = 0.015;

/// Points of a cycle.
const CYCLE: usize = 720;

/// First mode of a glass: what hidden laws are counted in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstMode {
    /// Frequency, 1/s.
    pub frequency: f64,
    /// Mass m, kg: kinetic energy is m v^2/2.
    pub mass_kg: f64,
}

/// One hidden law.
#[derive(Clone, Copy, Debug)]
pub struct HiddenLaw {
    /// Name, for people.
    pub name: &'static str,
    /// Conservative force in its unit.
    pub spring: fn(f64) -> f64,
    /// Drag in its unit, by height and rate; its power is never negative.
    pub drag: fn(f64, f64) -> f64,
    /// Factor on both.
    pub size: f64,
    /// Effects of the library that are the same law, and are taken out of it.
    pub same: &'static [&'static str],
}

/// Returns what is left of `x` outside of `dead` on either side of zero.
fn outside(x: f64, dead: f64) -> f64 {
    x.signum() * (x.abs() - dead).max(0.0)
}

/// No force.
fn nothing(_: f64) -> f64 {
    0.0
}

/// No drag.
fn smooth(_: f64, _: f64) -> f64 {
    0.0
}

/// Dry friction with a dead zone.
fn caught(_: f64, v: f64) -> f64 {
    let beyond = outside(v, 0.2);
    0.1 * beyond / (beyond.abs() + 0.1)
}

/// A magnet beside the glass: it pulls to one side, more the nearer the crest comes.
fn magnet(x: f64) -> f64 {
    -0.25 * ((1.0 - x / 3.0).powi(-2) - 1.0)
}

/// The laws that are judged.
pub const JUDGED: [HiddenLaw; 12] = [
    law("hardening spring", |x| 0.35 * x.powi(3) / (1.0 + 0.3 * x * x), smooth, &["detuning"]),
    law("end stop on one side", |x| 0.9 * (x - 0.4).max(0.0).powi(2), smooth, &[]),
    law("magnet on one side", magnet, smooth, &[]),
    law("spring with play", |x| 0.5 * outside(x, 0.4), smooth, &["detuning"]),
    law("attraction near rest", |x| -0.3 * x / (1.0 + 2.0 * x * x), smooth, &[]),
    law("drag of power 1.5", nothing, |_, v| 0.25 * v.signum() * v.abs().powf(1.5), &[]),
    law("dry friction with a dead zone", nothing, caught, &[]),
    law("damping by amplitude", nothing, |x, v| 0.4 * x * x * v, &[]),
    law("quadratic drag", nothing, |_, v| 0.25 * v.abs() * v, &[]),
    law(
        "hardening and power 1.5",
        |x| 0.35 * x.powi(3),
        |_, v| 0.2 * v.signum() * v.abs().powf(1.5),
        &["detuning"],
    ),
    law("magnet and dry friction", magnet, caught, &[]),
    law("damping at large amplitude", nothing, |x, v| 0.6 * (x.abs() - 0.4).max(0.0) * v, &[]),
];

/// The laws that bands are calibrated on, and nothing is judged by.
pub const CALIBRATION: [HiddenLaw; 8] = [
    law("softening spring", |x| -0.3 * x.powi(3) / (1.0 + x * x), smooth, &["detuning"]),
    law("lopsided spring", |x| 0.25 * x * x, smooth, &[]),
    law("stiffer to one side", |x| if x > 0.0 { 0.3 * x } else { 0.0 }, smooth, &[]),
    law("drag of power 0.5", nothing, |_, v| 0.12 * v.signum() * v.abs().sqrt(), &[]),
    law("cubic drag", nothing, |_, v| 0.25 * v.powi(3), &[]),
    law("lopsided and saturating drag", |x| -0.2 * x * x, |_, v| 0.2 * v / (1.0 + v * v), &[]),
    law(
        "dry friction that begins late",
        nothing,
        |_, v| 0.12 * outside(v, 0.4) / (outside(v, 0.4).abs() + 0.05),
        &[],
    ),
    law("friction of a slow wave", nothing, |_, v| 0.3 * v / (1.0 + 12.0 * v * v), &[]),
];

const fn law(
    name: &'static str,
    spring: fn(f64) -> f64,
    drag: fn(f64, f64) -> f64,
    same: &'static [&'static str],
) -> HiddenLaw {
    HiddenLaw { name, spring, drag, size: 1.0, same }
}

impl HiddenLaw {
    /// Returns the force over the mass at a height (m) and a rate (m/s) of a mode of `frequency` (1/s), m/s2.
    #[must_use]
    pub fn acceleration_m_s2(&self, height_m: f64, rate_m_s: f64, frequency: f64) -> f64 {
        let (x, y) = (height_m / UNIT_M, rate_m_s / (frequency * UNIT_M));
        self.size * frequency * frequency * UNIT_M * ((self.spring)(x) + (self.drag)(x, y))
    }

    /// Returns the conservative force on `mode` at a height, N.
    #[must_use]
    pub fn force_n(&self, mode: &FirstMode, height_m: f64) -> f64 {
        let unit = mode.mass_kg * mode.frequency * mode.frequency * UNIT_M;
        self.size * unit * ((self.spring)(height_m / UNIT_M) - (self.spring)(0.0))
    }

    /// Returns the first harmonic of the drag in a cycle of `mode` whose rate reaches `rate_m_s`, N.
    #[must_use]
    pub fn drag_n(&self, mode: &FirstMode, rate_m_s: f64) -> f64 {
        let unit = mode.mass_kg * mode.frequency * mode.frequency * UNIT_M;
        let reach = rate_m_s / (mode.frequency * UNIT_M);
        let one = |n: usize| {
            let (sin, cos) = ((n as f64 + 0.5) * TAU / CYCLE as f64).sin_cos();
            (self.drag)(reach * sin, reach * cos) * cos
        };
        self.size * unit * 2.0 / CYCLE as f64 * (0..CYCLE).map(one).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_hidden_drag_drives_the_liquid_and_each_law_does_something() {
        let mode = FirstMode { frequency: 22.0, mass_kg: 0.03 };
        for law in JUDGED.iter().chain(&CALIBRATION) {
            for i in -20..=20 {
                for j in -20..=20 {
                    let (x, v) = (0.1 * f64::from(i), 0.1 * f64::from(j));
                    assert!((law.drag)(x, v) * v >= 0.0, "{}", law.name);
                }
            }
            let force = law.force_n(&mode, 0.012).abs() + law.force_n(&mode, -0.012).abs();
            assert!(force + law.drag_n(&mode, 0.3) > 1e-3, "{}", law.name);
        }
        // A linear drag is its own first harmonic; a quadratic one has 8/(3 pi) of it.
        let quadratic = JUDGED.iter().find(|law| law.name == "quadratic drag").expect("there");
        let unit = mode.mass_kg * mode.frequency.powi(2) * UNIT_M;
        let reach: f64 = 0.3 / (mode.frequency * UNIT_M);
        let wanted = 0.25 * unit * reach * reach * 8.0 / (3.0 * std::f64::consts::PI);
        assert!((quadratic.drag_n(&mode, 0.3) / wanted - 1.0).abs() < 1e-4);
    }
}
