//! Latent and heat to the full field: a small trunk to coefficients, then one basis a group.
//!
//! ```text
//! c = T x + F u + W3 relu(W2 relu(W1 x + b1) + b2) + b3   coefficients of q, v, sigma, tau, surface
//! group = rest + basis c_group                            SI units
//! e = rest + basis s                                      s the heat in joules: no camera sees it
//! ```
//! F u is the inertial part of the pressure: it follows the acceleration of the glass at once and is
//! no state of the liquid, so no latent carries it. The bases are the linear last layers of the autoencoder (proper orthogonal modes folded in).

use crate::generic::LATENTS;
use crate::nn::{Matrix, Vector};
use crate::surface::POINTS;

/// Hidden units of a trunk layer that the decoder has room for.
pub const MAX_TRUNK: usize = 128;

/// Coefficients of all groups together that the decoder has room for.
pub const MAX_COEFFICIENTS: usize = 192;

/// Numbers of one tracer, by field group: q, v, e, sigma, tau.
pub const GROUP_COMPONENTS: [usize; 5] = [3, 3, 1, 3, 3];

/// Position of the internal energy among the groups.
pub const ENERGY_GROUP: usize = 2;

/// One group of the field.
#[derive(Clone, Copy, Debug)]
pub struct Group<'m> {
    /// The group at rest, SI units.
    pub rest: Vector<'m>,
    /// Coefficients to SI units, `[numbers, rank]`.
    pub basis: Matrix<'m>,
    /// First coefficient of the group in c.
    pub first: usize,
}

/// Weights of the decoder, read in place.
#[derive(Clone, Copy, Debug)]
pub struct Decoder<'m> {
    /// T, `[coefficients, LATENTS]`.
    pub linear: Matrix<'m>,
    /// F, `[coefficients]`.
    pub port: Vector<'m>,
    /// W1, W2, W3.
    pub weights: [Matrix<'m>; 3],
    /// b1, b2, b3.
    pub biases: [Vector<'m>; 3],
    /// q, v, e, sigma, tau.
    pub groups: [Group<'m>; 5],
    /// The profile: 21 heights in metres.
    pub surface: Group<'m>,
}

/// Coefficients of every group, a step of the decoder that both outputs share.
pub type Coefficients = [f32; MAX_COEFFICIENTS];

impl Decoder<'_> {
    /// c of a latent `x` and the port value `u` of the same instant.
    #[must_use]
    pub fn coefficients(&self, x: &[f32; LATENTS], u: f32) -> Coefficients {
        let mut c = [0.0; MAX_COEFFICIENTS];
        let [w1, w2, w3] = &self.weights;
        let [b1, b2, b3] = self.biases;
        let mut first = [0.0; MAX_TRUNK];
        layer(w1, b1, x, &mut first);
        relu(&mut first);
        let mut second = [0.0; MAX_TRUNK];
        layer(w2, b2, &first, &mut second);
        relu(&mut second);
        layer(w3, b3, &second, &mut c);
        self.linear.accumulate(x, &mut c);
        for (c, f) in c.iter_mut().zip(self.port) {
            *c += f * u;
        }
        c
    }

    /// The 21 heights of the surface, metres.
    #[must_use]
    pub fn surface(&self, c: &Coefficients) -> [f32; POINTS] {
        let mut heights = [0.0; POINTS];
        self.surface.expand(c, &mut heights);
        heights
    }

    /// The full field into the caller's buffer, group after group in SI units; `heat_j` in joules.
    /// A buffer of another length than 13 numbers a tracer is filled as far as it goes.
    pub fn field(&self, c: &Coefficients, heat_j: f32, out: &mut [f32]) {
        let mut rest = out;
        for (index, group) in self.groups.iter().enumerate() {
            let length = group.rest.len().min(rest.len());
            let Some((part, tail)) = rest.split_at_mut_checked(length) else { return };
            if index == ENERGY_GROUP {
                group.expand(&[heat_j], part);
            } else {
                group.expand(c, part);
            }
            rest = tail;
        }
    }
}

impl Group<'_> {
    /// rest + basis c.
    fn expand(&self, c: &[f32], out: &mut [f32]) {
        for (o, r) in out.iter_mut().zip(self.rest) {
            *o = *r;
        }
        self.basis.accumulate(c.get(self.first..).unwrap_or_default(), out);
    }
}

/// out = W x + b, as far as W has rows.
fn layer(w: &Matrix<'_>, b: Vector<'_>, x: &[f32], out: &mut [f32]) {
    for (o, b) in out.iter_mut().zip(b) {
        *o = *b;
    }
    w.accumulate(x, out);
}

/// max(0, x), element by element.
fn relu(x: &mut [f32]) {
    for x in x {
        *x = x.max(0.0);
    }
}
