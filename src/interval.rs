//! How far an estimate may be off: the covariance P of the latent error, carried beside the filter, and
//! half-widths made from it that hold nine times out of ten.
//!
//! ```text
//! P- = A P A^T + w Q + m dt^2 B B^T          w = floor + H(x); m = 1 where the glass was not seen, else 0
//! P+ = (1 - G) P- (1 - G)^T + w G R G^T      where the encoder has read
//! half = k sqrt(J P J^T + w d)               of a height; of a field group, the mean of that over its numbers
//! ```
//! A is the closed step linearised about rest, Q and R the covariances of what the step and the encoder
//! miss, d what the decoder misses, each for a unit of w: a livelier slosh is known less well. The update is
//! Joseph's (Bucy and Joseph 1968), which keeps P positive for any gain. The errors are neither white nor
//! Gaussian, so P only says how they spread over points and time; the size is put right by k, the 90 %
//! quantile of |error| / half found on recordings held out (split conformal: Lei et al., J. Am. Stat.
//! Assoc. 113 (2018) 1094).

use crate::generic::{Generic, LATENTS, Latent};
use crate::math::sqrt;
use crate::nn::{Matrix, Vector};
use crate::surface::POINTS;
use nalgebra::SMatrix;

/// A matrix on latent space.
type Square = SMatrix<f64, LATENTS, LATENTS>;

/// Groups with a covariance of their own: q, v, sigma, tau.
pub const SPREAD_GROUPS: usize = 4;

/// Turns ahead for which a forecast's interval has been measured: now, 0.25 s, 0.5 s.
pub const LEADS: [usize; 3] = [0, 15, 30];

/// Numbers of the reach: the floor of w, k of the surface at each of [`LEADS`], k of q, v, e, sigma, tau.
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
    /// G.
    pub gain: Square,
    /// G R G^T.
    pub reading: Square,
    /// J of the surface, a column a point `[LATENTS, POINTS]`, m.
    pub surface: SMatrix<f64, LATENTS, POINTS>,
    /// J^T J of one number of q, v, sigma and tau, SI units.
    pub groups: [Square; SPREAD_GROUPS],
    /// d of the 21 heights, m2.
    pub surface_misfit: Vector<'m>,
    /// d of q, v, sigma, tau, SI units squared.
    pub group_misfit: Vector<'m>,
    /// floor and k, [`REACH`] numbers.
    pub reach: Vector<'m>,
}

/// P, as it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance(Square);

impl Default for Covariance {
    /// Before the first reading nothing is known: a slosh of H = 1, spread over all latents.
    fn default() -> Self {
        Self(Square::identity() * (2.0 / LATENTS as f64))
    }
}

impl Covariance {
    /// One that was found in another way.
    pub(crate) fn new(p: Square) -> Self {
        Self(p)
    }

    /// P.
    pub(crate) fn matrix(&self) -> &Square {
        &self.0
    }
}

/// The matrix whose entries `of` gives.
#[must_use]
pub fn square_of(of: &Matrix<'_>) -> Square {
    square_below(of, 0)
}

/// The matrix whose entries `of` gives from row `first` on.
#[must_use]
pub fn square_below(of: &Matrix<'_>, first: usize) -> Square {
    Square::from_fn(|i, j| f64::from(of.at(first.saturating_add(i), j)))
}

impl Spread<'_> {
    /// w of a slosh of energy `slosh`, in units of H.
    pub(crate) fn weight(&self, slosh: f64) -> f64 {
        self.number(0) + slosh
    }

    /// Number `index` of the reach; a blob that has been loaded has them all.
    fn number(&self, index: usize) -> f64 {
        self.reach.get(index).copied().map_or(0.0, f64::from)
    }

    /// P- of a turn from a slosh of energy `slosh`; `moved` says whether the motion of the glass was seen.
    pub fn predict(&self, p: &mut Covariance, generic: &Generic<'_>, slosh: f64, moved: bool) {
        let mut next =
            self.transition * p.0 * self.transition.transpose() + self.process * self.weight(slosh);
        if !moved {
            let kick = generic.port * generic.dt_s;
            next += kick * kick.transpose();
        }
        // A hostile blob may drive it anywhere; what is not finite says as much as knowing nothing.
        *p = if next.iter().all(|v| v.is_finite()) { Covariance(next) } else { Covariance::default() };
    }

    /// P+ of a reading.
    pub fn correct(&self, p: &mut Covariance, slosh: f64) {
        let rest = Square::identity() - self.gain;
        let next = rest * p.0 * rest.transpose() + self.reading * self.weight(slosh);
        *p = if next.iter().all(|v| v.is_finite()) { Covariance(next) } else { Covariance::default() };
    }

    /// The half-widths of an estimate with error covariance `p`, slosh energy and heat in units of H,
    /// `joules` to one of them.
    #[must_use]
    pub fn interval(&self, p: &Covariance, slosh: f64, heat: f64, joules: f64) -> Interval {
        let w = self.weight(slosh);
        let mut field = [0.0; 5];
        let of_groups = [0, 1, 3, 4];
        for ((group, slot), d) in self.groups.iter().zip(of_groups).zip(self.group_misfit) {
            let trace: f64 = group.iter().zip(p.0.iter()).map(|(j, v)| j * v).sum();
            if let Some(half) = field.get_mut(slot) {
                *half = self.half(1 + LEADS.len() + slot, trace + w * f64::from(*d));
            }
        }
        let energy = self.number(1 + LEADS.len() + 2) * joules * (heat + HEAT_FLOOR);
        if let Some(half) = field.get_mut(2) {
            *half = energy as f32;
        }
        Interval { surface_m: self.heights(p, w, self.number(1)), field }
    }

    /// Half-widths of the surface `frames` turns after an estimate, m, when the motion of the glass is known for the
    /// first `planned` of them. With a plan for all, k is that of the present; else it goes straight between the leads
    /// that were measured, for which nobody knew how the glass moves on, and stays beyond the last.
    #[must_use]
    pub fn ahead(
        &self,
        mut p: Covariance,
        generic: &Generic<'_>,
        slosh: f64,
        (frames, planned): (usize, usize),
    ) -> [f32; POINTS] {
        for ahead in 0..frames {
            self.predict(&mut p, generic, slosh, ahead < planned);
        }
        let unplanned = if planned < frames { frames } else { 0 };
        let mut k = self.number(1);
        for (index, pair) in LEADS.array_windows::<2>().enumerate() {
            let [from, to] = *pair;
            let way = unplanned.saturating_sub(from).min(to.saturating_sub(from)) as f64;
            let length = to.saturating_sub(from).max(1) as f64;
            k += way / length * (self.number(index + 2) - self.number(index + 1));
        }
        self.heights(&p, self.weight(slosh), k)
    }

    /// k sqrt(J P J^T + w d) of each height.
    fn heights(&self, p: &Covariance, w: f64, k: f64) -> [f32; POINTS] {
        let mut half = [0.0; POINTS];
        for ((half, d), row) in half.iter_mut().zip(self.surface_misfit).zip(self.surface.column_iter()) {
            let row: Latent = row.into_owned();
            let variance = row.dot(&(p.0 * row)) + w * f64::from(*d);
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
mod tests {
    use super::*;
    use nalgebra::SymmetricEigen;

    const REACHES: [f32; REACH] = [0.1, 2.0, 4.0, 3.0, 1.0, 1.0, 1.0, 1.0, 1.0];

    /// J of one for the first latent at every point, nothing else.
    fn spread() -> Spread<'static> {
        Spread {
            transition: Square::identity() * 0.9,
            process: Square::identity() * 0.01,
            gain: Square::identity() * 0.5,
            reading: Square::identity() * (0.25 * 0.02),
            surface: SMatrix::from_fn(|i, _| if i == 0 { 0.01 } else { 0.0 }),
            groups: [Square::zeros(); SPREAD_GROUPS],
            surface_misfit: &[1e-8; POINTS],
            group_misfit: &[4.0; SPREAD_GROUPS],
            reach: &REACHES,
        }
    }

    /// The scalar filter that every direction is here: its steady variance solves
    /// p = 0.25 (0.81 p + q w) + 0.25 r w.
    #[test]
    fn covariance_settles_where_theory_says() {
        let spread = spread();
        let mut p = Covariance::default();
        let slosh = 0.9;
        for _ in 0..60 {
            let kept = spread.transition * p.0 * spread.transition.transpose();
            p.0 = kept + spread.process * spread.weight(slosh);
            spread.correct(&mut p, slosh);
        }
        let due = 0.25 * (0.01 + 0.02) / (1.0 - 0.25 * 0.81);
        assert!((p.0[(3, 3)] / due - 1.0).abs() < 1e-7, "{} against {due}", p.0[(3, 3)]);
        assert!(SymmetricEigen::new(p.0).eigenvalues.min() > 0.0);
        let interval = spread.interval(&p, slosh, 0.0, 0.01);
        let half = 2.0 * sqrt(1e-4 * due + 1e-8);
        assert!((f64::from(interval.surface_m[7]) - half).abs() < 1e-8);
        assert!((f64::from(interval.field[1]) - 2.0).abs() < 1e-6, "the misfit alone: sqrt(4 w)");
    }

    /// Without a measurement an estimate is worth less from turn to turn, and k is the measured one at its lead.
    #[test]
    fn forecasts_widen() {
        let spread = spread();
        let mut p = Covariance(Square::identity() * 1e-4);
        let mut last = 0.0;
        for _ in 0..10 {
            p.0 = spread.transition * p.0 * spread.transition.transpose() + spread.process * 0.5;
            let half = spread.heights(&p, 0.5, 2.0)[0];
            assert!(half > last, "{half} after {last}");
            last = half;
        }
        let now = spread.heights(&p, 0.1, spread.number(1))[4];
        let twice = spread.heights(&p, 0.1, spread.number(2))[4];
        assert!((twice / now - 2.0).abs() < 1e-6);
    }
}
