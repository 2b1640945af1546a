//! How far an estimate may be off: half-widths that hold nine times out of ten, from the covariance P of the error that
//! the filter carries (`runtime::filter`).
//!
//! ```text
//! half = k sqrt(J P J^T + y + (1 - s) w d + g^2)     of a height; of a field group without y, s and g, the mean over its numbers
//! P-   = A P A^T + a w Q + m dt^2 B B^T      of a forecast, turn by turn; m = 1 where the motion is not planned, else 0
//! ```
//! A is the closed step linearised about rest, Q the covariance of what the step misses, R that of what the encoder
//! misses, d what the decoder misses, each for a unit of w = floor + H(x): a livelier slosh is known less well; g is what is
//! missed of a surface at rest, which no slosh explains, y what a slosh across the line adds ([`crate::uncertainty::cross_axis`]), s the share
//! of w d that a measured height takes back ([`crate::uncertainty::discrepancy`]); a is what the filter has found of late of how well the step
//! suits the liquid. The errors are neither white nor Gaussian, so P only says how they spread over points and time; the size is put right by k, the 90 % quantile of |error| / half found on
//! recordings held out (split conformal: Lei et al., J. Am. Stat. Assoc. 113 (2018) 1094).

use crate::latent::generic::{Generic, LATENTS, Latent};
use crate::latent::nn::Vector;
use crate::math::sqrt;
use crate::surface::POINTS;
use crate::uncertainty::discrepancy::Discrepancy;
use nalgebra::SMatrix;

/// A matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Groups with a covariance of their own: q, v, sigma, tau.
pub const SPREAD_GROUPS: usize = 4;

/// Their places among the groups of the decoder.
pub(crate) const SPREAD_OF: [usize; SPREAD_GROUPS] = [0, 1, 3, 4];

/// Turns ahead for which a forecast's interval has been measured: now, 0.25 s, 0.5 s.
pub const LEADS: [usize; 3] = [0, 15, 30];

/// Numbers of the reach: the floor of w, k of the surface at each of [`LEADS`], k of q, v, e, sigma, tau. Behind them may stand
/// g, m; blobs from before it have none.
pub const REACH: usize = 1 + LEADS.len() + 5;

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

/// What a blob knows of its own errors, read in place.
#[derive(Clone, Debug)]
pub struct Spread<'m> {
    /// A.
    pub transition: Square,
    /// Q.
    pub process: Square,
    /// R^(-1/2): what the encoder reads, and misses, in these coordinates has independent errors of one.
    pub reading: Square,
    /// J of the surface, a column a point `[LATENTS, POINTS]`, m.
    pub surface: SMatrix<f64, LATENTS, POINTS>,
    /// J^T J of one number of q, v, sigma and tau, SI units.
    pub groups: [Square; SPREAD_GROUPS],
    /// What a unit of the port adds at once to one number of q, v, sigma and tau, mean square, SI units squared.
    pub pushed: [f64; SPREAD_GROUPS],
    /// d of the 21 heights, m2.
    pub surface_misfit: Vector<'m>,
    /// d of q, v, sigma, tau, SI units squared.
    pub group_misfit: Vector<'m>,
    /// floor and k, [`REACH`] numbers, and perhaps g.
    pub reach: Vector<'m>,
}

/// What the filter knows of its own errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// P of the latents.
    pub(crate) latents: Square,
    /// Variance of the port value of this instant.
    pub(crate) push: f64,
    /// How many times Q the step has been found to miss of late.
    pub(crate) stray: f64,
}

/// P before the first reading, when nothing is known: a slosh of H = 1, spread over all latents.
#[must_use]
pub(crate) fn unknown() -> Square {
    Square::identity() * (2.0 / LATENTS as f64)
}

impl Spread<'_> {
    /// w of a slosh of energy `slosh`, in units of H.
    pub(crate) fn weight(&self, slosh: f64) -> f64 {
        self.number(0) + slosh
    }

    /// Number `index` of the reach; a blob that has been loaded has them all but perhaps g, which then is zero.
    fn number(&self, index: usize) -> f64 {
        self.reach.get(index).copied().map_or(0.0, f64::from)
    }

    /// P- of a forecast's turn in which the step misses `missed` times Q; `planned` says whether the motion of the glass is.
    fn predict(&self, p: &mut Square, generic: &Generic<'_>, missed: f64, planned: bool) {
        let mut next = self.transition * *p * self.transition.transpose() + self.process * missed;
        if !planned {
            let kick = generic.port * generic.dt_s;
            next += kick * kick.transpose();
        }
        // A hostile blob may drive it anywhere; what is not finite says as much as knowing nothing.
        *p = if next.iter().all(|v| v.is_finite()) { next } else { unknown() };
    }

    /// The half-widths of an estimate with error covariance `p`, slosh energy and heat in units of H,
    /// `joules` to one of them; `raised` is what a slosh across the line adds to the variance of the heights, m2, `taken` what
    /// the measured heights take back of what the decoder misses.
    #[must_use]
    pub fn interval(
        &self,
        p: &Covariance,
        (raised, taken): (&[f64; POINTS], &Discrepancy),
        slosh: f64,
        heat: f64,
        joules: f64,
    ) -> Interval {
        let w = self.weight(slosh);
        let mut field = [0.0; 5];
        let groups = self.groups.iter().zip(self.pushed).zip(SPREAD_OF).zip(self.group_misfit);
        for (((group, pushed), slot), d) in groups {
            let trace: f64 = group.iter().zip(p.latents.iter()).map(|(j, v)| j * v).sum();
            if let Some(half) = field.get_mut(slot) {
                *half = self.half(1 + LEADS.len() + slot, trace + pushed * p.push + w * f64::from(*d));
            }
        }
        let energy = self.number(1 + LEADS.len() + 2) * joules * (heat + HEAT_FLOOR);
        if let Some(half) = field.get_mut(2) {
            *half = energy as f32;
        }
        Interval { surface_m: self.heights(&p.latents, (raised, taken), w, self.number(1)), field }
    }

    /// Half-widths of the surface `frames` turns after an estimate, m, when the motion of the glass is known for the
    /// first `planned` of them. With a plan for all, k is that of the present; else it goes straight between the leads
    /// that were measured, for which nobody knew how the glass moves on, and stays beyond the last.
    #[must_use]
    pub fn ahead(
        &self,
        p: Covariance,
        generic: &Generic<'_>,
        slosh: f64,
        raised: &[f64; POINTS],
        (frames, planned): (usize, usize),
    ) -> [f32; POINTS] {
        let missed = p.stray * self.weight(slosh);
        let mut p = p.latents;
        for ahead in 0..frames {
            self.predict(&mut p, generic, missed, ahead < planned);
        }
        let unplanned = if planned < frames { frames } else { 0 };
        let mut k = self.number(1);
        for (index, pair) in LEADS.array_windows::<2>().enumerate() {
            let [from, to] = *pair;
            let way = unplanned.saturating_sub(from).min(to.saturating_sub(from)) as f64;
            let length = to.saturating_sub(from).max(1) as f64;
            k += way / length * (self.number(index + 2) - self.number(index + 1));
        }
        self.heights(&p, (raised, &Discrepancy::NONE), self.weight(slosh), k)
    }

    /// k sqrt(J P J^T + y + (1 - s) w d + g^2) of each height; `raised` is y, `taken` s.
    fn heights(
        &self,
        p: &Square,
        (raised, taken): (&[f64; POINTS], &Discrepancy),
        w: f64,
        k: f64,
    ) -> [f32; POINTS] {
        let mut half = [0.0; POINTS];
        let grain = self.number(REACH);
        let misfits = self.surface_misfit.iter().zip(taken.left()).zip(raised);
        for ((half, ((d, left), raised)), row) in half.iter_mut().zip(misfits).zip(self.surface.column_iter())
        {
            let row: Latent = row.into_owned();
            let variance = row.dot(&(p * row)) + raised + left * w * f64::from(*d) + grain * grain;
            *half = (k * sqrt(variance.max(0.0))) as f32;
        }
        half
    }

    /// k of number `index` times the root of `variance`.
    fn half(&self, index: usize, variance: f64) -> f32 {
        (self.number(index) * sqrt(variance.max(0.0))) as f32
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const NOTHING: (&[f64; POINTS], &Discrepancy) = (&[0.0; POINTS], &Discrepancy::NONE);

    const REACHES: [f32; REACH] = [0.1, 2.0, 4.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0];

    /// J of one for the first latent at every point, nothing else.
    pub(crate) fn spread() -> Spread<'static> {
        Spread {
            transition: Square::identity() * 0.9,
            process: Square::identity() * 0.01,
            reading: Square::identity(),
            surface: SMatrix::from_fn(|i, _| if i == 0 { 0.01 } else { 0.0 }),
            groups: [Square::zeros(); SPREAD_GROUPS],
            pushed: [0.0, 9.0, 0.0, 0.0],
            surface_misfit: &[1e-8; POINTS],
            group_misfit: &[4.0; SPREAD_GROUPS],
            reach: &REACHES,
        }
    }

    /// A height counts latents and decoder, a number of the field the port value too.
    #[test]
    fn half_widths_add_up_what_is_not_known() {
        let spread = spread();
        let p = Covariance { latents: Square::identity() * 0.04, push: 0.25, stray: 1.0 };
        let slosh = 0.9;
        let interval = spread.interval(&p, NOTHING, slosh, 0.0, 0.01);
        let half = 2.0 * sqrt(1e-4 * 0.04 + 1e-8);
        assert!((f64::from(interval.surface_m[7]) - half).abs() < 1e-8);
        assert!((f64::from(interval.field[0]) - 2.0).abs() < 1e-6, "the misfit alone: sqrt(4 w)");
        assert!((f64::from(interval.field[1]) - sqrt(9.0 * 0.25 + 4.0)).abs() < 1e-6);
    }

    /// What a surface at rest is missed by counts at rest as in a slosh, and not at all where a blob says nothing of it.
    #[test]
    fn grain_is_there_at_rest_too() {
        const GRAINY: [f32; REACH + 1] = [0.1, 2.0, 4.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0, 3e-4];
        let (plain, nothing) = (spread(), Square::zeros());
        let grainy = Spread { reach: &GRAINY, ..plain.clone() };
        for w in [0.0, 1.0] {
            let [fine, coarse] = [&plain, &grainy].map(|of| of.heights(&nothing, NOTHING, w, 2.0)[3]);
            assert!((fine - 2.0 * sqrt(w * 1e-8) as f32).abs() < 1e-9);
            assert!((coarse - 2.0 * sqrt(w * 1e-8 + 9e-8) as f32).abs() < 1e-9);
        }
    }

    /// Without a measurement an estimate is worth less from turn to turn, and k is the measured one at its lead.
    #[test]
    fn forecasts_widen() {
        let spread = spread();
        let mut p = Square::identity() * 1e-4;
        let mut last = 0.0;
        for _ in 0..10 {
            p = spread.transition * p * spread.transition.transpose() + spread.process * 0.5;
            let half = spread.heights(&p, NOTHING, 0.5, 2.0)[0];
            assert!(half > last, "{half} after {last}");
            last = half;
        }
        let now = spread.heights(&p, NOTHING, 0.1, spread.number(1))[4];
        let twice = spread.heights(&p, NOTHING, 0.1, spread.number(2))[4];
        assert!((twice / now - 2.0).abs() < 1e-6);
    }
}
