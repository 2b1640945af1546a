//! The energy H(x): convex, smallest at rest, with its gradient and its discrete gradient.
//!
//! ```text
//! H(x) = |K x|^2 / 2 + sum_i w_i^2 [ p(a_i) - p(b_i) - p'(b_i) (a_i - b_i) ],     a = W x + b,   p(a) = sqrt(1 + a^2)
//!      = |K x|^2 / 2 + sum_i w_i^2 d_i^2 / ( B_i (A_i B_i + 1 + a_i b_i) ),       d = W x,  A = p(a),  B = p(b)
//! grad H = K^T K x + W^T [ w^2 (a / A - b / B) ]
//! ```
//! With named effects x stands for S x in all of it, and the gradient is S^T times the above (see [`super::Slots`]).
//! The bracket is the Bregman divergence of the convex p. Its second form has no cancellation, and neither has the form in
//! which the code takes the slope of a ridge:
//!
//! ```text
//! a / A - b / B = d l(a) ,      l(a) = (A B + 1 - a b) / ( (A + B) A B )
//! ```
//! A liquid that has nearly come to rest (d << b) otherwise loses all digits of it. For every choice of
//! weights H is convex, H >= 0, H(0) = 0 and grad H(0) = 0: rest is an equilibrium, and the implicit step has one
//! solution and no more (see `step`). A free perceptron for H, which bends both ways, may have several, and which one a
//! solver finds is chance.

use super::newton::{Square, SquareOf};
use super::{LATENTS, Latent, LatentOf};
use crate::latent::nn::{Matrix, Vector};
use crate::real::{Real, narrow};

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
pub struct RidgeState<R = f64> {
    /// W S x.
    along: [R; MAX_HIDDEN],
    /// p(W S x + b).
    bent: [R; MAX_HIDDEN],
    /// A d l(a): slope of the ridge times A.
    slope: [R; MAX_HIDDEN],
}

impl Potential<'_> {
    /// H(x).
    #[must_use]
    pub fn value<R: Real>(&self, x: &LatentOf<R>) -> R {
        let one = R::from(1.0);
        let mut kx = [R::default(); LATENTS];
        self.linear.accumulate_exact(self.bend(x).as_slice(), &mut kx);
        let RidgeState { along, bent, .. } = self.ridges(x);
        let ridges = along.iter().zip(bent).zip(self.bias).zip(self.weight);
        let bowed = ridges.map(|(((&d, a_bent), &b), &w)| {
            let (b, w) = (R::from(b), R::from(w));
            let b_bent = (one + b * b).root();
            w * w * d * d / (b_bent * (a_bent * b_bent + one + (d + b) * b))
        });
        R::from(0.5) * kx.iter().map(|v| *v * *v).sum::<R>() + bowed.sum::<R>()
    }

    /// grad H(x).
    #[must_use]
    pub fn gradient<R: Real>(&self, x: &LatentOf<R>) -> LatentOf<R> {
        let ridges = self.ridges(x);
        self.discrete_gradient(x, &ridges, x, &ridges)
    }

    /// dH(x, y), the mean of grad H along the straight way from `x` to `y` (Harten, Lax and van Leer 1983), each with
    /// its ridge terms ([`Self::ridges`]):
    ///
    /// ```text
    /// dH = K^T K (x + y) / 2 + W^T [ w^2 ( (a + a') / (A + A') - b / B ) ]
    ///    = K^T K (x + y) / 2 + W^T [ w^2 ( A d l(a) + A' d' l(a') ) / (A + A') ]
    /// ```
    /// The mean is exact, so that dH . (y - x) = H(y) - H(x), and nothing is divided by |y - x|.
    #[must_use]
    pub fn discrete_gradient<R: Real>(
        &self,
        x: &LatentOf<R>,
        from: &RidgeState<R>,
        y: &LatentOf<R>,
        to: &RidgeState<R>,
    ) -> LatentOf<R> {
        let middle = self.bend(&((x + y) * R::from(0.5)));
        let mut kx = [R::default(); LATENTS];
        self.linear.accumulate_exact(middle.as_slice(), &mut kx);
        let mut slope = [R::default(); MAX_HIDDEN];
        let both = from.slope.iter().zip(from.bent).zip(to.slope.iter().zip(to.bent));
        for (mean, (((own, bent), (own_to, bent_to)), &w)) in slope.iter_mut().zip(both.zip(self.weight)) {
            let w = R::from(w);
            *mean = w * w * ((*own + *own_to) / (bent + bent_to));
        }
        let mut gradient = LatentOf::zeros();
        self.linear.accumulate_transposed(&kx, gradient.as_mut_slice());
        self.inward.accumulate_transposed(&slope, gradient.as_mut_slice());
        self.bend.map_or(gradient, |s| narrow(&s.transpose()) * gradient)
    }

    /// S of [`super::newton`]: how dH(x, y) changes with y.
    #[must_use]
    pub(super) fn stiffness<R: Real>(&self, from: &RidgeState<R>, to: &RidgeState<R>) -> SquareOf<R> {
        let (one, two) = (R::from(1.0), R::from(2.0));
        let mut stiffness = SquareOf::zeros();
        let rank_one = |stiffness: &mut SquareOf<R>, row: &LatentOf<R>, weight: R| {
            *stiffness += row * (row * weight).transpose();
        };
        for i in 0..self.linear.rows() {
            rank_one(&mut stiffness, &self.linear.row(i), R::from(0.5));
        }
        let both = from.along.iter().zip(from.bent).zip(to.along.iter().zip(to.bent));
        let ridges = both.zip(self.bias.iter().zip(self.weight)).enumerate();
        for (i, (((d, bent), (d_to, bent_to)), (&b, &w))) in ridges {
            let (b, w, sum) = (R::from(b), R::from(w), bent + bent_to);
            let bend = one / sum - (*d + *d_to + two * b) * (*d_to + b) / (bent_to * sum * sum);
            rank_one(&mut stiffness, &self.inward.row(i), w * w * bend.larger(R::default()));
        }
        self.bend.map_or(stiffness, |s| narrow::<R, _, _>(&s.transpose()) * stiffness * narrow::<R, _, _>(&s))
    }

    /// S x.
    fn bend<R: Real>(&self, x: &LatentOf<R>) -> LatentOf<R> {
        self.bend.map_or(*x, |s| narrow(&s) * x)
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
    pub fn ridges<R: Real>(&self, x: &LatentOf<R>) -> RidgeState<R> {
        let one = R::from(1.0);
        let mut along = [R::default(); MAX_HIDDEN];
        self.inward.accumulate_exact(self.bend(x).as_slice(), &mut along);
        let (mut bent, mut slope) = ([one; MAX_HIDDEN], [R::default(); MAX_HIDDEN]);
        for (((bent, slope), d), &b) in bent.iter_mut().zip(&mut slope).zip(along).zip(self.bias) {
            let b = R::from(b);
            let (a, b_bent) = (d + b, (one + b * b).root());
            *bent = (one + a * a).root();
            *slope = d * ((*bent * b_bent + one - a * b) / ((*bent + b_bent) * b_bent));
        }
        RidgeState { along, bent, slope }
    }
}
