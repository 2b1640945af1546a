//! Heights of the free surface as smooth sums over the particles, and the forces that belong to them.
//!
//! Over the cross-section A, with the waves `psi_j` of [`super::waves`] and `V_i = m_i/rho0`, the volume of liquid under a surface of
//! height `eta` weighs
//! ```text
//! M_j = sum_i V_i psi_j(x_i, y_i) = int psi_j eta dA,     eta = sum_j c_j psi_j,   c = G^-1 (M - M_rest)
//! ```
//! with `G_jj = int psi_j^2 dA`. No surface has to be found. Whatever acts on the surface by
//! generalised forces `q_j = dE/dc_j` (or friction of that form) acts on the particles by virtual work:
//! ```text
//! m_i a_i = -V_i grad p_s(x_i, y_i),     p_s = sum_j psi_j (G^-1 q)_j
//! ```
//! a horizontal body force with a potential, which in a liquid of constant density is the same as the
//! pressure `p_s` on its free surface. Energy is thus exchanged without loss: `sum v_i.m_i a_i = -q.c'`. At the wall it has no part through
//! the wall, so that the images of the liquid behind need none of it.
//! Within a step `c'` answers to `q` by `-B q dt` with the mobility
//! ```text
//! B = G^-1 [ sum_i V_i/rho0 grad psi.grad psi ] G^-1
//! ```
//! which stiff friction needs for its implicit step. Shorter waves see more of the grain than of the surface.

use super::many::{Press, Weigh};
use super::waves::{Coefficients, Place, Square, Waves};
use crate::particles::{Fluid, PIECE};
use rayon::prelude::*;

/// The surface as the particles have it.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    pub(super) waves: Waves,
    rest_density: f64,
    /// `B`, m/s per N s.
    pub(super) mobility: Square,
    rest: Coefficients,
    /// Deflection from rest, m.
    pub(super) height: Coefficients,
    /// Its rate at the last [`Self::follow`], m/s.
    pub(super) rate: Coefficients,
    /// Places of the particles when they were last weighed.
    places: Vec<Place>,
}

impl Columns {
    /// The columns of a liquid at rest over a circle of radius `radius_m`.
    pub(super) fn new(radius_m: f64, rest_density: f64, fluid: &Fluid) -> Self {
        let waves = Waves::new(radius_m);
        let mut inertia = Square::zeros();
        for (p, m) in fluid.particle.iter().zip(&fluid.mass) {
            let values = waves.at(p.x[0], p.x[1]);
            for axis in [1, 2] {
                let slope = Coefficients::from_fn(|j, _| values[j][axis]);
                inertia.ger(m / (rest_density * rest_density), &slope, &slope, 1.0);
            }
        }
        let zero = Coefficients::zeros();
        let inverse = Square::from_diagonal(&waves.inverse);
        let mobility = inverse * inertia * inverse;
        let mut columns =
            Self { waves, rest_density, mobility, rest: zero, height: zero, rate: zero, places: Vec::new() };
        columns.rest = columns.weigh(fluid, false).0;
        columns
    }

    /// `M` and, where `moving`, its rate.
    fn weigh(&mut self, fluid: &Fluid, moving: bool) -> (Coefficients, Coefficients) {
        let Self { waves, rest_density, places, .. } = self;
        places.resize(fluid.particle.len(), Place::default());
        let pieces = fluid.particle.par_chunks(PIECE).zip(fluid.mass.par_chunks(PIECE));
        let sums = pieces.zip(places.par_chunks_mut(PIECE)).map(|((particles, masses), places)| {
            let (mut sums, mut rates) = (Coefficients::zeros(), Coefficients::zeros());
            let (rest_density, wanted) = (*rest_density, moving.then_some(&mut rates));
            Weigh { waves, rest_density, particles, masses, places, sums: &mut sums, rates: wanted }.run();
            (sums, rates)
        });
        // In order, on one thread: the same bits from any number of them.
        let sums: Vec<_> = sums.collect();
        sums.into_iter().fold((Coefficients::zeros(), Coefficients::zeros()), |(a, b), (c, d)| (a + c, b + d))
    }

    /// Takes the heights of the present state.
    pub(super) fn rise(&mut self, fluid: &Fluid) {
        let (sum, _) = self.weigh(fluid, false);
        self.height = (sum - self.rest).component_mul(&self.waves.inverse);
    }

    /// Takes heights and rates of the present state.
    pub(super) fn follow(&mut self, fluid: &Fluid) {
        let (sum, rate) = self.weigh(fluid, true);
        self.height = (sum - self.rest).component_mul(&self.waves.inverse);
        self.rate = rate.component_mul(&self.waves.inverse);
    }

    /// `p_s` under the generalised forces `q` (N), by its waves, Pa.
    pub(super) fn pressure(&self, q: &Coefficients) -> Coefficients {
        q.component_mul(&self.waves.inverse)
    }

    /// Fills `out` with `p_s` and the accelerations along x and y that stand for it, where the particles were when they were
    /// last weighed.
    pub(super) fn push(&self, pressure: &Coefficients, out: &mut Vec<[f64; 3]>) {
        let Self { waves, rest_density, places, .. } = self;
        out.resize(places.len(), [0.0; 3]);
        let pieces = places.par_chunks(PIECE).zip(out.par_chunks_mut(PIECE));
        pieces.for_each(|(places, out)| {
            Press { waves, rest_density: *rest_density, pressure, places, out }.run();
        });
    }
}
