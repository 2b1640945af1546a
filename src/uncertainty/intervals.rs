//! Half-widths of an estimate with 90 % coverage, from the error covariance P of the filter (`crate::filter`).
//!
//! ```text
//! half = k sqrt(J P J^T + y + (1 - s) w d + g^2)     of a height; of a field group without y, s and g, the mean over its numbers;
//!                                                  k of a height grows while nothing is seen
//! P-   = A P A^T + m^2 a w Q + f dt^2 B B^T  of a forecast, turn by turn, from m^2 P on; f = 1 where the motion is not planned,
//!                                            else 0; w of the liveliest slosh from the estimate on
//! ```
//! A is the closed step linearised about rest. Q is the covariance of the step's error, R that of the encoder's, d the
//! variance of the decoder's, each for a unit of w = floor + H(x): a livelier slosh is known less well. g is the error at a
//! surface at rest, which no slosh explains. y is the part of a cross-axis slosh ([`crate::uncertainty::cross_axis`]), s the
//! share of w d that a measured height puts right ([`crate::uncertainty::discrepancy`]), a the process noise scale of the
//! filter. m scales what the model is wrong by (`src/uncertainty/disagreement.rs`): each term of a height, but not an acceleration
//! that nobody planned, which is as large for a model that is right.
//!
//! The errors are neither white nor Gaussian, so P gives only their distribution over points and time. Their size comes from k
//! ([`crate::uncertainty::error_factors::ErrorFactors`]), the 90 % quantile of |error| / half on held-out recordings (split
//! conformal: Lei et al., J. Am. Stat. Assoc. 113 (2018) 1094).

use crate::latent::generic::{LATENTS, Latent, LatentOf};
use crate::math::sqrt;
use crate::real::{Real, narrow};
use crate::surface::POINTS;
use crate::uncertainty::discrepancy::Discrepancy;
use crate::uncertainty::error_factors::LEADS;
use crate::uncertainty::error_model::{Covariance, ErrorModel, SPREAD_OF, unknown};
use nalgebra::SMatrix;

/// Matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Position of the internal energy among the groups of the decoder.
pub(crate) const ENERGY: usize = 2;

/// Heat below which the internal energy counts as not yet known, in units of H.
const HEAT_FLOOR: f64 = 0.02;

/// Half-widths that hold nine times out of ten.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Interval {
    /// Of each of the 21 heights, m.
    pub surface_m: [f32; POINTS],
    /// Of any one number of q (m), v (m/s), e (J/kg), sigma and tau (Pa).
    pub field: [f32; 5],
}

/// State of an estimate, as its interval depends on it.
#[derive(Clone, Copy, Debug)]
pub struct IntervalInput<'a> {
    /// Error covariance.
    pub covariance: &'a Covariance,
    /// y: variance that a cross-axis slosh adds to each height, m2.
    pub lateral_variance_m2: &'a [f64; POINTS],
    /// s of each height.
    pub discrepancy: &'a Discrepancy,
    /// H(x).
    pub latent_energy: f64,
    /// Heat, in units of H.
    pub heat: f64,
    /// Joules of one unit of H.
    pub energy_scale_j: f64,
    /// Turns in a row, up to this one, without heights and without a known motion of the glass.
    pub blind_turns: u32,
}

/// Reach of a forecast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Horizon {
    /// Turns ahead.
    pub frames: usize,
    /// Turns for which the motion of the glass is planned.
    pub planned: usize,
}

/// P- of a forecast, carried on turn by turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CarriedCovariance {
    p: Square,
    /// m^2 a.
    process_noise_scale: f64,
    /// w of the liveliest slosh so far.
    weight: f64,
    /// m^2 ([`crate::uncertainty::disagreement`]).
    scale2: f64,
}

/// Variances of the heights but for those of the latents.
#[derive(Clone, Copy)]
struct HeightErrors<'a> {
    /// y, m2.
    lateral_variance_m2: &'a [f64; POINTS],
    /// s.
    discrepancy: &'a Discrepancy,
    /// w.
    weight: f64,
    /// m^2, but of the latents' variance, which has it already.
    scale2: f64,
}

impl ErrorModel<'_> {
    /// P- of a forecast's turn in which the step's error is `missed` times Q, under the motion of `glass`; `kick` is dt B.
    fn predict(&self, p: &mut Square, kick: &Latent, missed: f64, glass: Glass) {
        let mut next = self.transition * *p * self.transition.transpose() + self.process * missed;
        if glass == Glass::Free {
            next += kick * kick.transpose();
        }
        // A hostile blob may drive it anywhere: a P that is not finite says as much as knowing nothing.
        *p = if next.iter().all(|v| v.is_finite()) { next } else { unknown() };
    }

    /// Returns the half-widths of an estimate.
    #[must_use]
    pub fn interval<R: Real>(&self, of: &IntervalInput<'_>) -> Interval {
        let IntervalInput { covariance: p, lateral_variance_m2, discrepancy, .. } = *of;
        let weight = self.weight(of.latent_energy);
        let surface_k = self.factors.of_estimate(of.blind_turns);
        let latents = narrow::<R, _, _>(&p.latents);
        let mut field = [0.0; 5];
        let groups = self.groups.iter().zip(self.pushed).zip(SPREAD_OF).zip(self.group_misfit);
        for (((group, pushed), slot), d) in groups {
            let trace: R = group.iter().zip(latents.iter()).map(|(j, v)| R::of(*j) * *v).sum();
            let variance = trace.wide() + pushed * p.input + weight * f64::from(*d);
            if let Some(half) = field.get_mut(slot) {
                *half = (self.field_factor(slot) * sqrt(variance.max(0.0))) as f32;
            }
        }
        let energy = self.field_factor(ENERGY) * of.energy_scale_j * (of.heat + HEAT_FLOOR);
        if let Some(half) = field.get_mut(ENERGY) {
            *half = energy as f32;
        }
        let errors = HeightErrors { lateral_variance_m2, discrepancy, weight, scale2: 1.0 };
        Interval { surface_m: self.heights::<R>(&p.latents, errors, surface_k), field }
    }

    /// Returns the covariance of an estimate, to be carried on turn by turn, with the errors of the model scaled by m, `scale`.
    pub(crate) fn carried(
        &self,
        covariance: &Covariance,
        latent_energy: f64,
        scale: f64,
    ) -> CarriedCovariance {
        let Covariance { latents, process_noise_scale, .. } = *covariance;
        let scale2 = scale * scale;
        CarriedCovariance {
            p: latents * scale2,
            process_noise_scale: scale2 * process_noise_scale,
            weight: self.weight(latent_energy),
            scale2,
        }
    }

    /// Carries a covariance from `at.frames` turns ahead to the next one, at whose end the slosh has `latent_energy`; `kick`
    /// is dt B.
    ///
    /// w is that of the liveliest slosh so far: errors that come with a planned acceleration stay when it is over.
    pub(crate) fn carry(
        &self,
        carried: &mut CarriedCovariance,
        kick: &Latent,
        at: Horizon,
        latent_energy: f64,
    ) {
        let glass = if at.frames < at.planned { Glass::Planned } else { Glass::Free };
        self.predict(&mut carried.p, kick, carried.process_noise_scale * carried.weight, glass);
        carried.weight = carried.weight.max(self.weight(latent_energy));
    }

    /// Carries a covariance over `turns` more turns of a glass whose motion nobody knows. The slosh rings out, and w stays.
    pub(crate) fn carry_free(&self, carried: &mut CarriedCovariance, kick: &Latent, turns: usize) {
        for _ in 0..turns {
            self.predict(&mut carried.p, kick, carried.process_noise_scale * carried.weight, Glass::Free);
        }
    }

    /// Returns the half-widths of the surface of a covariance that was carried to `horizon`, m.
    ///
    /// k goes straight between the measured leads, for which the motion was planned whole or not at all, and stays beyond
    /// the last.
    pub(crate) fn carried_heights(
        &self,
        carried: &CarriedCovariance,
        lateral_variance_m2: &[f64; POINTS],
        horizon: Horizon,
    ) -> [f32; POINTS] {
        let Horizon { frames, planned } = horizon;
        let at_leads = if planned < frames { self.factors.surface } else { self.factors.of_a_plan() };
        self.carried_by(carried, lateral_variance_m2, factor_at(at_leads, frames))
    }

    /// Returns the half-widths of a crest at each height, m, where the motion is planned up to it.
    pub(crate) fn carried_crest(
        &self,
        carried: &CarriedCovariance,
        lateral_variance_m2: &[f64; POINTS],
    ) -> [f32; POINTS] {
        self.carried_by(carried, lateral_variance_m2, f64::from(self.factors.crest))
    }

    fn carried_by(
        &self,
        carried: &CarriedCovariance,
        lateral_variance_m2: &[f64; POINTS],
        k: f64,
    ) -> [f32; POINTS] {
        let CarriedCovariance { weight, scale2, .. } = *carried;
        let errors = HeightErrors { lateral_variance_m2, discrepancy: &Discrepancy::NONE, weight, scale2 };
        self.heights::<f64>(&carried.p, errors, k)
    }

    /// k sqrt(J P J^T + m^2 (y + (1 - s) w d + g^2)) of each height.
    fn heights<R: Real>(&self, p: &Square, errors: HeightErrors<'_>, k: f64) -> [f32; POINTS] {
        let p = narrow::<R, _, _>(p);
        let mut half = [0.0; POINTS];
        let at_rest = f64::from(self.factors.rest_noise_std_m);
        let misfits = self.surface_misfit.iter().zip(errors.discrepancy.left());
        let others = misfits.zip(errors.lateral_variance_m2);
        for ((half, ((d, left), lateral)), row) in half.iter_mut().zip(others).zip(&self.surface.data.0) {
            let row = LatentOf::<R>::from(row.map(R::of));
            let variance = row.dot(&(p * row)).wide()
                + errors.scale2 * lateral
                + errors.scale2 * left * errors.weight * f64::from(*d)
                + errors.scale2 * at_rest * at_rest;
            *half = (k * sqrt(variance.max(0.0))) as f32;
        }
        half
    }

    /// k of the field group at `slot`.
    fn field_factor(&self, slot: usize) -> f64 {
        self.factors.field.get(slot).copied().map_or(0.0, f64::from)
    }
}

/// k `turns` ahead, between those at the measured leads.
fn factor_at(at_leads: [f32; LEADS.len()], turns: usize) -> f64 {
    let factors = at_leads.map(f64::from);
    let [mut k, ..] = factors;
    for (lead, factor) in LEADS.array_windows::<2>().zip(factors.array_windows::<2>()) {
        let ([from, to], [near, far]) = (*lead, *factor);
        let way = turns.saturating_sub(from).min(to.saturating_sub(from)) as f64;
        let length = to.saturating_sub(from).max(1) as f64;
        k += way / length * (far - near);
    }
    k
}

/// Motion of the glass in a turn of a forecast.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Glass {
    /// As a plan says.
    Planned,
    /// Of a hand or a robot that nobody asked.
    Free,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::error_factors::ErrorFactors;
    use crate::uncertainty::error_model::tests::error_model;

    /// Errors of heights that nothing but latents and decoder add to.
    fn plain(weight: f64) -> HeightErrors<'static> {
        HeightErrors {
            lateral_variance_m2: &[0.0; POINTS],
            discrepancy: &Discrepancy::NONE,
            weight,
            scale2: 1.0,
        }
    }

    /// A height counts latents and decoder, a number of the field the input too.
    #[test]
    fn half_widths_add_up_what_is_not_known() {
        let covariance =
            Covariance { latents: Square::identity() * 0.04, input: 0.25, process_noise_scale: 1.0 };
        let interval = error_model().interval::<f64>(&IntervalInput {
            covariance: &covariance,
            lateral_variance_m2: &[0.0; POINTS],
            discrepancy: &Discrepancy::NONE,
            latent_energy: 0.9,
            heat: 0.0,
            energy_scale_j: 0.01,
            blind_turns: 0,
        });
        let half = 2.0 * sqrt(1e-4 * 0.04 + 1e-8);
        assert!((f64::from(interval.surface_m[7]) - half).abs() < 1e-8);
        assert!((f64::from(interval.field[0]) - 2.0).abs() < 1e-6, "the misfit alone: sqrt(4 w)");
        assert!((f64::from(interval.field[1]) - sqrt(9.0 * 0.25 + 4.0)).abs() < 1e-6);
        assert!((f64::from(interval.field[2]) - 0.01 * HEAT_FLOOR).abs() < 1e-9, "no heat: the floor alone");
    }

    /// The error at a surface at rest counts at rest as in a slosh, and not at all where a blob states none.
    #[test]
    fn the_error_at_rest_is_there_at_rest_too() {
        let (fine, nothing) = (error_model(), Square::zeros());
        let noisy =
            ErrorModel { factors: ErrorFactors { rest_noise_std_m: 3e-4, ..fine.factors }, ..fine.clone() };
        for w in [0.0, 1.0] {
            let [without, with] = [&fine, &noisy].map(|of| of.heights::<f64>(&nothing, plain(w), 2.0)[3]);
            assert!((without - 2.0 * sqrt(w * 1e-8) as f32).abs() < 1e-9);
            assert!((with - 2.0 * sqrt(w * 1e-8 + 9e-8) as f32).abs() < 1e-9);
        }
    }

    /// Without a measurement an estimate is worth less from turn to turn.
    #[test]
    fn forecasts_widen() {
        let errors = error_model();
        let mut p = Square::identity() * 1e-4;
        let mut last = 0.0;
        for _ in 0..10 {
            p = errors.transition * p * errors.transition.transpose() + errors.process * 0.5;
            let half = errors.heights::<f64>(&p, plain(0.5), 2.0)[0];
            assert!(half > last, "{half} after {last}");
            last = half;
        }
    }

    /// m scales a planned forecast whole. An acceleration that nobody planned is as large under any m.
    #[test]
    fn what_nobody_planned_is_not_scaled() {
        let kick = Latent::repeat(0.02);
        let covariance =
            Covariance { latents: Square::identity() * 1e-2, input: 0.0, process_noise_scale: 1.0 };
        let errors = error_model();
        let half_of = |scale: f64, planned: usize| {
            let mut carried = errors.carried(&covariance, 0.1, scale);
            for frames in 0..5 {
                errors.carry(&mut carried, &kick, Horizon { frames, planned }, 0.1);
            }
            f64::from(errors.carried_heights(&carried, &[1e-6; POINTS], Horizon { frames: 5, planned })[0])
        };
        assert!((half_of(3.0, 5) / half_of(1.0, 5) - 3.0).abs() < 1e-6);
        // The kicks alone: the variance of a free forecast less that of a planned one, both over k^2.
        let [free, planned] = [0, 5].map(|turns| [1.0, 3.0].map(|m| half_of(m, turns)));
        let [k_free, k_planned] = [error_model().factors.surface, error_model().factors.of_a_plan()]
            .map(|at_leads| factor_at(at_leads, 5));
        let variance = |half: f64, k: f64| half / k * (half / k);
        let [one, three] = [0, 1].map(|m| variance(free[m], k_free) - variance(planned[m], k_planned));
        assert!(one > 0.0 && (three / one - 1.0).abs() < 1e-4, "{one} and {three}");
    }

    /// k is the measured one at each lead, goes straight between two, and stays beyond the last.
    #[test]
    fn factors_go_straight_between_the_leads() {
        for (turns, due) in [(0, 2.0), (15, 4.0), (30, 3.0), (60, 3.0), (9, 3.2), (20, 4.0 - 1.0 / 3.0)] {
            let k = factor_at([2.0, 4.0, 3.0], turns);
            assert!((k - due).abs() < 1e-12, "{turns}: {k} for {due}");
        }
    }
}
