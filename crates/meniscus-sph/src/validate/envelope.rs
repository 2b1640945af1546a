//! The envelope of a slosh in a liquid whose viscosity depends on the rate of shear: equivalent
//! linearisation of the dissipation (Krylov and Bogoliubov 1937).
//!
//! A mode of amplitude `A` and of a liquid of viscosity `mu_e` dissipates as much in a period as the
//! liquid `mu(rate)` does in the same field when
//! ```text
//! mu_e = <int mu(rate) rate^2 dV> / <int rate^2 dV>,      rate^2 = 2 D:D,    <> over a period
//! A'   = -gamma(mu_e(A)) A
//! ```
//! with `gamma(mu)` and the field from the Ritz solution of the linear problem at that viscosity. `A` is
//! the speed at the top of the wall of the inviscid mode that has the same energy. Without a yield stress
//! the law becomes `A' ~ -A^((1+n)/2)` where the wall layer is thin and `A^n` where it is not; a yield
//! stress makes `mu_e` grow as `1/A`, until the mode no longer oscillates: from there on it creeps.

use super::theory::{Mode, Tone};
use super::viscous::{COARSE, Problem, Viscosity};
use meniscus::units::GRAVITY_M_S2;
use meniscus_data::liquids::Rheology;
use meniscus_data::recording::Glass;
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};

/// Viscosities of the table: the first, how much each is larger than the last, how many, Pa s.
const TABLE: (f64, f64, usize) = (0.02, 1.35, 22);

/// Points around half the glass and in half a period.
const AROUND: usize = 6;

/// One mode of the table.
#[derive(Clone, Debug)]
struct Entry {
    viscosity: f64,
    tone: Tone,
    /// Weight of each node, and the six parts of `D` there as complex amplitudes, 1/s for `A` = 1 m/s;
    /// their squares sum to `2 D:D`.
    nodes: Vec<(f64, [Complex<f64>; 6])>,
}

/// The law of one glass, for liquids of one density that stick to it.
#[derive(Clone, Debug)]
pub struct Envelope {
    table: Vec<Entry>,
}

impl Envelope {
    /// Solves the linear problem for the viscosities of the table, up to the first that does not oscillate.
    #[must_use]
    pub fn new(glass: &Glass, density: f64) -> Self {
        let (radius, rate) = (glass.radius_m, (GRAVITY_M_S2 / glass.radius_m).sqrt());
        let problem = Problem::new(glass.fill_m / radius, 0.0, COARSE);
        let mode = Mode::first(*glass);
        let mut table: Vec<Entry> = Vec::new();
        for index in 0..TABLE.2 {
            let viscosity = TABLE.0 * TABLE.1.powi(index as i32);
            let nu = viscosity / density;
            let guess = match table.last() {
                Some(Entry { tone, .. }) => Complex::new(-tone.decay, TAU * tone.hz) / rate,
                None => Complex::new(-mode.layer_decay(nu), TAU * mode.hz()) / rate,
            };
            let scaled = Viscosity { nu: nu / (radius * radius * rate), memory: None };
            let Some((root, x)) = problem.root(guess, scaled) else { break };
            // A mode that dies within a period is no slosh.
            if !(root.im > -root.re && root.re.is_finite()) {
                break;
            }
            // The same kinetic energy in the mean as the inviscid mode of 1 m/s: without dimension, int of
            // |u|^2 over the section.
            let scale = (inviscid_square(&mode, glass) / problem.square(&x)).sqrt() / radius;
            let [re, im] = [x.map(|c| c.re), x.map(|c| c.im)].map(|part| &problem.strain * part);
            let nodes = problem.weights.iter().enumerate().map(|(node, weight)| {
                let amplitude = |k: usize| Complex::new(re[6 * node + k], im[6 * node + k]);
                (*weight, std::array::from_fn(|k| amplitude(k) * (scale / weight.sqrt())))
            });
            let nodes = nodes.collect();
            let tone = Tone { hz: root.im * rate / TAU, decay: -root.re * rate };
            table.push(Entry { viscosity, tone, nodes });
        }
        Self { table }
    }

    /// Equivalent viscosity (Pa s) and the decay (1/s) at amplitude `speed_m_s`; `None` where the liquid no
    /// longer oscillates, or is thinner than the table.
    #[must_use]
    pub fn decay(&self, rheology: &Rheology, speed_m_s: f64) -> Option<(f64, f64)> {
        // The excess of the liquid's viscosity over the table's falls through zero at the solution.
        let mut last: Option<(f64, &Entry)> = None;
        for entry in &self.table {
            let excess = (entry.equivalent(rheology, speed_m_s) / entry.viscosity).ln();
            if let Some((before, below)) = last.filter(|(before, _)| *before >= 0.0 && excess < 0.0) {
                let part = before / (before - excess);
                let mix = |a: f64, b: f64| (a.ln() + part * (b / a).ln()).exp();
                let viscosity = mix(below.viscosity, entry.viscosity);
                return Some((viscosity, mix(below.tone.decay, entry.tone.decay)));
            }
            last = Some((excess, entry));
        }
        None
    }

    /// Amplitude after `seconds` from `speed_m_s`, and the time at which the oscillation ended, if it did.
    #[must_use]
    pub fn follow(&self, rheology: &Rheology, speed_m_s: f64, seconds: f64) -> (f64, Option<f64>) {
        let steps = (seconds / 0.01).ceil().max(1.0);
        let (dt, mut speed) = (seconds / steps, speed_m_s);
        for step in 0..steps as usize {
            // Heun's step on ln A.
            let Some((_, first)) = self.decay(rheology, speed) else {
                return (speed, Some(dt * step as f64));
            };
            let second = self.decay(rheology, speed * (-dt * first).exp()).map_or(first, |(_, decay)| decay);
            speed *= (-0.5 * dt * (first + second)).exp();
        }
        (speed, None)
    }
}

impl Entry {
    /// `mu_e` of `rheology` in this mode at amplitude `speed_m_s`.
    fn equivalent(&self, rheology: &Rheology, speed_m_s: f64) -> f64 {
        let (mut power, mut square) = (0.0, 0.0);
        for around in 0..AROUND {
            // Squares have the period pi in azimuth and phase, and are even about the half of it.
            let (sin, cos) = (PI * (around as f64 + 0.5) / (2 * AROUND) as f64).sin_cos();
            for phase in 0..2 * AROUND {
                let turn = Complex::from_polar(speed_m_s, PI * (phase as f64 + 0.5) / (2 * AROUND) as f64);
                for (weight, d) in &self.nodes {
                    // rr, aa, zz, rz go with the cosine of the azimuth, ra and az with its sine.
                    let part = |k: usize, by: f64| ((d[k] * turn).re * by).powi(2);
                    let even = part(0, cos) + part(1, cos) + part(2, cos) + part(4, cos);
                    let rate2 = even + part(3, sin) + part(5, sin);
                    power += weight * rheology.viscosity(rate2.sqrt()) * rate2;
                    square += weight * rate2;
                }
            }
        }
        power / square
    }
}

/// `int |u|^2 r dr dz` without dimension of the inviscid mode with 1 m/s at the top of the wall, from
/// `int |grad phi|^2 dV = int phi phi_z dA` on the surface.
fn inviscid_square(mode: &Mode, glass: &Glass) -> f64 {
    // phi = w/(k tanh k h) on the surface; int w^2 dA = pi R^2/2 (1 - 1/xi^2); over pi R^3.
    let k = mode.wave_number();
    let xi = k * glass.radius_m;
    0.5 * (1.0 - xi.powi(-2)) / (xi * (k * glass.fill_m).tanh())
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_data::glass::WallShape;

    #[test]
    fn a_newtonian_liquid_decays_as_the_eigenvalue_says_and_a_thinning_one_slower_when_it_moves_faster() {
        let glass = Glass { radius_m: 0.035, fill_m: 0.07, rim_m: 0.11, wall: WallShape::UPRIGHT };
        let envelope = Envelope::new(&glass, 1261.0);
        let (viscosity, decay) = envelope.decay(&Rheology::newtonian(0.95), 0.1).expect("it oscillates");
        assert!((viscosity / 0.95 - 1.0).abs() < 1e-6 && (decay / 6.69 - 1.0).abs() < 0.01, "{decay}");
        let thinning = Rheology { consistency: 2.0, index: 0.5, yield_stress: 0.0, largest: 20.0 };
        let [slow, fast] = [0.05, 0.2].map(|speed| envelope.decay(&thinning, speed).expect("it oscillates"));
        // mu ~ rate^(n-1): a four times faster mode is about half as viscous.
        assert!((slow.0 / fast.0 - 2.0).abs() < 0.35, "{slow:?} {fast:?}");
        let plastic = Rheology { consistency: 0.5, index: 0.5, yield_stress: 3.0, largest: 20.0 };
        let (speed, end) = envelope.follow(&plastic, 0.05, 3.0);
        println!("{slow:?} {fast:?} {speed} {end:?}");
        assert!(end.is_some_and(|end| (0.0..1.0).contains(&end)), "{end:?}");
    }
}
