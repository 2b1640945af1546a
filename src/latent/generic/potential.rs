//! The energy H(x): convex, smallest at rest, with its gradient and its discrete gradient.
//!
//! ```text
//! H(x) = |K x|^2 / 2 + sum_i w_i^2 [ p(a_i) - p(b_i) - p'(b_i) (a_i - b_i) ],     a = W x + b,   p(a) = sqrt(1 + a^2)
//!      = |K x|^2 / 2 + sum_i w_i^2 d_i^2 / ( B_i (A_i B_i + 1 + a_i b_i) ),       d = W x,  A = p(a),  B = p(b)
//! grad H = K^T K x + W^T [ w^2 (a / A - b / B) ]
//! ```
//! With named effects x stands for S x in all of it, and the gradient is S^T times the above (see [`super::Slots`]).
//! The bracket is the Bregman divergence of the convex p; its second form has no cancellation. For every choice of
//! weights H is convex, H >= 0, H(0) = 0 and grad H(0) = 0: rest is an equilibrium, and the implicit step has one
//! solution and no more (see `step`). A free perceptron for H, which bends both ways, may have several, and which one a
//! solver finds is chance.

use super::newton::Square;
use super::{LATENTS, Latent};
use crate::latent::nn::{Matrix, Vector};
use crate::math::sqrt;

/// Ridges of H that the step has room for.
pub const MAX_HIDDEN: usize = 64;

/// Weights of the energy, read in place.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::latent::generic::Latent;
///
/// let energy = &model.generic.potential;
/// let (x, y) = (Latent::repeat(0.1), Latent::repeat(-0.2));
/// // The discrete gradient keeps the difference of energies exactly.
/// let mean = energy.discrete_gradient(&x, &energy.ridges(&x), &y, &energy.ridges(&y));
/// let difference = energy.value(&y) - energy.value(&x);
/// assert!((mean.dot(&(y - x)) - difference).abs() < 1e-9 * difference.abs());
/// assert_eq!(energy.value(&Latent::zeros()), 0.0);
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Potential<'m> {
    /// K, `[LATENTS, LATENTS]`.
    pub linear: Matrix<'m>,
    /// W, `[ridges, LATENTS]`.
    pub inward: Matrix<'m>,
    /// b, `[ridges]`.
    pub bias: Vector<'m>,
    /// w, `[ridges]`; only its square enters.
    pub weight: Vector<'m>,
    /// S: the energy is H(S x), where named effects bend it; none is 1.
    pub bend: Option<Square>,
}

/// Ridge terms of H at one state, which a step needs repeatedly at its fixed end.
#[derive(Clone, Copy, Debug)]
pub struct RidgeState {
    /// W S x.
    along: [f64; MAX_HIDDEN],
    /// p(W S x + b).
    bent: [f64; MAX_HIDDEN],
}

impl Potential<'_> {
    /// H(x).
    #[must_use]
    pub fn value(&self, x: &Latent) -> f64 {
        let mut kx = [0.0; LATENTS];
        self.linear.accumulate_f64(self.bend(x).as_slice(), &mut kx);
        let RidgeState { along, bent } = self.ridges(x);
        let ridges = along.iter().zip(bent).zip(self.bias).zip(self.weight);
        let bowed = ridges.map(|(((&d, a_bent), &b), &w)| {
            let (b, w) = (f64::from(b), f64::from(w));
            let b_bent = sqrt(1.0 + b * b);
            w * w * d * d / (b_bent * (a_bent * b_bent + 1.0 + (d + b) * b))
        });
        0.5 * kx.iter().map(|v| v * v).sum::<f64>() + bowed.sum::<f64>()
    }

    /// grad H(x).
    #[must_use]
    pub fn gradient(&self, x: &Latent) -> Latent {
        let ridges = self.ridges(x);
        self.discrete_gradient(x, &ridges, x, &ridges)
    }

    /// dH(x, y), the mean of grad H along the straight way from `x` to `y` (Harten, Lax and van Leer 1983), each with
    /// its ridge terms ([`Self::ridges`]):
    ///
    /// dH = K^T K (x + y) / 2 + W^T [ w^2 ( (a + a') / (A + A') - b / B ) ]
    ///
    /// The mean is exact, so that dH . (y - x) = H(y) - H(x), and nothing is divided by |y - x|.
    #[must_use]
    pub fn discrete_gradient(&self, x: &Latent, from: &RidgeState, y: &Latent, to: &RidgeState) -> Latent {
        let middle = self.bend(&((x + y) * 0.5));
        let mut kx = [0.0; LATENTS];
        self.linear.accumulate_f64(middle.as_slice(), &mut kx);
        let mut slope = [0.0; MAX_HIDDEN];
        let both = from.along.iter().zip(from.bent).zip(to.along.iter().zip(to.bent));
        let ridges = both.zip(self.bias.iter().zip(self.weight));
        for (slope, (((d, bent), (d_to, bent_to)), (&b, &w))) in slope.iter_mut().zip(ridges) {
            let (b, w) = (f64::from(b), f64::from(w));
            *slope = w * w * ((d + d_to + 2.0 * b) / (bent + bent_to) - b / sqrt(1.0 + b * b));
        }
        let mut gradient = Latent::zeros();
        self.linear.accumulate_transposed_f64(&kx, gradient.as_mut_slice());
        self.inward.accumulate_transposed_f64(&slope, gradient.as_mut_slice());
        self.bend.map_or(gradient, |s| s.transpose() * gradient)
    }

    /// S of [`super::newton`]: how dH(x, y) changes with y.
    #[must_use]
    pub(super) fn stiffness(&self, from: &RidgeState, to: &RidgeState) -> Square {
        let mut stiffness = Square::zeros();
        let rank_one = |stiffness: &mut Square, row: &Latent, weight: f64| {
            *stiffness += row * (row * weight).transpose();
        };
        for i in 0..self.linear.rows() {
            rank_one(&mut stiffness, &self.linear.row_f64(i), 0.5);
        }
        let both = from.along.iter().zip(from.bent).zip(to.along.iter().zip(to.bent));
        let ridges = both.zip(self.bias.iter().zip(self.weight)).enumerate();
        for (i, (((d, bent), (d_to, bent_to)), (&b, &w))) in ridges {
            let (b, w, sum) = (f64::from(b), f64::from(w), bent + bent_to);
            let bend = 1.0 / sum - (d + d_to + 2.0 * b) * (d_to + b) / (bent_to * sum * sum);
            rank_one(&mut stiffness, &self.inward.row_f64(i), w * w * bend.max(0.0));
        }
        self.bend.map_or(stiffness, |s| s.transpose() * stiffness * s)
    }

    /// S x.
    fn bend(&self, x: &Latent) -> Latent {
        self.bend.map_or(*x, |s| s * x)
    }

    /// The second derivative of H at rest.
    #[must_use]
    pub fn hessian(&self) -> Square {
        let rest = self.ridges(&Latent::zeros());
        // The discrete gradient moves half as much with one of its ends.
        self.stiffness(&rest, &rest) * 2.0
    }

    /// Returns the ridge terms of H at `x`.
    #[must_use]
    pub fn ridges(&self, x: &Latent) -> RidgeState {
        let mut along = [0.0; MAX_HIDDEN];
        self.inward.accumulate_f64(self.bend(x).as_slice(), &mut along);
        let mut bent = [1.0; MAX_HIDDEN];
        for ((bent, d), &b) in bent.iter_mut().zip(along).zip(self.bias) {
            let a = d + f64::from(b);
            *bent = sqrt(1.0 + a * a);
        }
        RidgeState { along, bent }
    }
}
