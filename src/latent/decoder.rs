//! Latent and heat to the full field: a small trunk to coefficients, then one basis a group.
//!
//! ```text
//! c = T x + F u + W3 relu(W2 relu(W1 x + b1) + b2) + b3   coefficients of q, v, e, sigma, tau, surface
//! group = rest + basis c_group                            SI units
//! e = rest + basis (s, s c_e)                             s the heat in joules: no camera sees it
//! ```
//! The heat stays with the liquid that it was made in, and slosh carries it past the places of the field and back: its
//! pattern depends on the latents as a displacement does.
//! F u is the inertial part of the pressure: it follows the acceleration of the glass at once and is
//! no state of the liquid, so no latent carries it. The bases are the linear last layers of the autoencoder (proper orthogonal modes folded in).

use crate::latent::generic::LATENTS;
use crate::latent::nn::{Dense, Matrix, Vector, Weights, relu};
use crate::surface::POINTS;

/// Hidden units of a trunk layer that the decoder has room for (paper: 200).
pub const MAX_TRUNK: usize = 224;

/// Coefficients of all groups together that the decoder has room for (the paper's last layers: 120 + 3 x 200).
pub const MAX_COEFFICIENTS: usize = 768;

/// Columns of the basis of e that there is room for: the heat itself, and how its pattern moves.
pub const MAX_HEATED: usize = 8;

/// Numbers of one tracer, by field group: q, v, e, sigma, tau.
pub const GROUP_COMPONENTS: [usize; 5] = [3, 3, 1, 3, 3];

/// Position of the internal energy among the groups.
pub const ENERGY_GROUP: usize = 2;

/// Position of the normal stresses sigma among the groups.
pub const STRESS_GROUP: usize = 3;

/// Selection of field groups. The surface is always decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Selection([bool; 5]);

impl Selection {
    /// q, v, e, sigma and tau.
    pub const ALL: Self = Self([true; 5]);
    /// The surface alone: what a small board has time for.
    pub const NONE: Self = Self([false; 5]);

    /// With group `index` too (q 0, v 1, e 2, sigma 3, tau 4); another index changes nothing.
    #[must_use]
    pub fn with(mut self, index: usize) -> Self {
        if let Some(held) = self.0.get_mut(index) {
            *held = true;
        }
        self
    }

    /// The groups that are in both selections.
    #[must_use]
    pub fn both(self, other: Self) -> Self {
        Self(core::array::from_fn(|index| self.holds(index) && other.holds(index)))
    }

    /// Returns whether group `index` is selected.
    #[must_use]
    pub fn holds(self, index: usize) -> bool {
        self.0.get(index).copied().unwrap_or(false)
    }
}

impl Default for Selection {
    fn default() -> Self {
        Self::ALL
    }
}

/// One group of the field.
#[derive(Clone, Copy, Debug)]
pub struct Group<'m> {
    /// The group at rest, SI units.
    pub rest: Vector<'m>,
    /// Coefficients to SI units, `[numbers, rank]`; e has one coefficient fewer than columns.
    pub basis: Weights<'m>,
    /// First coefficient of the group in c.
    pub first: usize,
}

/// Weights of the decoder, read in place.
///
/// ```
/// # #[repr(align(64))]
/// # struct Aligned<T: ?Sized>(T);
/// # static BLOB: &Aligned<[u8]> =
/// #     &Aligned(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/models/glycerine.blob")));
/// let model = meniscus::blob::Model::load(&BLOB.0)?;
/// use meniscus::latent::decoder::Selection;
/// use meniscus::latent::generic::LATENTS;
///
/// // The surface at rest is flat at the fill height.
/// let coefficients = model.decoder.coefficients(&[0.0; LATENTS], 0.0);
/// let heights = model.decoder.surface(&coefficients);
/// assert!(heights.iter().all(|z| (f64::from(*z) - model.header.fill_m).abs() < 2e-3), "{heights:?}");
///
/// // Velocity and shear stress of all tracers, and nothing else.
/// let wanted = Selection::NONE.with(1).with(4);
/// let mut part = vec![0.0; model.decoder.part_len(wanted)];
/// assert_eq!(model.decoder.part(wanted, &coefficients, 0.0, &mut part), part.len());
/// # Ok::<(), meniscus::blob::LoadError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Decoder<'m> {
    /// T, `[coefficients, LATENTS]`.
    pub linear: Matrix<'m>,
    /// F, `[coefficients]`.
    pub port: Vector<'m>,
    /// W1 and b1, W2 and b2, W3 and b3.
    pub trunk: [Dense<'m>; 3],
    /// q, v, e, sigma, tau.
    pub groups: [Group<'m>; 5],
    /// The profile: 21 heights in metres.
    pub surface: Group<'m>,
}

/// Hidden layers of the trunk behind their ReLU; a unit is silent where it is not above zero.
pub(super) struct Hidden {
    pub(super) first: [f32; MAX_TRUNK],
    pub(super) second: [f32; MAX_TRUNK],
}

/// Coefficients of every group, a step of the decoder that both outputs share.
pub type Coefficients = [f32; MAX_COEFFICIENTS];

impl Decoder<'_> {
    /// c of a latent `x` and the port value `u` of the same instant.
    #[must_use]
    pub fn coefficients(&self, x: &[f32; LATENTS], u: f32) -> Coefficients {
        self.coefficients_behind(&self.hidden(x), x, u)
    }

    /// Values of both hidden layers of the trunk at a latent `x`.
    pub(super) fn hidden(&self, x: &[f32; LATENTS]) -> Hidden {
        let [one, two, _] = &self.trunk;
        let mut hidden = Hidden { first: [0.0; MAX_TRUNK], second: [0.0; MAX_TRUNK] };
        one.apply(x, &mut hidden.first);
        relu(&mut hidden.first);
        two.apply(&hidden.first, &mut hidden.second);
        relu(&mut hidden.second);
        hidden
    }

    /// [`Self::coefficients`] from the hidden layers at `x`.
    pub(super) fn coefficients_behind(&self, hidden: &Hidden, x: &[f32; LATENTS], u: f32) -> Coefficients {
        let mut c = [0.0; MAX_COEFFICIENTS];
        let [_, _, three] = &self.trunk;
        three.apply(&hidden.second, &mut c);
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
        self.surface.expand(c.get(self.surface.first..).unwrap_or_default(), &mut heights);
        heights
    }

    /// Mean square of what a unit of the port adds at once to a number of group `index`, SI units squared: the modes are
    /// orthonormal.
    #[must_use]
    pub(crate) fn pushed_square(&self, index: usize) -> f64 {
        let Some(group) = self.groups.get(index) else { return 0.0 };
        let port = self.port.iter().skip(group.first).take(group.basis.columns());
        let square: f64 = port.map(|&f| f64::from(f) * f64::from(f)).sum();
        square / (group.rest.len().max(1) as f64)
    }

    /// Returns the multipliers of the basis of e, (s, s c_e) with s = `heat_j` in joules; zeros behind its columns.
    #[must_use]
    pub fn heated(&self, c: &Coefficients, heat_j: f32) -> [f32; MAX_HEATED] {
        let [_, _, e, ..] = &self.groups;
        let moved = e.basis.columns().saturating_sub(1);
        let mut heated = [0.0; MAX_HEATED];
        let pattern = c.iter().skip(e.first).take(moved);
        for (out, c) in heated.iter_mut().zip(core::iter::once(&1.0).chain(pattern)) {
            *out = heat_j * c;
        }
        heated
    }

    /// The full field into the caller's buffer, group after group in SI units; `heat_j` in joules.
    /// A buffer of another length than 13 numbers a tracer is filled as far as it goes.
    pub fn field(&self, c: &Coefficients, heat_j: f32, out: &mut [f32]) {
        self.part(Selection::ALL, c, heat_j, out);
    }

    /// The groups of `selection` one after another, as [`Self::field`] lays them out; gives how many numbers
    /// were written. A group that is left out takes no time and no room.
    pub fn part(&self, selection: Selection, c: &Coefficients, heat_j: f32, out: &mut [f32]) -> usize {
        let mut rest = out;
        let mut written = 0_usize;
        for (index, group) in self.groups.iter().enumerate().filter(|(index, _)| selection.holds(*index)) {
            let length = group.rest.len().min(rest.len());
            let Some((part, tail)) = rest.split_at_mut_checked(length) else { return written };
            if index == ENERGY_GROUP {
                group.expand(&self.heated(c, heat_j), part);
            } else {
                group.expand(c.get(group.first..).unwrap_or_default(), part);
            }
            written = written.saturating_add(length);
            rest = tail;
        }
        written
    }

    /// Numbers that [`Self::part`] writes into a buffer with room for them.
    #[must_use]
    pub fn part_len(&self, selection: Selection) -> usize {
        let chosen = self.groups.iter().enumerate().filter(|(index, _)| selection.holds(*index));
        chosen.map(|(_, group)| group.rest.len()).sum()
    }
}

impl Group<'_> {
    /// rest + basis c, `c` the coefficients of the group.
    fn expand(&self, c: &[f32], out: &mut [f32]) {
        for (o, r) in out.iter_mut().zip(self.rest) {
            *o = *r;
        }
        self.basis.accumulate(c, out);
    }
}
