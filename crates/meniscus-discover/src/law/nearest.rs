//! Nearest formula of the library to a drawn law, and where the law departs from it.
//!
//! Each fitted effect is compared as a pair of curves too: the first harmonics of the force that its reduced model adds to
//! the baseline of the law, at the heights and rates of the bands.
//! ```text
//! f(a) = dE/da with the effect less dE/da without + F_1/pi int z cos,       D(u) = G u with less without + F_1/pi int z sin
//! ```
//! where z is what an inner variable (viscoelastic, contact line) answers to a cycle of that height.

use super::band::{Band, Bands};
use super::fit::LawFit;
use crate::baseline::predict::reduced_model;
use crate::decision::rank::Candidate;
use crate::recordings::stated::Known;
use meniscus::reduced::effects::Branch;
use meniscus::reduced::{ReducedModel, ReducedState};
use std::f64::consts::TAU;

/// Step of the derivative of an energy, as a part of the reach.
const WIDTH: f64 = 1e-4;

/// Steps of one cycle of an inner variable, and cycles until it repeats itself.
const CYCLE: usize = 240;
const CYCLES: usize = 3;

/// Range in which a curve lies outside of the band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least height, m, or rate, m/s.
    pub from: f64,
    /// Largest one.
    pub to: f64,
}

/// Nearest formula of the library.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearest {
    /// Effect.
    pub name: &'static str,
    /// Its conservative force at the heights of the band, N.
    pub force_n: Vec<f64>,
    /// Its drag at the rates of the band, N.
    pub drag_n: Vec<f64>,
    /// Root mean square distance of both curves, in half-widths of the bands.
    pub distance: f64,
    /// Heights at which the force departs by more than its band.
    pub heights: Vec<Range>,
    /// Rates at which the drag departs by more than its band.
    pub rates: Vec<Range>,
}

/// Returns the formula among the fitted `ranking` whose curves are nearest to those of `bands`; none where nothing was
/// fitted.
#[must_use]
pub fn nearest(
    fit: &LawFit,
    bands: &Bands,
    ranking: &[Candidate],
    known: &Known,
    interval_s: f64,
) -> Option<Nearest> {
    let base = reduced_model(known, &fit.theta, &[], interval_s);
    let one = |candidate: &Candidate| {
        let fitted = candidate.fitted.as_ref()?;
        let with = reduced_model(known, &fitted.theta, &fitted.active, interval_s);
        let force_n: Vec<f64> = bands.force.at.iter().map(|a| force(&with, *a) - force(&base, *a)).collect();
        let drag_n: Vec<f64> = bands.drag.at.iter().map(|u| drag(&with, *u) - drag(&base, *u)).collect();
        let parts = [bands.force.distance(&force_n), bands.drag.distance(&drag_n)];
        let distance = (0.5 * parts.iter().map(|d| d * d).sum::<f64>()).sqrt();
        let (heights, rates) = (departures(&bands.force, &force_n), departures(&bands.drag, &drag_n));
        Some(Nearest { name: candidate.last(), force_n, drag_n, distance, heights, rates })
    };
    ranking.iter().filter_map(one).min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Returns the ranges in which `curve` lies outside of `band`.
fn departures(band: &Band, curve: &[f64]) -> Vec<Range> {
    let mut out: Vec<Range> = Vec::new();
    let mut open = false;
    for ((at, (value, half)), other) in band.at.iter().zip(band.value.iter().zip(&band.half)).zip(curve) {
        let outside = (other - value).abs() > *half;
        match out.last_mut().filter(|_| open && outside) {
            Some(range) => range.to = *at,
            None if outside => out.push(Range { from: *at, to: *at }),
            None => {}
        }
        open = outside;
    }
    out
}

/// Returns the conservative force of `model` on its first mode at the height `a`, N, inner variables included.
fn force(model: &ReducedModel, a: f64) -> f64 {
    let energy = |height: f64| {
        let mut state = ReducedState::default();
        state.height[0][0] = height;
        model.energy(&state)
    };
    let h = WIDTH * a.abs();
    let elastic = (energy(a + h) - energy(a - h)) / (2.0 * h);
    let inner: f64 =
        model.branches().iter().map(|branch| answer(branch, model.frequency(), a.abs())[0]).sum();
    elastic + inner * a.signum()
}

/// Returns the drag of `model` on its first mode in a cycle whose rate reaches `u`, N, inner variables included.
fn drag(model: &ReducedModel, u: f64) -> f64 {
    let w = model.frequency();
    let inner: f64 = model.branches().iter().map(|branch| answer(branch, w, u / w)[1]).sum();
    model.first_mode_friction(u) * u + inner
}

/// Returns the first harmonics of the force of `branch` in a cycle of the height `a` at the frequency `w`, N: in phase with
/// the height, and with the rate.
fn answer(branch: &Branch, w: f64, a: f64) -> [f64; 2] {
    if branch.stiffness == 0.0 {
        return [0.0; 2];
    }
    let dt = TAU / w / CYCLE as f64;
    let (mut z, mut sums) = (0.0, [0.0; 2]);
    for n in 0..CYCLE * CYCLES {
        let (sin, cos) = ((n as f64 + 0.5) * TAU / CYCLE as f64).sin_cos();
        // Height a sin, rate a w cos; z in the middle of the step, as in the model.
        let (v, speed) = (a * w * cos, (a * w * cos).abs());
        let middle = (z + 0.5 * dt * v) / (1.0 + 0.5 * dt * branch.relax.rate(speed));
        z = 2.0 * middle - z;
        if n >= CYCLE * (CYCLES - 1) {
            sums[0] += 2.0 / CYCLE as f64 * branch.stiffness * middle * sin;
            sums[1] += 2.0 / CYCLE as f64 * branch.stiffness * middle * cos;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::reduced::effects::Relax;

    #[test]
    fn the_first_harmonics_of_a_memory_and_of_dry_friction_are_those_of_textbooks() {
        // Maxwell: k (w l)^2/(1 + (w l)^2) in phase, k w l/(1 + (w l)^2) in quadrature, for each height.
        let (w, lambda) = (20.0, 0.03);
        let branch = Branch { stiffness: 3.0, relax: Relax::Time(lambda) };
        let [spring, loss] = answer(&branch, w, 0.01);
        let x: f64 = w * lambda;
        assert!((spring - 0.03 * x * x / (1.0 + x * x)).abs() < 2e-3 * 0.03, "{spring}");
        assert!((loss - 0.03 * x / (1.0 + x * x)).abs() < 2e-3 * 0.03, "{loss}");
        // Dry friction F: 4 F/pi, where the way is long beside the reach.
        let branch = Branch { stiffness: 100.0, relax: Relax::Path(1e-4) };
        let [_, loss] = answer(&branch, w, 0.02);
        assert!((loss / (4.0 / std::f64::consts::PI * 0.01) - 1.0).abs() < 0.03, "{loss}");
    }

    #[test]
    fn departures_are_the_ranges_outside_of_the_band() {
        let band = Band { at: vec![1.0, 2.0, 3.0, 4.0, 5.0], value: vec![0.0; 5], half: vec![0.5; 5] };
        let found = departures(&band, &[0.6, -0.7, 0.4, 0.0, 0.9]);
        assert_eq!(found, [Range { from: 1.0, to: 2.0 }, Range { from: 5.0, to: 5.0 }]);
    }
}
